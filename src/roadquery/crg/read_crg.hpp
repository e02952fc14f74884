// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads OpenCRG files (*.crg), ASAM OpenCRG 1.0 to 1.2: formatted (LRFI, LDFI) and binary (KRBI, KDBI).

#include <string>
#include <string_view>

#include "roadquery/crg/crg.hpp"

namespace roadquery {

/// Values stand as in the file: options and modifiers are kept beside them (CrgFile), and named in the notes. Where the
/// header says how the reference line ends, what its steps miss that end by is spread over its length. A binary block
/// from which a text transfer took bytes (CR LF became LF) is mended (crg_newlines.hpp), with a note.
/// Throws std::runtime_error "file: line 7: what", or with the record of a binary block.
[[nodiscard]] CrgFile read_crg(const std::string& path);

/// The same of bytes in memory; `name` stands before what is wrong.
[[nodiscard]] CrgFile parse_crg(std::string_view bytes, const std::string& name);

/// Characters (text) or bytes (binary) of a value.
[[nodiscard]] std::size_t value_size(CrgFormat format);
[[nodiscard]] bool is_text(CrgFormat format);
/// Lines of text data and blocks of binary data are this long.
constexpr std::size_t crg_record_bytes = 80;

}  // namespace roadquery

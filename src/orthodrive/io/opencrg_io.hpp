#pragma once
// OpenCRG files (*.crg), ASAM OpenCRG 1.1 and 1.2: formatted (LRFI, LDFI) and binary (KRBI, KDBI).

#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/model/crg.hpp"

namespace orthodrive::io {

struct CrgFile {
  CrgSurface surface;
  CrgFormat format = CrgFormat::krbi;
  std::vector<std::string> notes;  ///< what of the file is not applied or was mended, each one sentence
};

/// Reads any of the four formats. Options and modifiers ($ROAD_CRG_OPTS, _MODS, _MPRO) are named in the notes and not
/// applied; where the header says how the reference line ends, what its steps miss that end by is spread over its
/// length. A binary block from which a text transfer took bytes (CR LF became LF) is mended (crg_newlines.hpp), with a
/// note. Throws InputError with the line, or the record of a binary block.
[[nodiscard]] CrgFile read_crg(const std::filesystem::path& path);

/// Writes phi, and slope, banking where they are not zero; start and end of every channel are in the header in full
/// precision. kdbi keeps every value, krbi 24 bits of it, ldfi 17 and lrfi 7 decimals (fewer where the column is full:
/// 20 and 10 characters). Same surface, same bytes. Throws Error for a value too large for its column.
void write_crg(const std::filesystem::path& path, const CrgSurface& surface, CrgFormat format);

}  // namespace orthodrive::io

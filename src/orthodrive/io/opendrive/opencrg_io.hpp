// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenCRG files (*.crg), ASAM OpenCRG 1.1 and 1.2: formatted (LRFI, LDFI) and binary (KRBI, KDBI).

#include <filesystem>

#include "orthodrive/model/roads/crg_geometry.hpp"

namespace orthodrive::io {

using roadquery::CrgFile;

/// roadquery/read_crg.hpp, which reads for everyone; throws InputError for what that throws.
[[nodiscard]] CrgFile read_crg(const std::filesystem::path& path);

/// Writes phi, and slope, banking where they are not zero; start and end of every channel are in the header in full
/// precision. kdbi keeps every value, krbi 24 bits of it, ldfi 17 and lrfi 7 decimals (fewer where the column is full:
/// 20 and 10 characters). Same surface, same bytes. Throws Error for a value too large for its column.
void write_crg(const std::filesystem::path& path, const CrgSurface& surface, CrgFormat format);

}  // namespace orthodrive::io

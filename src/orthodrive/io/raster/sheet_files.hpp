// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a downloaded sheet of an orthophoto or a terrain model holds.

#include <filesystem>
#include <string>
#include <vector>

namespace orthodrive::io {

/// GDAL's names of the rasters in a file that came from a server: the file itself (gzip, too), or the rasters of a ZIP
/// archive in the order of their names, without pictures that have no place on earth beside others that have one.
/// Throws InputError that begins with `shown` for what is no raster, an archive without one, and an archive of more
/// than 10 000 entries or with one of more than 16 GB.
[[nodiscard]] std::vector<std::string> rasters_in(const std::filesystem::path& file, const std::string& shown);

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#pragma once
// An index of sheets: features with a footprint and attributes, in any vector format that GDAL reads, also zipped.

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::io {

struct IndexedSheet {
  MultiPolygon footprint;                                       ///< degrees, x = longitude
  std::vector<std::pair<std::string, std::string>> attributes;  ///< texts and numbers that are set, in their order
};

/// Calls `take` for every feature whose footprint's box meets `box` (degrees), in the order of the file. A footprint is
/// a polygon, or the box of another geometry that has an area. Throws InputError that begins with `shown` for what is
/// no vector file, one without polygons, one whose CRS is not named and cannot be degrees, and more than 10 million
/// features.
void visit_sheet_index(const std::filesystem::path& file, const std::string& shown, const Box2& box,
                       const std::function<void(IndexedSheet&&)>& take);

}  // namespace orthodrive::io

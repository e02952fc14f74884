// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a map says that people live and work: inside and outside of towns the law has different limits.

#include <filesystem>
#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// landuse=residential, commercial, retail and industrial of OSM files, ways and multipolygons, near a site.
class BuiltUpAreas {
 public:
  /// Reads each file three times and keeps what the areas need. Areas that the files have in part are left out.
  BuiltUpAreas(const std::vector<std::filesystem::path>& files, const SiteFrame& site);
  [[nodiscard]] bool empty() const { return areas_.empty(); }
  /// Whether a place (m, CRS of the site) lies in one, or within 25 m of one: roads often lie between two of them.
  [[nodiscard]] bool holds(Vec2 place) const;

 private:
  /// All segments of the rings of one area, in any order: a place lies in it where a ray crosses an odd number.
  using Area = std::vector<std::pair<Vec2, Vec2>>;
  std::vector<Area> areas_;
  SpatialIndex index_;
};

}  // namespace orthodrive::io

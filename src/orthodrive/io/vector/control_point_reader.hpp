// SPDX-License-Identifier: Apache-2.0
#pragma once
// Height control points out of vector files.

#include <filesystem>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/height_control.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

struct ControlPoints {
  std::vector<HeightControlPoint> points;  ///< site CRS, in the order of the files
  Findings findings;                       ///< "control_points.outside_area": left out
};

/// Points of GeoJSON, GeoPackage and what else `read_features` reads. Fields: z_m, clearance_m (one of them at least),
/// sigma_m, osm_id, layer; others do not count. Throws InputError, with the number of the point, for values that are
/// missing, no numbers or out of range, and for features that are no single points.
[[nodiscard]] ControlPoints read_control_points(const std::vector<std::filesystem::path>& files, const SiteFrame& site);

}  // namespace orthodrive::io

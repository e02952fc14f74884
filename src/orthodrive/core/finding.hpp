// SPDX-License-Identifier: Apache-2.0
#pragma once
// Odd but not fatal: what a stage went on with, and where. Findings become points of findings.geojson.

#include <string>
#include <vector>

namespace orthodrive {

enum class Severity { info, warning, error };

struct Finding {
  Severity severity = Severity::warning;
  std::string code;     ///< short and stable, e.g. "refine.no_road_seen"
  std::string message;  ///< one sentence with the numbers
  double x_m = 0.0;     ///< site CRS, easting
  double y_m = 0.0;     ///< site CRS, northing
};

using Findings = std::vector<Finding>;

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// A lap in the formats of other programs.

#include <string>

#include "orthodrive/drive/drive_route.hpp"

namespace orthodrive {

/// GPX 1.1: the car's place ten times a second as WGS84 longitude and latitude with ele (heights of the site as they
/// are) and time, which counts from 2000-01-01T00:00:00Z because a simulated lap has no date. `crs`: of the samples,
/// any text that PROJ understands. Throws Error when it does not.
[[nodiscard]] std::string lap_gpx(const DriveResult& result, const std::string& crs);

/// ASAM OpenSCENARIO XML 1.2: one car that follows the driven way in time (FollowTrajectoryAction, a polyline with ten
/// vertices a second; position of the middle of the rear axle on the road, as the standard wants; heading, pitch and
/// roll of the body). `network`: how the scenario names the OpenDRIVE file.
[[nodiscard]] std::string lap_openscenario(const DriveResult& result, const std::string& network);

}  // namespace orthodrive

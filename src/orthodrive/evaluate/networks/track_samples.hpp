// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the tyres of an axle feel along a path of lanes, for judge_network.

#include <array>
#include <cstddef>
#include <vector>

#include "orthodrive/evaluate/networks/judge_network.hpp"
#include "orthodrive/evaluate/networks/lane_pieces.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive::evaluate {

/// A place of a path: where the middle of the axle is.
struct PathPoint {
  const LanePiece* piece = nullptr;
  double s = 0.0;  ///< of the piece's road
};

struct WheelSample {
  double x = 0.0, y = 0.0, z = 0.0;
  double friction = 1.0;
  bool on_road = false;
};

struct AxleSample {
  PathPoint at;
  double driven_m = 0.0;  ///< of the middle, from the start of the path
  double heading_rad = 0.0, curvature = 0.0, width_m = 0.0;
  double speed_mps = 0.0;  ///< the legal one, or less in bends
  double track_m = 0.0;
  std::array<WheelSample, 2> wheels;  ///< left, right
  [[nodiscard]] double z() const { return 0.5 * (wheels[0].z + wheels[1].z); }
  [[nodiscard]] double roll() const { return (wheels[0].z - wheels[1].z) / track_m; }
  [[nodiscard]] bool on_road() const { return wheels[0].on_road && wheels[1].on_road; }
};

/// Places of a piece between two driven distances, evenly and at most `step_m` apart, both ends among them.
void append_places(const LanePiece& piece, double from_m, double to_m, double step_m, std::vector<PathPoint>& path);

/// One wheel after the other with a cursor of its own, as tyres ask. Places where the lane is too narrow end a run, and
/// so do places without a road; every run is one vector.
[[nodiscard]] std::vector<std::vector<AxleSample>> sample_axles(const roadquery::RoadQuery& query,
                                                                const std::vector<PathPoint>& path,
                                                                const JudgeNetworkOptions& options);

/// A point of a lane, `left_m` to the left of its middle in driving direction.
[[nodiscard]] roadquery::SurfacePoint lane_point(const PathPoint& at, double left_m);

}  // namespace orthodrive::evaluate

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the tyres of an axle feel along a path of lanes, for judge_network.

#include <array>
#include <cstddef>
#include <vector>

#include "orthodrive/evaluate/networks/lane_pieces.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive::evaluate {

/// The car that a network is judged for. docs/evaluate.md has the reasons.
namespace judged {
constexpr double step_m = 0.1;                // between the samples along a track
constexpr double track_m = 1.5;               // between the wheels of an axle; narrower lanes: their width less 0.4 m
constexpr double wheelbase_m = 2.7;           // also the shortest arm over which vertical curvature is taken
constexpr double unlimited_speed_mps = 50.0;  // where there is no speed limit (raceways)
constexpr double lateral_mps2 = 4.0;          // bends are driven so fast that this is reached, at most
constexpr double least_lane_m = 1.8;          // narrower places of a lane (tapers) are not driven
}  // namespace judged

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
                                                                const std::vector<PathPoint>& path);

/// A point of a lane, `left_m` to the left of its middle in driving direction.
[[nodiscard]] roadquery::SurfacePoint lane_point(const PathPoint& at, double left_m);

}  // namespace orthodrive::evaluate

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Can every road of a network be driven? Both wheel tracks of every driving lane are followed through every link, and
// what a tyre feels there is held against limits.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// What can be wrong with a road for a car that drives on it.
enum class FaultKind : std::uint8_t {
  hole,                   ///< no road under a tyre, m of the track
  step,                   ///< of the surface within 0.1 m, m
  vertical_acceleration,  ///< by gradient kinks and short vertical curves at the legal speed, m/s2
  twist,                  ///< change of the slope across within a wheelbase, rad
  gap,                    ///< between the ends of linked lanes, m
  heading_jump,           ///< of the lane's middle, rad
  curvature_jump,  ///< outside junctions, as a jump of the lateral acceleration at the speed that the bend allows, m/s2
  width_jump,      ///< between linked lanes, m
  grip_jump        ///< larger over smaller friction, from place to place and between left and right
};
constexpr std::size_t fault_kinds = 9;
[[nodiscard]] const char* to_string(FaultKind kind);

/// Largest value that passes, in the unit of the kind. docs/evaluate.md has the reasons.
[[nodiscard]] double driving_limit(FaultKind kind);

struct JudgeNetworkOptions {
  int threads = 0;                   ///< 0 = all cores; the result does not depend on it
  LoopExchange* exchange = nullptr;  ///< with other processes that judge the same network; nor on it
};

/// A place that fails; of all samples within 5 m the worst.
struct Fault {
  FaultKind kind = FaultKind::hole;
  double value = 0.0;  ///< in the unit of the kind
  double limit = 0.0;
  double x = 0.0, y = 0.0;  ///< CRS of the map
  int road = 0, lane = 0;   ///< ids; at a link those of the lane that is left
  double s = 0.0;           ///< of that road
};
template <typename Archive>
void fields(Archive& archive, Fault& f) {
  archive(f.kind, f.value, f.limit, f.x, f.y, f.road, f.lane, f.s);
}

struct NetworkVerdict {
  std::array<double, fault_kinds> worst{};        ///< largest value of each kind, by FaultKind
  std::array<std::size_t, fault_kinds> places{};  ///< that fail
  std::vector<Fault> faults;                      ///< by kind, worst first
  double track_length_m = 0.0;                    ///< of all wheel tracks followed
  std::size_t lanes = 0, links = 0;
  [[nodiscard]] bool pass() const { return faults.empty(); }
};

/// Links to roads or lanes that are not there count nothing here (evaluate_network has them). An empty map passes.
/// Linear in the length of the lanes. Throws what RoadQuery throws.
[[nodiscard]] NetworkVerdict judge_network(const roadquery::RoadMap& map, const JudgeNetworkOptions& options = {},
                                           Monitor* monitor = nullptr);

}  // namespace orthodrive

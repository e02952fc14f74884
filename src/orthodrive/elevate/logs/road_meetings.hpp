// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 3 of fuse_drive_logs: which chains a drive changes. Those that were driven on, and those that meet them within
// the reach of a correction.

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "orthodrive/elevate/logs/driven_samples.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/roads/log_chains.hpp"

namespace orthodrive::elevate {

/// A path's node that other paths share.
struct Meeting {
  std::size_t path = 0, node = 0, chain = 0;
  double along_m = 0.0;
};
/// [osm_node] with two paths (or two nodes of one path) at least.
using Meetings = std::map<std::int64_t, std::vector<Meeting>>;

[[nodiscard]] Meetings find_meetings(const RoadNetwork& roads, const LogChains& chains);

/// The places of all samples on their chains.
class DrivenPlaces {
 public:
  DrivenPlaces(std::size_t chains, const std::vector<DrivenSample>& samples);
  /// Ascending.
  [[nodiscard]] const std::vector<double>& on_chain(std::size_t chain) const { return places_m_[chain]; }
  [[nodiscard]] std::size_t chains() const { return places_m_.size(); }
  /// Something was measured within 10 m.
  [[nodiscard]] bool near(std::size_t chain, double along_m) const;

 private:
  std::vector<std::vector<double>> places_m_;  // [chain]
};

/// Chains with samples and all that are within `reach_m` of one along the roads, ascending (Dijkstra over the
/// meetings).
[[nodiscard]] std::vector<std::size_t> chains_within(const LogChains& chains, const Meetings& meetings,
                                                     const DrivenPlaces& driven, double reach_m);

}  // namespace orthodrive::elevate

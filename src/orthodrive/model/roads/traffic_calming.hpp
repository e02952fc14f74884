// SPDX-License-Identifier: Apache-2.0
#pragma once
// Humps that slow traffic: how they are built, and how fast cars drive over them.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// One kind of hump, over the whole carriageway: up a ramp, over the plateau, down a ramp, `count` times.
struct HumpProfile {
  std::string_view value;  ///< of OSM's traffic_calming
  double height_m = 0.0;
  double ramp_m = 0.0;     ///< along the road, of each side; a cubic that is level at both ends
  double plateau_m = 0.0;  ///< between the ramps
  int count = 1;
  double pitch_m = 0.0;    ///< from one to the next of them
  double speed_mps = 0.0;  ///< at which cars drive over it
  [[nodiscard]] double length_m() const { return 2.0 * ramp_m + plateau_m + (count - 1) * pitch_m; }
};

/// All that are built. Sources: docs/calmed_roads.md.
[[nodiscard]] std::span<const HumpProfile> hump_profiles();
/// nullptr for values that are no humps: narrowings, islands, strips without a height.
[[nodiscard]] const HumpProfile* hump_profile(std::string_view value);
/// The values of OSM's traffic_calming, which a semicolon parts.
[[nodiscard]] std::vector<std::string> calming_values(const std::string& tag);

/// <object> type and subtype of a hump; its name is OSM's value, its box the hump's.
inline constexpr const char* hump_object = "patch";
inline constexpr const char* hump_subtype = "speedHump";
/// At which cars drive over the hump at s, m/s, from a little before it until a little behind it; infinity where there
/// is none.
[[nodiscard]] double hump_speed_mps(const roadquery::Road& road, double s);

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the value of OSM's key highway says of a road, where several rooms ask the same.
// https://wiki.openstreetmap.org/wiki/Key:highway

#include <string_view>

namespace orthodrive {

/// Motorways, trunk roads and their links: roads without houses, built for more than town speed.
[[nodiscard]] inline bool is_fast_class(std::string_view highway) {
  return highway.starts_with("motorway") || highway.starts_with("trunk");
}

/// Race tracks: one lane as wide as the road, no limits, no rules of traffic.
[[nodiscard]] inline bool is_raceway(std::string_view highway) { return highway == "raceway"; }

/// Slip roads and connecting roads of junctions.
[[nodiscard]] inline bool is_link_class(std::string_view highway) { return highway.ends_with("_link"); }

/// Streets with houses on both sides.
[[nodiscard]] inline bool is_street_class(std::string_view highway) {
  return highway == "residential" || highway == "living_street";
}

}  // namespace orthodrive

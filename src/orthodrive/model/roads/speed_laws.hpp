// SPDX-License-Identifier: Apache-2.0
#pragma once
// Limits that the law of a country gives where no sign tells. https://wiki.openstreetmap.org/wiki/Default_speed_limits

#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Of one country, or of a part of it ("BE-VLG") that has a law of its own; km/h, 0: it says nothing of that.
struct SpeedLaw {
  std::string country;    ///< ISO 3166-1 or 3166-2
  double unit_kmh = 1.0;  ///< of numbers on its signs: 1.609344 where they are miles per hour
  double living_street = 0.0, bicycle_road = 0.0;
  double urban = 0.0;       ///< inside of towns
  double rural = 0.0;       ///< outside of them
  double rural_dual = 0.0;  ///< there, where the directions have carriageways of their own, of two lanes or more
  double national = 0.0;    ///< national roads outside of towns (IE)
  double motorroad = 0.0;   ///< roads for motor vehicles alone
  double motorway = 0.0;
};

struct SpeedLaws {
  std::vector<SpeedLaw> laws;  ///< any order
  std::string here;            ///< country of the roads, for tags that name none; empty: not known
};

/// Whether a text such as "CZ:urban", "GB:nsl_single", "DE:zone30", "rural" names a case of the law. The part behind
/// the colon decides. https://wiki.openstreetmap.org/wiki/Key:maxspeed:type.
[[nodiscard]] bool is_speed_context(std::string_view text);

/// The limit of such a case, km/h. A law that has none of its own for motorways and motor roads has that of roads
/// outside of towns there. A country without a law in `laws` has the world's: 20 in living streets, 50 in towns, 90
/// outside, 100 on motor roads, 130 on motorways. 0: no such case.
[[nodiscard]] double speed_of_context(const SpeedLaws& laws, std::string_view text);

/// The limit of a road that no sign gives one, by its class and RoadPath::speed_context; 0: none (raceways). Where
/// nothing tells whether it lies in a town, it does, but for motorways, motor roads and trunk roads. Links, service
/// roads and tracks, which no law names, have at most default_speed_limit_kmh().
[[nodiscard]] double lawful_speed_kmh(const SpeedLaws& laws, const RoadPath& path);

/// Gives all paths a limit, and numbers to cases of the law in their lists of limits. "network.speed_by_law" says for
/// how many, and by whose law, where laws are given.
void settle_speeds(const SpeedLaws& laws, RoadNetwork& roads, Findings& findings);

}  // namespace orthodrive

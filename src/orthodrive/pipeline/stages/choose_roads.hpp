// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads of a network by what a person calls them.

#include <set>
#include <string>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// Indices of the roads that `item` means: "12" (id of a road in the OpenDRIVE file), "way/4711" (all roads of an OSM
/// way and the connecting roads that go on in it), "highway/raceway" (all roads of that OSM class, connecting ones
/// aside) or the name of roads, whose case does not count. Throws OptionError, which begins with `option`, when the
/// network has none. `more_words`: what else the option takes, for that message.
[[nodiscard]] std::set<std::size_t> choose_roads(const roadquery::RoadMap& map, const std::string& item,
                                                 const std::string& option, const std::string& more_words = "");

/// The map with the roads of all items alone, and those connecting roads that lead from one of them to another. A
/// junction whose other roads are left out has no surface of its own. Throws OptionError as above.
[[nodiscard]] roadquery::RoadMap map_of_chosen(const roadquery::RoadMap& map, const std::vector<std::string>& items,
                                               const std::string& option);

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/choose_roads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "orthodrive/core/error.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive {
namespace {
using roadquery::LinkKind;
using roadquery::Road;

template <typename Means>
std::set<std::size_t> roads_that(const roadquery::RoadMap& map, const Means& means) {
  std::set<std::size_t> chosen;
  for (std::size_t i = 0; i < map.roads.size(); ++i)
    if (means(map.roads[i])) chosen.insert(i);
  return chosen;
}

/// Why there is no road.
std::string nothing_found(const std::string& item, bool is_number, const std::string& more_words) {
  if (item.starts_with("way/")) return "no road of the network is of that OSM way";
  if (item.starts_with("highway/")) return "no road of the network is of that OSM class";
  if (is_number) return fmt::format("no road has this id; for the roads of an OSM way write way/{}", item);
  return "no road has this name; need the name or the id of a road, way/ID of an OSM way, highway/CLASS" + more_words;
}

}  // namespace

std::set<std::size_t> choose_roads(const roadquery::RoadMap& map, const std::string& item, const std::string& option,
                                   const std::string& more_words) {
  int id = 0;
  const auto [end, error] = std::from_chars(item.data(), item.data() + item.size(), id);
  const bool is_number = error == std::errc{} && end == item.data() + item.size();
  const auto after = [&](const char* prefix) {
    const std::string_view text(prefix);
    return item.starts_with(text) ? item.substr(text.size()) : "";
  };
  const std::string way = after("way/"), highway = after("highway/"), name = roadquery::lowered(item);
  const std::set<std::size_t> chosen = roads_that(map, [&](const Road& road) {
    if (!way.empty()) return road.osm_id == way;
    if (!highway.empty()) return road.highway == highway && road.junction < 0;
    if (is_number) return road.id == id;
    return !name.empty() && roadquery::lowered(road.name) == name;
  });
  if (chosen.empty())
    throw OptionError(fmt::format("{} {}: {}", option, item, nothing_found(item, is_number, more_words)));
  return chosen;
}

roadquery::RoadMap map_of_chosen(const roadquery::RoadMap& map, const std::vector<std::string>& items,
                                 const std::string& option) {
  std::set<int> ids;
  for (const std::string& item : items)
    for (const std::size_t i : choose_roads(map, item, option)) ids.insert(map.roads[i].id);
  const std::set<int> named = ids;
  const auto leads_to_chosen = [&](const roadquery::RoadLink& link) {
    return link.kind == LinkKind::road && named.contains(link.id);
  };
  for (const Road& road : map.roads)
    if (road.junction >= 0 && leads_to_chosen(road.predecessor) && leads_to_chosen(road.successor)) ids.insert(road.id);

  roadquery::RoadMap chosen = map;
  std::erase_if(chosen.roads, [&](const Road& road) { return !ids.contains(road.id); });
  for (roadquery::Junction& junction : chosen.junctions) {
    const bool is_whole = std::ranges::all_of(
        map.roads, [&](const Road& road) { return road.junction != junction.id || ids.contains(road.id); });
    if (!is_whole) junction.surface.reset();
  }
  return chosen;
}

}  // namespace orthodrive

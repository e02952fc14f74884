// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/speed_laws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "orthodrive/model/roads/highway_class.hpp"

namespace orthodrive {
namespace {
constexpr double walk_kmh = 7.0;  // what courts take "Schrittgeschwindigkeit" for
/// Where a law is not known or says nothing: the commonest values of the countries in catalogue/speed_limits.toml.
const SpeedLaw law_of_the_world{
    .living_street = 20.0, .bicycle_road = 30.0, .urban = 50.0, .rural = 90.0, .motorroad = 100.0, .motorway = 130.0};

using Limit = double SpeedLaw::*;
/// Names of cases in OSM.
struct Case {
  std::string_view name;
  Limit limit;
};
constexpr Case cases[] = {{"living_street", &SpeedLaw::living_street},
                          {"urban", &SpeedLaw::urban},
                          {"nsl_restricted", &SpeedLaw::urban},
                          {"rural", &SpeedLaw::rural},
                          {"nsl_single", &SpeedLaw::rural},
                          {"national", &SpeedLaw::national},
                          {"nsl_dual", &SpeedLaw::rural_dual},
                          {"trunk", &SpeedLaw::motorroad},
                          {"motorroad", &SpeedLaw::motorroad},
                          {"expressway", &SpeedLaw::motorroad},
                          {"motorway", &SpeedLaw::motorway},
                          {"bicycle_road", &SpeedLaw::bicycle_road},
                          {"cyclestreet", &SpeedLaw::bicycle_road}};

std::pair<std::string_view, std::string_view> country_and_case(std::string_view text) {
  const auto colon = text.find(':');
  if (colon == std::string_view::npos) return {{}, text};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

const Case* find_case(std::string_view name) {
  const auto found = std::ranges::find(cases, name, &Case::name);
  return found == std::end(cases) ? nullptr : found;
}

std::optional<double> number_of(std::string_view text) {
  double value = 0.0;
  const auto [rest, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failed != std::errc() || rest != text.data() + text.size()) return {};
  return value;
}

/// Of "30", "zone30", "zone:30": the number, in the country's unit.
std::optional<double> zone_number(std::string_view name) {
  if (name.starts_with("zone")) name.remove_prefix(4);
  if (name.starts_with(':')) name.remove_prefix(1);
  const std::optional<double> value = number_of(name);
  return value && *value > 0.0 && *value < 200.0 ? value : std::nullopt;
}

/// The case whose limit holds where a law has none of its own for one; null: the world's.
Limit more_general(Limit limit) {
  if (limit == &SpeedLaw::motorway || limit == &SpeedLaw::motorroad) return &SpeedLaw::rural_dual;
  if (limit == &SpeedLaw::rural_dual || limit == &SpeedLaw::national) return &SpeedLaw::rural;
  return nullptr;
}

/// The first law that tells: that of a part of the country, of the country, of the world; 0: none.
template <typename Tell>
double first_told(const SpeedLaws& laws, std::string_view country, const Tell& tell) {
  for (const std::string_view wanted : {country, country.substr(0, country.find('-'))})
    for (const SpeedLaw& law : laws.laws)
      if (law.country == wanted)
        if (const double kmh = tell(law); kmh > 0.0) return kmh;
  return 0.0;
}

double limit_of(const SpeedLaws& laws, std::string_view country, Limit limit) {
  for (Limit asked = limit; asked; asked = more_general(asked))
    if (const double kmh = first_told(laws, country, [&](const SpeedLaw& law) { return law.*asked; }); kmh > 0.0)
      return kmh;
  for (Limit asked = limit; asked; asked = more_general(asked))
    if (law_of_the_world.*asked > 0.0) return law_of_the_world.*asked;
  return 0.0;
}

/// Of numbers on the signs of a country.
double unit_kmh(const SpeedLaws& laws, std::string_view country) {
  const double kmh = first_told(laws, country, [](const SpeedLaw& law) { return law.unit_kmh; });
  return kmh > 0.0 ? kmh : 1.0;
}

double numbered_or_named(const SpeedLaws& laws, std::string_view text) {
  const std::optional<double> number = number_of(text);
  return number ? *number : speed_of_context(laws, text);
}

/// A list of limits, one per lane, with numbers for the cases in it.
std::string with_numbers(const SpeedLaws& laws, std::string_view list) {
  if (list.find_first_not_of("0123456789.|") == std::string_view::npos) return std::string(list);
  std::string numbers;
  for (const std::string_view word : lane_words(list)) {
    const double kmh = numbered_or_named(laws, word);
    numbers += fmt::format("{}{}", numbers.empty() && word.data() == list.data() ? "" : "|",
                           kmh > 0.0 ? fmt::format("{:g}", kmh) : "");
  }
  return numbers;
}

}  // namespace

bool is_speed_context(std::string_view text) {
  const auto [country, name] = country_and_case(text);
  if (find_case(name) || name == "walk") return true;
  return !country.empty() && zone_number(name).has_value();
}

double speed_of_context(const SpeedLaws& laws, std::string_view text) {
  const auto [named, name] = country_and_case(text);
  const std::string_view country = named.empty() ? std::string_view(laws.here) : named;
  if (name == "walk") return walk_kmh;
  if (const std::optional<double> number = zone_number(name)) return *number * unit_kmh(laws, country);
  const Case* found = find_case(name);
  return found ? limit_of(laws, country, found->limit) : 0.0;
}

double lawful_speed_kmh(const SpeedLaws& laws, const RoadPath& path) {
  const double built_for = default_speed_limit_kmh(path.highway);
  if (built_for == 0.0) return 0.0;
  const auto [named, context] = country_and_case(path.speed_context);
  const std::string_view country = named.empty() ? std::string_view(laws.here) : named;
  const auto limit = [&](Limit of) { return limit_of(laws, country, of); };
  const bool is_place = context == "urban" || context == "rural";
  if (!context.empty() && !is_place) return speed_of_context(laws, path.speed_context);
  if (path.highway == "motorway") return limit(&SpeedLaw::motorway);
  if (path.highway == "living_street") return limit(&SpeedLaw::living_street);
  const bool is_rural = context == "rural" || (context.empty() && path.highway.starts_with("trunk"));
  // Not the short arms of one lane at islands and roundabouts.
  const bool is_dual = path.oneway == Oneway::forward && !path.roundabout && path.lanes >= 2;
  double kmh = limit(&SpeedLaw::urban);
  if (is_rural) kmh = limit(is_dual ? &SpeedLaw::rural_dual : &SpeedLaw::rural);
  const bool is_named_by_no_law = is_link_class(path.highway) || road_rank(path.highway) <= road_rank("service");
  if (path.highway == "motorway_link") kmh = limit(&SpeedLaw::motorway);
  return is_named_by_no_law ? std::min(kmh, built_for) : kmh;
}

void settle_speeds(const SpeedLaws& laws, RoadNetwork& roads, Findings& findings) {
  int by_law = 0, in_towns = 0, outside = 0;
  Vec2 first;
  for (RoadPath& path : roads.paths) {
    path.speeds_forward = with_numbers(laws, path.speeds_forward);
    path.speeds_backward = with_numbers(laws, path.speeds_backward);
    if (path.speed_limit_kmh > 0.0) continue;
    for (const std::string* list : {&path.speeds_forward, &path.speeds_backward})
      for (const std::string_view word : lane_words(*list))
        path.speed_limit_kmh = std::max(path.speed_limit_kmh, numbered_or_named(laws, word));
    if (path.speed_limit_kmh > 0.0) continue;
    path.speed_limit_kmh = lawful_speed_kmh(laws, path);
    if (path.speed_limit_kmh <= 0.0) continue;
    if (by_law++ == 0) first = path.nodes.front().p;
    if (path.speed_context.ends_with("urban")) ++in_towns;
    if (path.speed_context.ends_with("rural")) ++outside;
  }
  if (by_law > 0 && !laws.laws.empty())
    findings.push_back({Severity::info, "network.speed_by_law",
                        fmt::format("{} ways without maxspeed have the limit of the law{}: {} in towns, {} outside, {} "
                                    "by their class alone (first here)",
                                    by_law, laws.here.empty() ? ", of no country that is known" : " of " + laws.here,
                                    in_towns, outside, by_law - in_towns - outside),
                        first.x, first.y});
}

}  // namespace orthodrive

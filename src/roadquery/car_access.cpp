// SPDX-License-Identifier: Apache-2.0
#include "roadquery/car_access.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace roadquery {
namespace {

constexpr double one_place_m = 0.01;  // entries of one place are written with different roundings

/// Of those whom a rule names: whether a passenger car is one of them. "none" stands for nobody.
bool names_cars(const std::vector<std::string>& whom) {
  return std::find(whom.begin(), whom.end(), "passengerCar") != whom.end();
}

/// Entries of one place: closed to whom a rule denies, and to all others where one allows somebody.
struct Rules {
  double s = 0.0;
  bool denied = false, allows_cars = false, allows_others = false;

  void add(const RoadParts::Access& access) {
    if (!access.allows) {
      denied = denied || names_cars(access.whom);
      return;
    }
    for (const std::string& who : access.whom) {
      if (who == "none") continue;
      (who == "passengerCar" ? allows_cars : allows_others) = true;
    }
  }
  [[nodiscard]] bool closed() const { return denied || (allows_others && !allows_cars); }
};

std::vector<Rules> rules_along(std::vector<RoadParts::Access> accesses) {
  std::stable_sort(accesses.begin(), accesses.end(),
                   [](const RoadParts::Access& a, const RoadParts::Access& b) { return a.s < b.s; });
  std::vector<Rules> rules;
  for (const RoadParts::Access& access : accesses) {
    if (rules.empty() || access.s - rules.back().s > one_place_m) rules.push_back({access.s});
    rules.back().add(access);
  }
  return rules;
}

/// To where the next one begins, wherever in the file that stands.
double section_length(const Road& road, const std::vector<double>& starts, double s) {
  const auto next = std::upper_bound(starts.begin(), starts.end(), s);
  return std::max((next != starts.end() ? *next : road.length) - s, 0.0);
}

}  // namespace

void close_lanes_to_cars(Road& road, const std::vector<RoadParts::Access>& accesses, NoteList& notes) {
  std::map<std::pair<std::size_t, int>, std::vector<RoadParts::Access>> of_lanes;
  for (const RoadParts::Access& access : accesses) of_lanes[{access.section, access.lane}].push_back(access);
  std::vector<double> starts;
  starts.reserve(road.sections.size());
  for (const LaneSection& section : road.sections) starts.push_back(section.s);
  std::sort(starts.begin(), starts.end());
  for (auto& [place, of_lane] : of_lanes) {
    LaneSection& section = road.sections[place.first];
    const double length_m = section_length(road, starts, section.s);
    const std::vector<Rules> rules = rules_along(std::move(of_lane));
    double closed_m = 0.0;
    for (std::size_t i = 0; i < rules.size(); ++i) {
      const double end = i + 1 < rules.size() ? rules[i + 1].s : length_m;
      if (rules[i].closed()) closed_m += std::max(std::min(end, length_m) - rules[i].s, 0.0);
    }
    constexpr double short_m = 2.0;
    if (closed_m > short_m && length_m - closed_m > short_m)
      notes.add("opendrive.access",
                "<access> opens and closes a lane within its section: what holds along most of it counts", true,
                {road.id, section.s});
    if (closed_m <= 0.5 * length_m) continue;
    for (Lane& lane : place.second > 0 ? section.left : section.right)
      if (lane.id == place.second && lane.type == LaneType::driving) lane.type = LaneType::other;
  }
}

}  // namespace roadquery

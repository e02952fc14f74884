// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/car_access.hpp"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <string_view>
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
  bool denied = false;                  ///< cars
  bool allows = false, denies = false;  ///< anybody
  std::vector<std::string> allowed;

  void add(const RoadParts::Access& access) {
    (access.allows ? allows : denies) = true;
    if (!access.allows) {
      denied = denied || names_cars(access.whom);
      return;
    }
    for (const std::string& who : access.whom)
      if (who != "none" && std::find(allowed.begin(), allowed.end(), who) == allowed.end()) allowed.push_back(who);
  }
  [[nodiscard]] bool closed() const { return denied || (!allowed.empty() && !names_cars(allowed)); }
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

/// What 1.8 writes as a driving lane for those alone, others as a type.
LaneType closed_type(const std::vector<std::string>& allowed) {
  const auto are_all = [&](std::initializer_list<std::string_view> some) {
    return !allowed.empty() && std::all_of(allowed.begin(), allowed.end(), [&](const std::string& who) {
      return std::find(some.begin(), some.end(), who) != some.end();
    });
  };
  if (are_all({"taxi"})) return LaneType::taxi;
  if (are_all({"bus", "taxi"})) return LaneType::bus;
  if (are_all({"bicycle"})) return LaneType::biking;
  return LaneType::other;
}

/// What holds along more than half of a lane.
struct LaneAccess {
  bool closed = false, changes = false;
  bool mixed = false;  ///< entries of one place allow some and deny others
  std::vector<std::string> allowed;
};

LaneAccess access_of(const std::vector<Rules>& rules, double length_m) {
  constexpr double short_m = 2.0;
  double closed_m = 0.0;
  std::map<std::vector<std::string>, double> allowed_m;
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const double end = std::min(i + 1 < rules.size() ? rules[i + 1].s : length_m, length_m);
    const double along_m = std::max(end - rules[i].s, 0.0);
    if (rules[i].closed()) closed_m += along_m;
    allowed_m[rules[i].allowed] += along_m;
  }
  LaneAccess access{closed_m > 0.5 * length_m, closed_m > short_m && length_m - closed_m > short_m, false, {}};
  access.mixed = std::any_of(rules.begin(), rules.end(), [](const Rules& r) { return r.allows && r.denies; });
  for (const auto& [allowed, along_m] : allowed_m)
    if (along_m > 0.5 * length_m) access.allowed = allowed;
  return access;
}

}  // namespace

void read_lane_access(Road& road, const std::vector<RoadParts::Access>& accesses, NoteList& notes) {
  std::map<std::pair<std::size_t, int>, std::vector<RoadParts::Access>> of_lanes;
  for (const RoadParts::Access& access : accesses) of_lanes[{access.section, access.lane}].push_back(access);
  std::vector<double> starts;
  starts.reserve(road.sections.size());
  for (const LaneSection& section : road.sections) starts.push_back(section.s);
  std::sort(starts.begin(), starts.end());
  for (auto& [place, of_lane] : of_lanes) {
    LaneSection& section = road.sections[place.first];
    const double length_m = section_length(road, starts, section.s);
    LaneAccess access = access_of(rules_along(std::move(of_lane)), length_m);
    if (access.changes)
      notes.add("opendrive.access",
                "<access> opens and closes a lane within its section: what holds along most of it counts", true,
                {road.id, section.s});
    if (access.mixed)
      notes.add("opendrive.access",
                "<access> allows some and denies others at one place: who is denied or not allowed is kept out", true,
                {road.id, section.s});
    for (Lane& lane : place.second > 0 ? section.left : section.right) {
      if (lane.id != place.second) continue;
      if (access.closed && is_driven(lane.type)) lane.type = closed_type(access.allowed);
      lane.allowed = access.allowed;
    }
  }
}

}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/traffic_calming.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace orthodrive {
namespace {

constexpr double kmh = 1.0 / 3.6;
constexpr double wheelbase_reach_m = 3.0;  // a car is on the hump as long as one of its axles is

constexpr std::array profiles{
    // Round top: TRL 377 (1970s track trials of 3.7 m, up to 100 mm); 75 mm: TRL 186, driven at less than 20 mph.
    HumpProfile{.value = "hump", .height_m = 0.075, .ramp_m = 1.85, .speed_mps = 25.0 * kmh},
    // Highways (Road Humps) Regulations 1999: 25 to 100 mm high, at least 900 mm long.
    HumpProfile{.value = "bump", .height_m = 0.040, .ramp_m = 0.5, .speed_mps = 15.0 * kmh},
    // Leicestershire Highway Design Guide, speed control features: 75 mm, ramps of 1 in 13, 7 m or more of plateau.
    HumpProfile{.value = "table", .height_m = 0.075, .ramp_m = 1.0, .plateau_m = 7.0, .speed_mps = 30.0 * kmh},
    // DfT Traffic Advisory Leaflet 1/98: ramps of 1 in 8 at most. Over the whole width, not only under narrow cars.
    HumpProfile{.value = "cushion", .height_m = 0.065, .ramp_m = 0.6, .plateau_m = 1.8, .speed_mps = 30.0 * kmh},
    // As rumble devices, Highways (Traffic Calming) Regulations 1999: at most 15 mm high.
    HumpProfile{
        .value = "mini_bumps", .height_m = 0.015, .ramp_m = 0.35, .count = 3, .pitch_m = 1.4, .speed_mps = 30.0 * kmh}};

}  // namespace

std::span<const HumpProfile> hump_profiles() { return profiles; }

const HumpProfile* hump_profile(std::string_view value) {
  const auto found = std::ranges::find(profiles, value, &HumpProfile::value);
  return found == profiles.end() ? nullptr : &*found;
}

std::vector<std::string> calming_values(const std::string& tag) {
  std::vector<std::string> values;
  std::string value;
  for (const char c : tag + ";") {
    if (c == ' ') continue;
    if (c != ';') {
      value += c;
      continue;
    }
    if (!value.empty() && value != "no" && std::ranges::find(values, value) == values.end()) values.push_back(value);
    value.clear();
  }
  return values;
}

double hump_speed_mps(const roadquery::Road& road, double s) {
  double speed_mps = std::numeric_limits<double>::infinity();
  for (const roadquery::RoadObject& object : road.objects) {
    if (object.type != hump_object || object.subtype != hump_subtype) continue;
    if (std::abs(s - object.s) > 0.5 * object.length + wheelbase_reach_m) continue;
    if (const HumpProfile* profile = hump_profile(object.name)) speed_mps = std::min(speed_mps, profile->speed_mps);
  }
  return speed_mps;
}

}  // namespace orthodrive

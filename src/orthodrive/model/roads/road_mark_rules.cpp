// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/road_mark_rules.hpp"

#include <algorithm>

namespace orthodrive {

RoadMarkRule rule_here(const RoadMarkRules& rules) {
  const std::string country = rules.here.substr(0, rules.here.find('-'));
  const auto rule = std::ranges::find(rules.rules, country, &RoadMarkRule::country);
  return rule == rules.rules.end() ? RoadMarkRule{} : *rule;
}

}  // namespace orthodrive

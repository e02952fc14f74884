// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/road_mark_rules.hpp"

#include <algorithm>

namespace orthodrive {

RoadMarkRule rule_here(const RoadMarkRules& rules) {
  for (const std::string& country : {rules.here, rules.here.substr(0, rules.here.find('-')), std::string()}) {
    const auto rule = std::ranges::find(rules.rules, country, &RoadMarkRule::country);
    if (rule != rules.rules.end()) return *rule;
  }
  return {};
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lists along a road or a lane, counted from a later start on.

#include <algorithm>
#include <vector>

#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// Moves a list back by `by_m`; what a later entry takes over before the new start is left out.
template <typename Item, typename Place>
void move_back(std::vector<Item>& items, double by_m, const Place& place) {
  for (Item& item : items) place(item) -= by_m;
  const auto first = std::find_if(items.begin(), items.end(), [&](const Item& item) { return place(item) > 0.0; });
  if (first == items.begin()) return;
  items.erase(items.begin(), first - 1);
}

constexpr auto place_s = [](auto& item) -> auto& { return item.s; };
constexpr auto place_offset = [](auto& item) -> auto& { return item.s_offset; };

/// The lane as if its section began `by_m` later. Cubics and heights keep where they began, before it.
void start_lane_later(Lane& lane, double by_m);

}  // namespace roadquery

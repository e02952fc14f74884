// SPDX-License-Identifier: Apache-2.0
#pragma once
// Restrictions over ways: in which order and direction one drives along them. Relations hold their members in any
// order.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::io {

/// A road as far as turning asks.
struct TurningWay {
  std::vector<std::int64_t> nodes;  ///< in the direction of traffic of one-way roads
  bool one_way = false;
};
/// By its id; null for ways that are no roads of cars or not in the map. What it points to outlives the call.
using FindTurningWay = std::function<const TurningWay*(std::int64_t)>;

/// Puts via_ways in the order in which one drives and fills via_node, where one leaves from_way for the first of them.
/// Empty, or why that cannot be: members that lack, ways that do not meet or lead the other way.
[[nodiscard]] std::string order_via_ways(TurnRestriction& turn, const FindTurningWay& find);

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/via_ways.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

namespace orthodrive::io {
namespace {
constexpr std::size_t most_ways = 8;  // of all restrictions of a country none goes over more
constexpr int most_steps = 20000;     // against relations that are made to harm

/// Looks for a way through all members, each via way once.
class ChainFinder {
 public:
  ChainFinder(const TurnRestriction& turn, const FindTurningWay& find, bool heed_one_way)
      : turn_(turn), find_(find), heed_one_way_(heed_one_way), used_(turn.via_ways.size(), false) {}

  /// The via ways in order, and the node at which one leaves the first way.
  struct Chain {
    std::int64_t via_node = 0;
    std::vector<std::int64_t> ways;
  };
  std::optional<Chain> run() {
    if (leave(turn_.from_way, std::nullopt)) return chain_;
    return std::nullopt;
  }

 private:
  using Node = std::optional<std::int64_t>;

  /// Whether one may drive along a way from a node (none: from any) to another one of its nodes (none: to any).
  [[nodiscard]] bool leads(const TurningWay& way, Node from, Node to) const {
    if (from && to && *from == *to) return false;
    if (!heed_one_way_ || !way.one_way) return true;
    const bool closed = way.nodes.front() == way.nodes.back();
    if (closed) return true;
    const auto place = [&](std::int64_t node) { return std::ranges::find(way.nodes, node); };
    if (from && to) return place(*from) < place(*to);
    return from ? place(*from) + 1 != way.nodes.end() : !to || place(*to) != way.nodes.begin();
  }
  static bool holds(const TurningWay& way, std::int64_t node) {
    return std::ranges::find(way.nodes, node) != way.nodes.end();
  }

  /// On a way that one came onto at a node (none: the first one): on to the next, or to the last where all are driven.
  bool leave(std::int64_t id, Node entered) {
    if (++steps_ > most_steps) return false;
    const TurningWay& way = *find_(id);
    const bool all_driven = chain_.ways.size() == turn_.via_ways.size();
    for (const std::int64_t node : way.nodes) {
      if (!leads(way, entered, node)) continue;
      if (!entered) chain_.via_node = node;
      if (all_driven) {
        const TurningWay& to = *find_(turn_.to_way);
        if (holds(to, node) && leads(to, node, std::nullopt)) return true;
        continue;
      }
      for (std::size_t i = 0; i < used_.size(); ++i) {
        if (used_[i] || !holds(*find_(turn_.via_ways[i]), node)) continue;
        used_[i] = true;
        chain_.ways.push_back(turn_.via_ways[i]);
        if (leave(turn_.via_ways[i], node)) return true;
        chain_.ways.pop_back();
        used_[i] = false;
      }
    }
    return false;
  }

  const TurnRestriction& turn_;
  const FindTurningWay& find_;
  bool heed_one_way_;
  std::vector<bool> used_;
  Chain chain_;
  int steps_ = 0;
};
}  // namespace

std::string order_via_ways(TurnRestriction& turn, const FindTurningWay& find) {
  if (turn.via_ways.size() > most_ways)
    return fmt::format("it goes over {} ways, {} are read at most", turn.via_ways.size(), most_ways);
  std::vector<std::int64_t> members{turn.from_way, turn.to_way};
  members.insert(members.end(), turn.via_ways.begin(), turn.via_ways.end());
  for (const std::int64_t id : members)
    if (const TurningWay* way = find(id); !way || way->nodes.size() < 2)
      return fmt::format("way {} is no road of cars in the map", id);
  if (const auto chain = ChainFinder(turn, find, true).run()) {
    turn.via_node = chain->via_node, turn.via_ways = chain->ways;
    return "";
  }
  TurnRestriction back = turn;
  std::swap(back.from_way, back.to_way);
  if (ChainFinder(back, find, true).run())
    return fmt::format("cars drive from way {} to way {} alone: are from and to swapped?", turn.to_way, turn.from_way);
  if (ChainFinder(turn, find, false).run()) return "it leads against a one-way road";
  return "its ways do not meet, one after the other";
}

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Turns that relations of OSM forbid. https://wiki.openstreetmap.org/wiki/Relation:restriction

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive::io {

/// A relation that restricts cars and is not read.
struct UnreadRestriction {
  std::int64_t relation = 0;
  Severity severity = Severity::warning;
  std::string why;
  std::vector<std::int64_t> from_ways, via_nodes, via_ways;
};

struct ReadRestriction {
  std::int64_t relation = 0;
  std::string value;     ///< "no_left_turn"
  TurnRestriction turn;  ///< over ways: they stand as in the relation, and via_node is not known (order_via_ways)
};

struct OsmRestrictions {
  std::vector<ReadRestriction> read;
  std::vector<UnreadRestriction> unread;
};

/// Turns that relations forbid (no_*), or the only ones that they allow (only_*), over one node or over ways, at all
/// hours. Of a relation in several files the latest version counts, of equal ones the first. What counts for lorries or
/// buses alone or exempts cars is neither read nor unread.
[[nodiscard]] OsmRestrictions read_restrictions(const std::vector<std::filesystem::path>& files);

}  // namespace orthodrive::io

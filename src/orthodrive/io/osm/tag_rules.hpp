// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which tags of roads and of their nodes are read, and what becomes of them: one table, from which docs/osm_tags.md is.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/io/osm/osm_tags.hpp"

namespace orthodrive::io {

enum class TaggedObject { way, node };

/// One key. A key that ends in '*' stands for all that begin so; the longest key that fits a tag counts.
struct TagRule {
  TaggedObject on = TaggedObject::way;
  std::string_view key;
  bool is_read = false;
  std::string_view page;     ///< of the wiki of OpenStreetMap
  std::string_view meaning;  ///< what is made of it, or why nothing is
};

/// Of roads first, then of nodes.
[[nodiscard]] std::span<const TagRule> tag_rules();

/// "traffic_calming=chicane", and why it is not read.
struct UnreadTag {
  std::string tag;
  std::string_view reason;
};
/// Tags that the table lists as not read and that say something: not "no" or "none"; values of traffic_calming that are
/// no humps. Keys that the table does not know
/// do not bear on the geometry of roads.
[[nodiscard]] std::vector<UnreadTag> unread_tags(const OsmTags& tags, TaggedObject on);

}  // namespace orthodrive::io

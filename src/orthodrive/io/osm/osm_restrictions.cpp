// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/osm_restrictions.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <map>
#include <optional>
#include <osmium/osm/relation.hpp>
#include <string_view>
#include <utility>

#include "orthodrive/core/printable.hpp"
#include "orthodrive/io/osm/osm_road_ids.hpp"
#include "orthodrive/io/support/osm_support.hpp"

namespace orthodrive::io {
namespace {

/// Of `except`: whether cars need not heed it.
bool exempts_cars(std::string_view except) {
  for (const std::string_view cars : {"motorcar", "motor_vehicle"})
    if (except.find(cars) != except.npos) return true;
  return except == "vehicle";
}

/// What the relation says of cars; the first key that is there counts. Empty: nothing.
std::string value_for_cars(const std::map<std::string, std::string>& tags, const std::string& ending) {
  for (const char* key : {"restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle", "restriction"})
    if (const auto at = tags.find(key + ending); at != tags.end()) return at->second;
  return {};
}

class RestrictionReader {
 public:
  explicit RestrictionReader(const osmium::Relation& relation) : tags_(tags_of(relation.tags())) {
    members_.relation = relation.id();
    for (const osmium::RelationMember& member : relation.members()) {
      const std::string_view role = member.role();
      const bool is_way = member.type() == osmium::item_type::way, is_node = member.type() == osmium::item_type::node;
      if (is_way && role == "from") members_.from_ways.push_back(member.ref());
      if (is_way && role == "to") to_.push_back(member.ref());
      if (is_way && role == "via") members_.via_ways.push_back(member.ref());
      if (is_node && role == "via") members_.via_nodes.push_back(road_node(member.ref()));
    }
  }

  [[nodiscard]] OsmRestrictions read() const {
    const auto type = tags_.find("type"), except = tags_.find("except");
    if (type == tags_.end() || type->second != "restriction") return {};
    if (except != tags_.end() && exempts_cars(except->second)) return {};
    const std::string value = value_for_cars(tags_, "");
    if (value.empty()) {
      const std::string sometimes = value_for_cars(tags_, ":conditional");
      if (sometimes.empty() || sometimes == "none") return {};
      return unread(Severity::info, fmt::format("{} counts at some hours only and is left out", printable(sometimes)));
    }
    const bool only = value.starts_with("only_");
    if (!only && !value.starts_with("no_"))
      return unread(Severity::warning, fmt::format("restriction={} is not known and left out", printable(value)));
    if (members_.from_ways.empty() || to_.empty() || (members_.via_nodes.empty() && members_.via_ways.empty()))
      return unread(Severity::warning, fmt::format("{} lacks from, via or to and is left out", value));
    if (members_.via_ways.empty() && members_.via_nodes.size() != 1)
      return unread(Severity::warning, fmt::format("{} has {} nodes as via and is left out: one node, or ways", value,
                                                   members_.via_nodes.size()));
    const std::int64_t via_node = members_.via_ways.empty() ? members_.via_nodes.front() : 0;
    OsmRestrictions all;
    for (const std::int64_t a : members_.from_ways)
      for (const std::int64_t b : to_)
        all.read.push_back({members_.relation, value, {a, via_node, b, only, members_.via_ways}});
    return all;
  }

 private:
  [[nodiscard]] OsmRestrictions unread(Severity severity, std::string why) const {
    UnreadRestriction restriction = members_;
    restriction.severity = severity, restriction.why = std::move(why);
    return {{}, {std::move(restriction)}};
  }

  std::map<std::string, std::string> tags_;
  UnreadRestriction members_;
  std::vector<std::int64_t> to_;
};

}  // namespace

OsmRestrictions read_restrictions(const std::vector<std::filesystem::path>& files) {
  struct Known {
    osmium::object_version_type version = 0;
    OsmRestrictions restrictions;
  };
  std::vector<Known> known;
  std::map<std::int64_t, std::size_t> index;
  const auto add = [&](const osmium::Relation& relation) {
    const auto [at, is_new] = index.emplace(relation.id(), known.size());
    if (is_new)
      known.push_back({relation.version(), RestrictionReader(relation).read()});
    else if (known[at->second].version < relation.version())
      known[at->second] = {relation.version(), RestrictionReader(relation).read()};
  };
  for (const std::filesystem::path& path : files)
    with_osm_errors(path, [&] {
      read_osm_buffers(path, osmium::osm_entity_bits::relation, [&](const osmium::memory::Buffer& buffer) {
        for (const osmium::Relation& relation : buffer.select<osmium::Relation>()) add(relation);
      });
    });
  OsmRestrictions all;
  for (Known& relation : known) {
    std::ranges::move(relation.restrictions.read, std::back_inserter(all.read));
    std::ranges::move(relation.restrictions.unread, std::back_inserter(all.unread));
  }
  return all;
}

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Objects of OSM files in text on their way into libosmium's buffers.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <osmium/memory/buffer.hpp>
#include <osmium/osm/entity_bits.hpp>
#include <osmium/osm/item_type.hpp>
#include <osmium/osm/location.hpp>
#include <osmium/osm/types.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace orthodrive::io {

/// A node of a way that has a place and no id (`out tags geom`): nodes in one place get one.
constexpr std::int64_t no_ref = std::numeric_limits<std::int64_t>::min();

struct TextMember {
  osmium::item_type type = osmium::item_type::undefined;
  std::int64_t ref = 0;
  std::string role;
  std::vector<osmium::Location> line;  ///< of a way, where the file puts it here (`out geom`)
};

struct TextObject {
  osmium::item_type type = osmium::item_type::undefined;
  std::int64_t id = 0;
  osmium::object_version_type version = 0;
  bool is_deleted = false;
  osmium::Location place = osmium::Location{};
  std::vector<std::pair<std::int64_t, osmium::Location>> nodes;
  std::vector<TextMember> members;
  std::vector<std::pair<std::string, std::string>> tags;
};

/// Hands on objects in buffers of some megabytes.
class TextObjects {
 public:
  TextObjects(osmium::osm_entity_bits::type entities, const std::function<void(osmium::memory::Buffer&)>& use);
  void add(const TextObject& object);
  /// Ways that only members of relations draw, and what is left.
  void finish();

 private:
  void put(const TextObject& object);
  void put_way(const TextObject& object);

  osmium::osm_entity_bits::type entities_;
  const std::function<void(osmium::memory::Buffer&)>& use_;
  osmium::memory::Buffer buffer_;
  std::set<std::int64_t> ways_;  ///< of the file, kept once a member draws one
  std::map<std::int64_t, std::vector<osmium::Location>> drawn_ways_;
  std::map<osmium::Location, std::int64_t> drawn_nodes_;
};

/// 0 for what is no number.
[[nodiscard]] osmium::object_version_type version_of(const std::string& text);
/// Throws osmium::xml_error for other types than node, way and relation.
[[nodiscard]] osmium::item_type member_type(const std::string& text);
/// An undefined one where one of both is missing. Throws osmium::invalid_location for what is no number.
[[nodiscard]] osmium::Location place_of(const std::string& lon, const std::string& lat);
/// Throws InputError for a remark of Overpass that tells of an error: the result is not whole.
void check_remark(const std::filesystem::path& path, const std::string& remark);

constexpr std::size_t most_osm_json_bytes = std::size_t{256} << 20;
/// Objects of Overpass's JSON. Throws InputError for other JSON.
void add_osm_json(const std::filesystem::path& path, const std::string& text, TextObjects& objects);

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/support/osm_text_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <osmium/builder/osm_object_builder.hpp>
#include <osmium/io/error.hpp>
#include <osmium/osm/entity_bits.hpp>
#include <osmium/osm/node.hpp>
#include <osmium/osm/relation.hpp>
#include <osmium/osm/way.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive::io {
namespace {
using nlohmann::json;

constexpr std::size_t full_buffer_bytes = std::size_t{4} << 20;
// Ids of nodes that have none lie below all that editors give to new objects.
constexpr std::int64_t first_drawn_node = -(std::int64_t{1} << 39);

template <typename Builder>
void set_object(Builder& builder, const TextObject& object) {
  builder.set_id(object.id);
  builder.set_version(object.version);
  builder.set_visible(true);
}

void add_tags(osmium::builder::Builder& parent, const TextObject& object) {
  if (object.tags.empty()) return;
  osmium::builder::TagListBuilder tags{parent};
  for (const auto& [key, value] : object.tags) tags.add_tag(key, value);
}

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The shortest text of the number, so that it is rounded as that of XML.
osmium::Location json_place(const json& object) {
  if (!object.is_object() || !object.contains("lat") || !object.contains("lon")) return osmium::Location{};
  return place_of(fmt::format("{}", object["lon"].get<double>()), fmt::format("{}", object["lat"].get<double>()));
}

std::vector<osmium::Location> json_line(const json& object) {
  std::vector<osmium::Location> line;
  if (object.contains("geometry") && object["geometry"].is_array())
    for (const json& point : object["geometry"]) line.push_back(json_place(point));
  return line;
}

TextObject json_object(const json& element, osmium::item_type type) {
  TextObject object{.type = type, .id = element.at("id").get<std::int64_t>()};
  object.version = element.value("version", 0U);
  object.is_deleted = text_of(element, "action") == "delete" || !element.value("visible", true);
  object.place = json_place(element);
  if (element.contains("tags"))
    for (const auto& [key, value] : element["tags"].items())
      object.tags.emplace_back(key, value.is_string() ? value.get<std::string>() : value.dump());
  const std::vector<osmium::Location> line = json_line(element);
  if (element.contains("nodes"))
    for (const json& node : element["nodes"]) {
      const std::size_t i = object.nodes.size();
      object.nodes.emplace_back(node.get<std::int64_t>(), i < line.size() ? line[i] : osmium::Location{});
    }
  if (!element.contains("nodes"))
    for (const osmium::Location place : line) object.nodes.emplace_back(no_ref, place);
  if (element.contains("members"))
    for (const json& member : element["members"])
      object.members.push_back({member_type(text_of(member, "type")), member.at("ref").get<std::int64_t>(),
                                text_of(member, "role"), json_line(member)});
  return object;
}

}  // namespace

TextObjects::TextObjects(osmium::osm_entity_bits::type entities,
                         const std::function<void(osmium::memory::Buffer&)>& use)
    : entities_(entities), use_(use), buffer_(full_buffer_bytes, osmium::memory::Buffer::auto_grow::yes) {}

void TextObjects::add(const TextObject& object) {
  if (object.is_deleted) return;
  if (object.type == osmium::item_type::way) ways_.insert(object.id);
  if ((entities_ & osmium::osm_entity_bits::way) != osmium::osm_entity_bits::nothing)
    for (const TextMember& member : object.members)
      if (member.type == osmium::item_type::way && !member.line.empty()) drawn_ways_.emplace(member.ref, member.line);
  put(object);
}

void TextObjects::put(const TextObject& object) {
  if ((entities_ & osmium::osm_entity_bits::from_item_type(object.type)) == osmium::osm_entity_bits::nothing) return;
  if (object.type == osmium::item_type::node) {
    osmium::builder::NodeBuilder node{buffer_};
    set_object(node, object);
    node.set_location(object.place);
    add_tags(node, object);
  } else if (object.type == osmium::item_type::way) {
    put_way(object);
  } else {
    osmium::builder::RelationBuilder relation{buffer_};
    set_object(relation, object);
    {
      osmium::builder::RelationMemberListBuilder members{relation};
      for (const TextMember& member : object.members) members.add_member(member.type, member.ref, member.role);
    }
    add_tags(relation, object);
  }
  buffer_.commit();
  if (buffer_.committed() < full_buffer_bytes) return;
  use_(buffer_);
  buffer_.clear();
}

void TextObjects::put_way(const TextObject& object) {
  osmium::builder::WayBuilder way{buffer_};
  set_object(way, object);
  {
    osmium::builder::WayNodeListBuilder nodes{way};
    for (const auto& [ref, place] : object.nodes) {
      std::int64_t id = ref;
      if (ref == no_ref) {
        if (!place.valid()) continue;
        id = drawn_nodes_.emplace(place, first_drawn_node - static_cast<std::int64_t>(drawn_nodes_.size()))
                 .first->second;
      }
      nodes.add_node_ref(osmium::NodeRef{id, place});
    }
  }
  add_tags(way, object);
}

void TextObjects::finish() {
  for (const auto& [id, line] : drawn_ways_) {
    if (ways_.contains(id)) continue;
    TextObject way{.type = osmium::item_type::way, .id = id};
    for (const osmium::Location place : line) way.nodes.emplace_back(no_ref, place);
    put(way);
  }
  if (buffer_.committed() > 0) use_(buffer_);
  buffer_.clear();
}

osmium::object_version_type version_of(const std::string& text) {
  osmium::object_version_type version = 0;
  const auto [rest, failed] = std::from_chars(text.data(), text.data() + text.size(), version);
  return failed == std::errc() && rest == text.data() + text.size() ? version : 0;
}

osmium::item_type member_type(const std::string& text) {
  if (text == "node") return osmium::item_type::node;
  if (text == "way") return osmium::item_type::way;
  if (text == "relation") return osmium::item_type::relation;
  throw osmium::io_error(fmt::format("a member of the unknown type '{}'", printable(text)));
}

osmium::Location place_of(const std::string& lon, const std::string& lat) {
  osmium::Location place;
  if (lon.empty() || lat.empty()) return place;
  place.set_lon(lon.c_str());
  place.set_lat(lat.c_str());
  return place;
}

void check_remark(const std::filesystem::path& path, const std::string& remark) {
  if (remark.find("error") == remark.npos) return;
  throw InputError(path.string(),
                   fmt::format("is not whole, Overpass stopped ({}); ask again for a smaller area or with "
                               "a longer [timeout:...]",
                               printable(remark)));
}

void add_osm_json(const std::filesystem::path& path, const std::string& text, TextObjects& objects) {
  try {
    const json file = json::parse(text);
    check_remark(path, text_of(file, "remark"));
    if (!file.contains("elements")) {
      const bool is_geojson = !text_of(file, "type").empty();
      throw InputError(path.string(), is_geojson
                                          ? "is GeoJSON, whose lines do not tell which roads meet; export OSM XML "
                                            "(.osm)"
                                          : "is JSON, but not of Overpass; export OSM XML (.osm)");
    }
    for (const json& element : file["elements"]) {
      const std::string type = text_of(element, "type");
      if (type == "node" || type == "way" || type == "relation") objects.add(json_object(element, member_type(type)));
    }
  } catch (const json::exception& error) {
    throw osmium::io_error(error.what());
  }
}

}  // namespace orthodrive::io

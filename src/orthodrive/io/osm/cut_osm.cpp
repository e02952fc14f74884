// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/cut_osm.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <osmium/index/id_set.hpp>
#include <osmium/io/any_output.hpp>
#include <osmium/osm/box.hpp>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/io/support/gdal_support.hpp"
#include "orthodrive/io/support/osm_support.hpp"

namespace orthodrive::io {
namespace {
namespace fs = std::filesystem;
using osmium::osm_entity_bits::type;

/// Ids beyond what OSM has would make the sets of bits grow without bound.
bool is_usable(osmium::object_id_type id) { return std::abs(id) < (std::int64_t{1} << 40); }

/// Ids of either sign: new objects of editors have negative ones.
class Ids {
 public:
  void set(osmium::object_id_type id) { of(id).set(magnitude(id)); }
  [[nodiscard]] bool get(osmium::object_id_type id) const {
    return (id < 0 ? negative_ : positive_).get(magnitude(id));
  }

 private:
  using Set = osmium::index::IdSetDense<osmium::unsigned_object_id_type>;
  [[nodiscard]] Set& of(osmium::object_id_type id) { return id < 0 ? negative_ : positive_; }
  [[nodiscard]] static osmium::unsigned_object_id_type magnitude(osmium::object_id_type id) {
    return static_cast<osmium::unsigned_object_id_type>(std::abs(id));
  }
  Set positive_, negative_;
};

class Selection {
 public:
  explicit Selection(const Box2& box) : box_(box) {}

  void look_at(const osmium::OSMObject& object) {
    if (!is_usable(object.id())) return;
    if (object.type() == osmium::item_type::node)
      look_at(static_cast<const osmium::Node&>(object));
    else if (object.type() == osmium::item_type::way)
      look_at(static_cast<const osmium::Way&>(object));
    else if (object.type() == osmium::item_type::relation)
      look_at(static_cast<const osmium::Relation&>(object));
  }
  /// Second look at ways: those that multipolygons asked for.
  void complete(const osmium::Way& way) {
    if (is_usable(way.id()) && completing_.get(way.id())) take_nodes(way);
  }
  [[nodiscard]] bool keeps(const osmium::OSMObject& object) const {
    if (!is_usable(object.id())) return false;
    const auto id = object.id();
    switch (object.type()) {
      case osmium::item_type::node:
        return nodes_.get(id);
      case osmium::item_type::way:
        return ways_.get(id) || completing_.get(id);
      default:
        return relations_.get(id);
    }
  }
  [[nodiscard]] const Box2& seen() const { return seen_; }
  [[nodiscard]] bool empty() const { return !any_; }

 private:
  void look_at(const osmium::Node& node) {
    if (!node.location().valid()) return;
    const Vec2 p{node.location().lon(), node.location().lat()};
    seen_ = {std::min(seen_.min_x, p.x), std::min(seen_.min_y, p.y), std::max(seen_.max_x, p.x),
             std::max(seen_.max_y, p.y)};
    if (!box_.contains(p)) return;
    inside_.set(node.id()), nodes_.set(node.id());
    any_ = true;
  }
  void look_at(const osmium::Way& way) {
    const bool inside = std::any_of(way.nodes().begin(), way.nodes().end(), [&](const osmium::NodeRef& ref) {
      return is_usable(ref.ref()) && inside_.get(ref.ref());
    });
    if (!inside) return;
    ways_.set(way.id());
    take_nodes(way);
  }
  void look_at(const osmium::Relation& relation) {
    const auto is_ours = [&](const osmium::RelationMember& member) {
      if (!is_usable(member.ref())) return false;
      const auto id = member.ref();
      return (member.type() == osmium::item_type::node && inside_.get(id)) ||
             (member.type() == osmium::item_type::way && ways_.get(id));
    };
    if (std::none_of(relation.members().begin(), relation.members().end(), is_ours)) return;
    relations_.set(relation.id());
    const char* kind = relation.tags()["type"];
    if (!kind || std::strcmp(kind, "multipolygon") != 0) return;
    for (const osmium::RelationMember& member : relation.members())
      if (member.type() == osmium::item_type::way && is_usable(member.ref())) completing_.set(member.ref());
  }
  void take_nodes(const osmium::Way& way) {
    for (const osmium::NodeRef& ref : way.nodes())
      if (is_usable(ref.ref())) nodes_.set(ref.ref());
  }

  Box2 box_, seen_{180.0, 90.0, -180.0, -90.0};
  Ids inside_, nodes_, ways_, relations_;
  Ids completing_;  ///< ways that only multipolygons ask for
  bool any_ = false;
};

/// Of the data; only the header of a binary file tells it.
std::string osm_timestamp(const fs::path& path) {
  if (osm_syntax(path) != OsmSyntax::binary) return {};
  osmium::io::Reader reader(path.string(), osmium::osm_entity_bits::nothing);
  const std::string timestamp = reader.header().get("osmosis_replication_timestamp");
  reader.close();
  return timestamp;
}

osmium::io::File output_file(const fs::path& path, const fs::path& target) {
  const bool pbf = target.extension() == ".pbf";
  return osmium::io::File(path.string(), pbf ? "pbf,add_metadata=none" : "xml,add_metadata=none");
}
}  // namespace

CutOsm cut_osm(const fs::path& from, const fs::path& to, const Box2& lonlat) {
  return with_osm_errors(from, [&] {
    CutOsm result;
    Selection selection(lonlat);
    read_osm_sorted(from, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::OSMObject& object : buffer.select<osmium::OSMObject>()) selection.look_at(object);
    });
    if (selection.empty())
      throw InputError(from.string(),
                       fmt::format("holds nothing of the area: it covers {}, the area is {}; take another extract",
                                   describe_lonlat(selection.seen()), describe_lonlat(lonlat)));
    read_osm_buffers(from, type::way, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Way& way : buffer.select<osmium::Way>()) selection.complete(way);
    });
    AtomicFile out(to);
    result.timestamp = osm_timestamp(from);
    osmium::io::Header header;
    header.set("generator", "orthodrive");
    header.set("sorting", "Type_then_ID");
    header.add_box(osmium::Box(lonlat.min_x, lonlat.min_y, lonlat.max_x, lonlat.max_y));
    osmium::io::Writer writer(output_file(out.path(), to), header, osmium::io::overwrite::allow);
    read_osm_sorted(from, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::OSMObject& object : buffer.select<osmium::OSMObject>()) {
        if (!selection.keeps(object)) continue;
        ++(object.type() == osmium::item_type::node  ? result.nodes
           : object.type() == osmium::item_type::way ? result.ways
                                                     : result.relations);
        writer(object);
      }
    });
    writer.close();
    out.commit();
    return result;
  });
}

}  // namespace orthodrive::io

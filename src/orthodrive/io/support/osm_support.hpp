// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shared by the OSM readers of io.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <osmium/io/any_input.hpp>
#include <osmium/memory/buffer.hpp>
#include <osmium/osm/location.hpp>
#include <osmium/osm/object.hpp>
#include <osmium/osm/object_comparisons.hpp>
#include <osmium/osm/tag.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/geo/vec.hpp"
#include "orthodrive/io/support/osm_text.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::io {

/// In degrees; NaN for a node without a place.
inline Vec2 lonlat_of(const osmium::Location& place) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  return place.valid() ? Vec2{place.lon(), place.lat()} : Vec2{nan, nan};
}

/// What libosmium says of a file that is whole, but in a form that it does not read; getting it again is of no use.
inline bool is_other_osm_form(std::string_view what) {
  return what.find("blobs not supported") != what.npos || what.find("required feature not supported") != what.npos ||
         what.find("blob contains no data") != what.npos || what.find("Can not read file with version") != what.npos;
}

/// Runs `read`, turning whatever libosmium throws into an InputError of the file.
template <typename F>
auto with_osm_errors(const std::filesystem::path& path, F&& read) {
  if (!std::filesystem::exists(path)) throw InputError(path.string(), "no such file");
  if (std::filesystem::file_size(path) == 0) throw InputError(path.string(), "is empty; get the file again");
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {  // io_error, xml_error, pbf_error, protozero's, system_error
    if (is_other_osm_form(error.what()))
      throw InputError(
          path.string(),
          fmt::format("is OSM in a form that is not read ({}); write it anew as .osm or .osm.pbf with a program that "
                      "reads it, for example: osmium cat IN -o OUT.osm.pbf",
                      printable(error.what())));
    throw InputError(
        path.string(),
        fmt::format("not an OSM file (.osm, .osm.pbf, also .gz or .bz2), or truncated ({}); get the file again",
                    printable(error.what())));
  }
}

/// libosmium walks a tag list from zero byte to zero byte, key and value in turn. A PBF string may hold a zero byte of
/// its own; then the walk would leave the list.
inline void check_tags(const osmium::OSMObject& object) {
  const osmium::TagList& tags = object.tags();
  if (std::count(tags.data() + sizeof(osmium::TagList), tags.data() + tags.byte_size(), 0) % 2 != 0)
    throw std::runtime_error(fmt::format("a tag of object {} holds a zero byte", object.id()));
}

/// What a file unpacks to in memory, at most: so many times its size, and some. A node takes some bytes of a PBF file
/// and 64 of memory; a file that was made to exhaust the memory unpacks to ten thousand times its size.
constexpr std::uintmax_t most_expansion = 1000, expansion_slack_bytes = std::uintmax_t{256} << 20;

/// The files of one source that libosmium's own parsers read: PBF, O5M, OPL.
template <typename F>
void read_osm_binary(const std::filesystem::path& path, osmium::osm_entity_bits::type entities, F&& use) {
  osmium::io::Reader reader(path.string(), entities);
  if (reader.header().has_multiple_object_versions())
    throw InputError(path.string(),
                     "holds the history or changes of its objects, not a map; take a snapshot: osmium time-filter");
  while (osmium::memory::Buffer buffer = reader.read()) use(buffer);
  reader.close();
}

/// Reads the nodes, ways or relations of a file, in its order; `use` gets each buffer once its tags are known to be
/// sound. Deleted objects are not there.
template <typename F>
void read_osm_buffers(const std::filesystem::path& path, osmium::osm_entity_bits::type entities, F&& use) {
  const std::uintmax_t most_bytes = most_expansion * std::filesystem::file_size(path) + expansion_slack_bytes;
  std::uintmax_t bytes = 0;
  const auto checked = [&](osmium::memory::Buffer& buffer) {
    bytes += buffer.committed();
    if (bytes > most_bytes)
      throw std::runtime_error(fmt::format("it unpacks to more than {} times its size", most_expansion));
    bool has_deleted = false;
    for (osmium::OSMObject& object : buffer.select<osmium::OSMObject>()) {
      check_tags(object);
      if (object.visible()) continue;
      object.set_removed(true);
      has_deleted = true;
    }
    if (has_deleted) buffer.purge_removed();
    use(buffer);
  };
  const OsmSyntax syntax = osm_syntax(path);
  if (syntax == OsmSyntax::binary)
    read_osm_binary(path, entities, checked);
  else
    read_osm_text(path, syntax, entities, checked);
}

/// Nodes, ways, then relations, each by id (osmium::id_order) and once: the latest version, of equal ones the first.
/// A file that is sorted is read in pieces, another one as a whole.
template <typename F>
void read_osm_sorted(const std::filesystem::path& path, F&& use) {
  const auto precedes = [](const osmium::OSMObject& a, const osmium::OSMObject& b) {
    if (a.type() != b.type()) return a.type() < b.type();
    return osmium::id_order{}(a.id(), b.id());
  };
  bool is_sorted = true;
  osmium::memory::Buffer last{1024, osmium::memory::Buffer::auto_grow::yes};
  const auto nwr = osmium::osm_entity_bits::nwr;
  read_osm_buffers(path, nwr, [&](const osmium::memory::Buffer& buffer) {
    const osmium::OSMObject* before = last.committed() > 0 ? &last.get<osmium::OSMObject>(0) : nullptr;
    for (const osmium::OSMObject& object : buffer.select<osmium::OSMObject>()) {
      is_sorted = is_sorted && (!before || precedes(*before, object));
      before = &object;
    }
    if (!before || buffer.committed() == 0) return;
    osmium::memory::Buffer kept{1024, osmium::memory::Buffer::auto_grow::yes};
    kept.add_item(*before), kept.commit();
    last = std::move(kept);
  });
  if (is_sorted) return read_osm_buffers(path, nwr, use);
  osmium::memory::Buffer all{1 << 20, osmium::memory::Buffer::auto_grow::yes},
      sorted{1 << 20, osmium::memory::Buffer::auto_grow::yes};
  read_osm_buffers(path, nwr, [&](const osmium::memory::Buffer& buffer) { all.add_buffer(buffer), all.commit(); });
  std::vector<const osmium::OSMObject*> objects;
  for (const osmium::OSMObject& object : all.select<osmium::OSMObject>()) objects.push_back(&object);
  std::stable_sort(objects.begin(), objects.end(), [&](const osmium::OSMObject* a, const osmium::OSMObject* b) {
    if (precedes(*a, *b) || precedes(*b, *a)) return precedes(*a, *b);
    return a->version() > b->version();
  });
  const osmium::OSMObject* before = nullptr;
  for (const osmium::OSMObject* object : objects) {
    if (before && !precedes(*before, *object)) continue;
    sorted.add_item(*object), sorted.commit();
    before = object;
  }
  use(sorted);
}

/// Blanks around a value are slips of the keyboard; of a key that is there twice the first value counts.
[[nodiscard]] inline std::map<std::string, std::string> tags_of(const osmium::TagList& list) {
  std::map<std::string, std::string> tags;
  for (const osmium::Tag& tag : list) tags.emplace(tag.key(), roadquery::trimmed(tag.value()));
  return tags;
}

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shared by the OSM readers of io.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <osmium/io/any_input.hpp>
#include <osmium/memory/buffer.hpp>
#include <osmium/osm/object.hpp>
#include <osmium/osm/tag.hpp>
#include <stdexcept>
#include <string>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive::io {

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

/// Reads the nodes, ways or relations of a file; `use` gets each buffer once its tags are known to be sound.
template <typename F>
void read_osm_buffers(const std::filesystem::path& path, osmium::osm_entity_bits::type entities, F&& use) {
  osmium::io::Reader reader(path.string(), entities);
  const std::uintmax_t most_bytes = most_expansion * std::filesystem::file_size(path) + expansion_slack_bytes;
  std::uintmax_t bytes = 0;
  while (osmium::memory::Buffer buffer = reader.read()) {
    bytes += buffer.committed();
    if (bytes > most_bytes)
      throw std::runtime_error(fmt::format("it unpacks to more than {} times its size", most_expansion));
    for (const osmium::OSMObject& object : buffer.select<osmium::OSMObject>()) check_tags(object);
    use(buffer);
  }
  reader.close();
}

[[nodiscard]] inline std::map<std::string, std::string> tags_of(const osmium::TagList& list) {
  std::map<std::string, std::string> tags;
  for (const osmium::Tag& tag : list) tags.emplace(tag.key(), tag.value());
  return tags;
}

}  // namespace orthodrive::io

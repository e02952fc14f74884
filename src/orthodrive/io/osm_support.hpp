#pragma once
// Shared by the OSM readers of io.

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <osmium/io/any_input.hpp>
#include <osmium/osm/tag.hpp>
#include <string>

#include "orthodrive/core/error.hpp"

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
                    error.what()));
  }
}

[[nodiscard]] inline std::map<std::string, std::string> tags_of(const osmium::TagList& list) {
  std::map<std::string, std::string> tags;
  for (const osmium::Tag& tag : list) tags.emplace(tag.key(), tag.value());
  return tags;
}

}  // namespace orthodrive::io

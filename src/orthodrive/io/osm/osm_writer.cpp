// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/osm_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <set>
#include <string>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/escape_xml.hpp"

namespace orthodrive::io {

void write_osm(const std::filesystem::path& path, const OsmData& data) {
  const CoordinateTransform lonlat_from_site(data.crs, Crs{"EPSG:4326"});
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<osm version=\"0.6\" generator=\"orthodrive\">\n";
  const auto end = [](std::string& s) { return std::back_inserter(s); };
  std::string nodes;
  std::set<std::int64_t> known;
  constexpr double inf = std::numeric_limits<double>::infinity();
  double west = inf, south = inf, east = -inf, north = -inf;
  for (const OsmNode& node : data.nodes) {
    const Vec2 q = lonlat_from_site.target_from_source(node.p);
    west = std::min(west, q.x), east = std::max(east, q.x), south = std::min(south, q.y), north = std::max(north, q.y);
    known.insert(node.id);
    fmt::format_to(end(nodes), "  <node id=\"{}\" version=\"1\" visible=\"true\" lat=\"{:.7f}\" lon=\"{:.7f}\"/>\n",
                   node.id, q.y, q.x);
  }
  if (!data.nodes.empty())
    fmt::format_to(end(text), "  <bounds minlat=\"{:.7f}\" minlon=\"{:.7f}\" maxlat=\"{:.7f}\" maxlon=\"{:.7f}\"/>\n",
                   south, west, north, east);
  text += nodes;
  for (const OsmWay& way : data.ways) {
    fmt::format_to(end(text), "  <way id=\"{}\" version=\"1\" visible=\"true\">\n", way.id);
    for (const std::int64_t ref : way.nodes) {
      if (!known.contains(ref))
        throw Error(fmt::format("{}: way {} refers to node {}, which is not in the data", path.string(), way.id, ref));
      fmt::format_to(end(text), "    <nd ref=\"{}\"/>\n", ref);
    }
    for (const auto& [key, value] : way.tags)
      fmt::format_to(end(text), "    <tag k=\"{}\" v=\"{}\"/>\n", escape_xml(key), escape_xml(value));
    text += "  </way>\n";
  }
  text += "</osm>\n";
  write_text_file(path, text);
}

}  // namespace orthodrive::io

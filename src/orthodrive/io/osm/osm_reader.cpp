// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/osm_reader.hpp"

#include <algorithm>
#include <osmium/osm/node.hpp>
#include <osmium/osm/way.hpp>

#include "orthodrive/io/support/osm_support.hpp"

namespace orthodrive::io {

OsmData read_osm(const std::filesystem::path& path, const Crs& target_crs) {
  return with_osm_errors(path, [&] {
    const CoordinateTransform transform(Crs{"EPSG:4326"}, target_crs);
    OsmData data{.crs = target_crs};
    const auto nodes_and_ways = osmium::osm_entity_bits::node | osmium::osm_entity_bits::way;
    read_osm_buffers(path, nodes_and_ways, [&](const osmium::memory::Buffer& buffer) {
      for (const osmium::Node& node : buffer.select<osmium::Node>())
        if (node.location().valid())
          data.nodes.push_back(
              {node.id(), transform.target_from_source({node.location().lon(), node.location().lat()})});
      for (const osmium::Way& way : buffer.select<osmium::Way>()) {
        OsmWay& copy = data.ways.emplace_back(OsmWay{.id = way.id(), .tags = tags_of(way.tags())});
        for (const osmium::NodeRef& node : way.nodes()) copy.nodes.push_back(node.ref());
      }
    });
    const auto by_id = [](const auto& a, const auto& b) { return a.id < b.id; };
    std::stable_sort(data.nodes.begin(), data.nodes.end(), by_id);
    std::stable_sort(data.ways.begin(), data.ways.end(), by_id);
    return data;
  });
}

}  // namespace orthodrive::io

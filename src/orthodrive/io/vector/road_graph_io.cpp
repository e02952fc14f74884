// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/vector/road_graph_io.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "orthodrive/io/support/geojson_support.hpp"

namespace orthodrive::io {
namespace {
using nlohmann::json;

/// Millimetres; null for what is not known.
json rounded(double value) { return std::isnan(value) ? json() : json(std::round(value * 1e3) / 1e3); }

template <typename Value>
json numbers_of(const RoadPath& path, const Value& value) {
  json numbers = json::array();
  for (const RoadNode& node : path.nodes) numbers.push_back(rounded(value(node)));
  return numbers;
}

std::string feature_of(const LonLatWriter& writer, const RoadPath& path, const char* state, json numbers) {
  numbers["state"] = state;
  numbers["osm_id"] = path.osm_id, numbers["part"] = path.part;
  numbers["name"] = path.name, numbers["highway"] = path.highway;
  return geojson_feature(geojson_geometry("LineString", writer.line(centerline(path))), numbers);
}

/// Pieces of one way share its id.
using PathsOfWay = std::multimap<std::int64_t, const RoadPath*>;

double nearest_height_m(const PathsOfWay& ways, std::int64_t osm_id, Vec2 p) {
  double least_m = std::numeric_limits<double>::infinity(), z_m = std::numeric_limits<double>::quiet_NaN();
  const auto [first, last] = ways.equal_range(osm_id);
  for (auto at = first; at != last; ++at)
    for (const RoadNode& node : at->second->nodes)
      if (const double distance_m = distance(node.p, p); distance_m < least_m) least_m = distance_m, z_m = node.z_m;
  return z_m;
}
}  // namespace

void write_road_graph(const std::filesystem::path& path, const RoadNetwork& before, const RoadNetwork& after) {
  const LonLatWriter writer(after.crs);
  PathsOfWay ways;
  for (const RoadPath& way : after.paths) ways.emplace(way.osm_id, &way);
  std::vector<std::string> features;
  for (const RoadPath& way : before.paths) {
    const auto height = [&](const RoadNode& node) { return nearest_height_m(ways, way.osm_id, node.p); };
    features.push_back(feature_of(writer, way, "before", {{"z_m", numbers_of(way, height)}}));
  }
  for (const RoadPath& way : after.paths)
    features.push_back(
        feature_of(writer, way, "after",
                   {{"z_m", numbers_of(way, [](const RoadNode& n) { return n.z_m; })},
                    {"width_m", numbers_of(way, [](const RoadNode& n) { return n.width_m; })},
                    {"sigma_offset_m", numbers_of(way, [](const RoadNode& n) { return n.sigma_offset_m; })},
                    {"sigma_width_m", numbers_of(way, [](const RoadNode& n) { return n.sigma_width_m; })}}));
  write_geojson_features(path, features);
}

}  // namespace orthodrive::io

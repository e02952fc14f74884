// SPDX-License-Identifier: Apache-2.0
// GeoJSON, by hand: RFC 7946 is small, and the order and digits of what we write are ours.

#include "orthodrive/io/support/geojson_support.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/atomic_file.hpp"

namespace orthodrive::io {

std::string LonLatWriter::point(Vec2 p) const {
  const Vec2 q = lonlat_from_site_.target_from_source(p);
  return fmt::format("[{:.{}f},{:.{}f}]", q.x, decimals_, q.y, decimals_);
}

std::string LonLatWriter::line(const Polyline& line) const {
  std::string text = "[";
  for (const Vec2 p : line) text += (text.size() > 1 ? "," : "") + point(p);
  return text + "]";
}

std::string LonLatWriter::ring(Ring ring, bool outer) const {
  if ((signed_area_m2(ring) > 0.0) != outer) std::reverse(ring.begin(), ring.end());
  if (!ring.empty()) ring.push_back(ring.front());
  return line(ring);
}

std::string LonLatWriter::polygon(const Polygon& polygon) const {
  std::string text = "[" + ring(polygon.outer, true);
  for (const Ring& hole : polygon.holes) text += "," + ring(hole, false);
  return text + "]";
}

std::string geojson_geometry(const char* type, const std::string& coordinates) {
  return fmt::format(R"({{"type":"{}","coordinates":{}}})", type, coordinates);
}

std::string geojson_feature(const std::string& geometry, const nlohmann::json& properties) {
  return fmt::format(R"({{"type":"Feature","properties":{},"geometry":{}}})",
                     properties.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace), geometry);
}

void write_geojson_features(const std::filesystem::path& path, const std::vector<std::string>& features) {
  write_text_file(
      path, fmt::format("{{\"type\":\"FeatureCollection\",\"features\":[\n{}\n]}}\n", fmt::join(features, ",\n")));
}

}  // namespace orthodrive::io

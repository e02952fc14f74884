// SPDX-License-Identifier: Apache-2.0
#pragma once
// Texts of GeoJSON (RFC 7946). Internal to io.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive::io {

/// Coordinates in WGS84, longitude first, 7 decimals.
class LonLatWriter {
 public:
  /// Places for people to look at need 7 decimals of a degree (1 cm), outlines that must stay valid 9.
  explicit LonLatWriter(const Crs& crs, int decimals = 7)
      : lonlat_from_site_(crs, Crs{"EPSG:4326"}), decimals_(decimals) {}
  [[nodiscard]] std::string point(Vec2 p) const;
  [[nodiscard]] std::string line(const Polyline& line) const;
  /// Closed; outer rings counter-clockwise, holes clockwise (RFC 7946, 3.1.6).
  [[nodiscard]] std::string ring(Ring ring, bool outer) const;
  [[nodiscard]] std::string polygon(const Polygon& polygon) const;

 private:
  CoordinateTransform lonlat_from_site_;
  int decimals_ = 7;
};

[[nodiscard]] std::string geojson_geometry(const char* type, const std::string& coordinates);
/// What is no UTF-8 is replaced.
[[nodiscard]] std::string geojson_feature(const std::string& geometry, const nlohmann::json& properties);
void write_geojson_features(const std::filesystem::path& path, const std::vector<std::string>& features);

}  // namespace orthodrive::io

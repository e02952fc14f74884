// SPDX-License-Identifier: Apache-2.0
#pragma once
// An OpenDRIVE network as layers to look at and to analyse: GeoPackage and GeoJSON.

#include <filesystem>

#include "roadquery/map/road_map.hpp"

namespace orthodrive::io {

/// Layers, from the map's own reference lines and lane widths, within 2 cm of the curves:
///   reference_lines  LineString: road, junction (-1: none), osm_id, name, highway, length_m, speed_kmh, layer, bridge,
///   tunnel lanes            Polygon:    road, section, lane, type, junction, osm_id; lanes that are nowhere 1 cm wide
///   are left out junctions        Polygon:    junction, connections, roads; the convex hull of its connecting roads'
///   lanes
/// In a GeoPackage in the map's CRS, the lines with heights; dates as write_roads has them. Throws InputError for a map
/// without geoReference.
void write_network_layers(const std::filesystem::path& path, const roadquery::RoadMap& map);

/// The same in one FeatureCollection in WGS84 as RFC 7946 has it (7 decimals); the property "layer_name" tells them
/// apart. Without heights: RFC 7946 counts them from the ellipsoid, ours are above the sea.
void write_network_geojson(const std::filesystem::path& path, const roadquery::RoadMap& map);

}  // namespace orthodrive::io

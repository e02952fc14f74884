// SPDX-License-Identifier: Apache-2.0
#pragma once
// Vectors: OSM, GeoPackage, GeoJSON <-> model.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/model/roads/road_roughness.hpp"
#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::io {

/// Drivable ways (model/roads/road_network.hpp: is_drivable) of OSM files (.osm, .osm.pbf, Overpass JSON), clipped to
/// the area. An object that is in several files counts once: its latest version, of equal ones that of the first file;
/// halves of a way that extracts cut are joined. Objects may stand in any order.
/// Nodes carry their OSM id, width_m = width tag (metres) or default_width_m, offset 0. Where a way leaves the area it
/// is cut (no_osm_node there) and its pieces are counted. From south-west to north-east, whatever their ids, then by
/// part. Throws InputError for a missing or truncated file and when no road lies in the area (says where the roads
/// lie). Findings: "osm.odd_tag" (width=wide, lanes=0: the default counts), "osm.doubled_nodes" (dropped),
/// "osm.missing_node" (the way is cut there), "osm.no_length" (a way in one place: left out), "osm.lane_tags" (tags of
/// lanes and speed that contradict each other or cannot be read, with what was taken), "osm.tag_not_read" (for each tag
/// and value that tag_rules lists as not read), "osm.restriction_not_read" (osm_restrictions.hpp), and the codes of
/// omitted ways (osm_structure_tags.hpp). Turn restrictions and signs at nodes come along. Turning circles and passing
/// places widen their roads.
[[nodiscard]] RoadNetwork read_osm_roads(const std::vector<std::filesystem::path>& files, const SiteFrame& site,
                                         Findings* findings = nullptr);
[[nodiscard]] RoadNetwork read_osm_roads(const std::filesystem::path& path, const SiteFrame& site,
                                         Findings* findings = nullptr);

/// Why an area of OSM has no polygon: its ring is open or crosses itself, or a part of it is not in the file.
struct MissingArea {
  std::string why;  ///< empty: nothing is missing
  Box2 box;         ///< around what is known of it, in the CRS asked for
};

/// A polygon or line with its tags, in the site CRS, from GeoJSON, GeoPackage or the closed ways / open ways of .osm.
struct Feature {
  MultiPolygon polygons;
  std::vector<Polyline> lines;
  std::vector<Vec2> points;
  std::map<std::string, std::string> tags;
  std::string osm_id;  ///< "node/1", "way/123", "relation/45"; empty: not of OSM
  std::uint32_t osm_version = 0;
  MissingArea missing;  ///< of closed ways and multipolygons of OSM
};
[[nodiscard]] std::vector<Feature> read_features(const std::filesystem::path& path, const Crs& target_crs);
/// Of several files, in their order. An object of OSM that is in several of them counts once, in its latest version.
[[nodiscard]] std::vector<Feature> read_features(const std::vector<std::filesystem::path>& files,
                                                 const Crs& target_crs);
/// Closed and open ways and multipolygon relations of an OSM file with at least one tag, and nodes with natural=tree,
/// highway=street_lamp or what object_kind() knows. Areas that cannot be assembled come without polygons and say why.
[[nodiscard]] std::vector<Feature> read_osm_features(const std::filesystem::path& path, const Crs& target_crs);

/// roads.gpkg: layers centrelines, nodes, surface as docs/build.md lists them. Dates are fixed unless the
/// environment sets OGR_CURRENT_DATE, so that the same roads give the same bytes. Measured roughness makes a layer
/// more.
void write_roads(const std::filesystem::path& path, const RoadNetwork& roads,
                 const std::vector<RoughnessStretch>& roughness = {});
/// The layer roughness of a roads.gpkg, ordered by way, part and s; empty when there is none.
[[nodiscard]] std::vector<RoughnessStretch> read_roughness(const std::filesystem::path& path);
[[nodiscard]] RoadNetwork read_roads(const std::filesystem::path& path);
/// Whether the file has the layers that read_roads needs. Throws InputError when it is no vector file at all.
[[nodiscard]] bool holds_roads(const std::filesystem::path& path);

/// A layer to look at in QGIS: features with numbers, one a field. NaN becomes null.
struct NumberLayer {
  using Geometry = std::variant<Polygon, Polyline, Vec2>;
  struct Row {
    Geometry geometry;
    std::vector<double> numbers;
  };
  std::string name;
  std::vector<std::string> fields;
  std::vector<Row> rows;
};
/// A GeoPackage with these layers, in this order; dates as write_roads has them.
void write_layers(const std::filesystem::path& path, const std::vector<NumberLayer>& layers, const Crs& crs);

/// GeoJSON in WGS84 (7 decimals), points with severity, code, message.
void write_findings(const std::filesystem::path& path, const Findings& findings, const Crs& crs);
/// GeoJSON polygons / lines in WGS84 (RFC 7946) with the tags as properties.
void write_geojson(const std::filesystem::path& path, const std::vector<Feature>& features, const Crs& crs);

}  // namespace orthodrive::io

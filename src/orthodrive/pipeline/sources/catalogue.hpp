// SPDX-License-Identifier: Apache-2.0
#pragma once
// The catalogue of open sources: photos, terrain models and OSM, with licence, resolution and area. Text files of the
// folder catalogue/; docs/new.md says how to add one.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_mark_rules.hpp"
#include "orthodrive/model/roads/speed_laws.hpp"

namespace orthodrive {

/// A country or state: coarse outline in degrees of WGS84, some kilometres outside the border.
struct CatalogueArea {
  std::string id, name;
  std::string geofabrik;  ///< path of its OSM extract at download.geofabrik.de; empty: none
  MultiPolygon outline;
};

/// The rectangles in which a server keeps its data, or in which it is asked for them.
struct SourceCells {
  std::string crs;
  Vec2 size;                      ///< width and height, in the unit of the CRS
  Vec2 origin;                    ///< a corner of a cell, in the unit of the CRS
  std::vector<std::string> rows;  ///< names of rows, the first one south of the origin; empty: they have none
};

struct CatalogueSource {
  std::string id, name;
  std::string what;                ///< photo | terrain | osm
  std::vector<std::string> areas;  ///< ids of areas, or "world"
  /// As in a [[fetch]] table. The url may hold fields of cells: cell_urls.
  std::string kind, url, crs, layer, style, format, tile_matrix_set, time, subdomains;
  std::optional<int> min_zoom, max_zoom;
  double resolution_m = 0.0;  ///< of the data, m; 0 for OSM
  std::string licence, licence_url, attribution;
  std::string vertical_datum, vertical_unit;  ///< of terrain
  std::optional<SourceCells> cells;
  bool surface = false;   ///< a surface model: with woods and houses
  bool gaps = false;      ///< it lacks places within its areas: another one has to lie below it
  bool automatic = true;  ///< whether `orthodrive fetch` can get it; else `note` says how to
  double most_km2 = 0.0;  ///< larger sites should take another source; 0: no limit
  std::string note;       ///< keys, terms, traps
  std::string checked;    ///< documentation | use | memory
  std::string checked_against;
};

struct Catalogue {
  std::vector<CatalogueArea> areas;
  std::vector<CatalogueSource> sources;
};

/// Reads areas.toml, photo.toml, terrain.toml and osm.toml of a folder. Throws InputError with file, line and key for
/// whatever is wrong in them: unknown keys, kinds and areas, ids that are there twice, terrain without a datum.
[[nodiscard]] Catalogue read_catalogue(const std::filesystem::path& folder);
/// A part of a country with a law of its own, of parts.toml; outline as of CatalogueArea, but over the country's
/// border.
struct CountryPart {
  std::string id, name;  ///< ISO 3166-2; English
  MultiPolygon outline;
};
/// A country of countries.toml; outline as of CatalogueArea.
struct Country {
  std::string id, name;  ///< ISO 3166-1; English
  DrivingSide driving_side = DrivingSide::right;
  MultiPolygon outline;
  std::vector<CountryPart> parts;  ///< not all of the country: those with laws of their own
};
/// Reads countries.toml and parts.toml of a folder; throws as read_catalogue().
[[nodiscard]] std::vector<Country> read_countries(const std::filesystem::path& folder);
/// That of a place in degrees; null: none of these.
[[nodiscard]] const Country* country_at(const std::vector<Country>& countries, Vec2 lonlat);
/// The country of an id, or that of which the id names a part; null: none of these.
[[nodiscard]] const Country* country_of(const std::vector<Country>& countries, const std::string& id);
/// Whose law counts at a place of the country, in degrees: the id of its part there, else its own. Where outlines
/// overlap, that of the smaller polygon counts: it may be enclosed by the other, as outlines have no holes.
[[nodiscard]] std::string law_at(const Country& country, Vec2 lonlat);
/// Of the country in which the middle of a box (in the CRS) lies: whose law counts there, and the side on which one
/// drives; "" and right where it lies in none, or there is no CRS.
struct PlaceRules {
  std::string country;  ///< as of law_at()
  DrivingSide driving_side = DrivingSide::right;
};
[[nodiscard]] PlaceRules rules_at(const Crs& crs, const Box2& box);
/// The side that was told, else that of rules_at().
[[nodiscard]] DrivingSide driving_side_in(const std::optional<DrivingSide>& told, const Crs& crs, const Box2& box);
/// Throws OptionError, with the closest id, for what is no country of countries.toml and has no law of its own; with
/// that of its country for other parts of one.
void check_country(const std::string& id);
/// Reads speed_limits.toml of a folder, without `here`; throws as read_catalogue().
[[nodiscard]] SpeedLaws read_speed_laws(const std::filesystem::path& folder);
/// Reads road_marks.toml of a folder, without `here`; throws as read_catalogue().
[[nodiscard]] RoadMarkRules read_road_marks(const std::filesystem::path& folder);

/// The folder that is installed with the tool, or that of the source tree.
[[nodiscard]] std::filesystem::path catalogue_folder();

/// Share of the polygon of degrees inside the areas of a source, 0 to 1; by sampled points.
[[nodiscard]] double coverage_of(const Catalogue& catalogue, const CatalogueSource& source, const Polygon& lonlat);

/// The smallest area with an OSM extract that holds the whole polygon; null: none.
[[nodiscard]] const CatalogueArea* extract_area(const Catalogue& catalogue, const Polygon& lonlat);

/// The addresses of a source for a polygon of degrees: one per cell that overlaps its bounds, south-west first; the url
/// itself for sources without cells. Fields of the url: {west} {south} {east} {north} (unit of the CRS), {west_km}
/// {south_km}, {width} {height} (pixels at resolution_m), {sw} ("N48_00_E011_00"), {nw} ("n49w106"), {row} (its name)
/// and {column} (cells east of the origin, two digits). Cells of rows without a name are left out.
/// Throws OptionError for more than 10000 cells, and where no cell is left.
[[nodiscard]] std::vector<std::string> cell_urls(const CatalogueSource& source, const Polygon& lonlat);

}  // namespace orthodrive

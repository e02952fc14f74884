// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/catalogue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "orthodrive/core/closest_word.hpp"
#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/support/read_file.hpp"
#include "orthodrive/pipeline/files/toml_section.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

constexpr double most_cells = 10000;
const std::vector<std::string> kinds{"wmts",        "xyz",    "tms",  "wms",  "cog",   "overpass",
                                     "osm_extract", "raster", "stac", "atom", "sheets"};

Ring read_ring(const TomlSection& section, const toml::node& node) {
  Ring ring;
  if (!node.is_array()) section.fail(node, "'rings' must be a list of rings");
  for (const toml::node& item : *node.as_array()) {
    const toml::array* point = item.as_array();
    const auto lon = point && point->size() == 2 ? (*point)[0].value<double>() : std::nullopt;
    const auto lat = lon ? (*point)[1].value<double>() : std::nullopt;
    if (!lat || std::abs(*lon) > 180.0 || std::abs(*lat) > 90.0)
      section.fail(item, "'rings' must hold [longitude, latitude]");
    ring.push_back({*lon, *lat});
  }
  if (ring.size() < 4 || ring.front() != ring.back())
    section.fail(node, "a ring needs three corners and its first one again at its end");
  ring.pop_back();
  return ring;
}

MultiPolygon read_outline(TomlSection& section) {
  MultiPolygon outline;
  const toml::node* rings = section.find("rings");
  if (!rings->is_array()) section.fail(*rings, "'rings' must be a list of rings");
  for (const toml::node& ring : *rings->as_array()) outline.push_back({read_ring(section, ring), {}});
  if (outline.empty()) section.fail(*rings, "'rings' is empty");
  return outline;
}

CatalogueArea read_area_entry(TomlSection& section) {
  CatalogueArea area;
  for (const char* key : {"id", "name", "rings"}) section.require(key);
  section.read("id", area.id);
  section.read("name", area.name);
  section.read("geofabrik", area.geofabrik);
  area.outline = read_outline(section);
  return area;
}

Country read_country(TomlSection& section) {
  Country country;
  for (const char* key : {"id", "name", "driving_side", "rings"}) section.require(key);
  section.read("id", country.id);
  section.read("name", country.name);
  std::string side = "right";
  section.read_choice("driving_side", side, {"right", "left"});
  country.driving_side = driving_side_of(side);
  country.outline = read_outline(section);
  return country;
}

CountryPart read_part(TomlSection& section, const std::vector<Country>& countries) {
  CountryPart part;
  for (const char* key : {"id", "name", "rings"}) section.require(key);
  section.read("id", part.id);
  section.read("name", part.name);
  if (part.id.find('-') == std::string::npos || country_of(countries, part.id) == nullptr)
    section.fail_at("id", "'" + part.id + "' is of no country of countries.toml; write it as US-CA");
  part.outline = read_outline(section);
  return part;
}

/// What a country has, with the id that read_entries() asks for.
template <typename Rules>
struct OfCountry {
  std::string id;
  Rules rules;
};

/// Where an entry comes from: for those who read the file.
void read_origin(TomlSection& section) {
  std::string text;
  for (const char* key : {"source", "checked"}) section.require(key);
  for (const char* key : {"source", "note"}) section.read(key, text);
  section.read_choice("checked", text, {"documentation", "use", "memory"});
  section.finish();
}

OfCountry<SpeedLaw> read_speed_law(TomlSection& section) {
  constexpr double mile_km = 1.609344, most_kmh = 200.0;
  OfCountry<SpeedLaw> entry;
  for (const char* key : {"id", "unit", "urban"}) section.require(key);
  section.read("id", entry.id);
  SpeedLaw& law = entry.rules;
  law.country = entry.id;
  std::string unit;
  section.read_choice("unit", unit, {"km/h", "mph"});
  law.unit_kmh = unit == "mph" ? mile_km : 1.0;
  for (const auto& [key, limit] : {std::pair{"living_street", &law.living_street},
                                   {"bicycle_road", &law.bicycle_road},
                                   {"urban", &law.urban},
                                   {"rural", &law.rural},
                                   {"rural_dual", &law.rural_dual},
                                   {"national", &law.national},
                                   {"motorroad", &law.motorroad},
                                   {"motorway", &law.motorway}}) {
    if (!section.has(key)) continue;
    section.read(key, *limit);
    *limit *= law.unit_kmh;
    if (!(*limit > 0.0 && *limit < most_kmh)) section.fail_at(key, "must be a speed above 0 and below 200 km/h");
  }
  read_origin(section);
  return entry;
}

StrokeRule read_strokes(TomlSection& section) {
  StrokeRule strokes;
  for (const auto& [key, number] :
       {std::pair{"to_kmh", &strokes.to_kmh}, {"stroke_m", &strokes.stroke_m}, {"gap_m", &strokes.gap_m}}) {
    section.require(key);
    section.read(key, *number);
    if (!(*number > 0.0)) section.fail_at(key, "must be above 0");
  }
  return strokes;
}

OfCountry<RoadMarkRule> read_road_mark_rule(TomlSection& section) {
  OfCountry<RoadMarkRule> entry;
  section.require("id");
  section.read("id", entry.id);
  RoadMarkRule& rule = entry.rules;
  rule.country = entry.id;
  for (const auto& [key, color] :
       {std::pair{"between_directions", &rule.between_directions}, {"inner_edge", &rule.inner_edge}})
    if (section.has(key)) section.read_choice(key, *color, {"white", "yellow"});
  section.read("double_centre", rule.is_solid_centre_double);
  section.for_each_table("strokes", [&](TomlSection& strokes) {
    const StrokeRule next = read_strokes(strokes);
    if (!rule.strokes.empty() && next.to_kmh <= rule.strokes.back().to_kmh)
      strokes.fail_at("to_kmh", "must be above that of the entry before");
    rule.strokes.push_back(next);
  });
  read_origin(section);
  return entry;
}

void read_pair(TomlSection& section, const char* key, Vec2& pair) {
  if (!section.has(key)) return;
  std::vector<double> numbers;
  section.read(key, numbers);
  if (numbers.size() != 2) section.fail_at(key, "must be two numbers, east and north");
  pair = {numbers[0], numbers[1]};
}

void read_cells(TomlSection& section, CatalogueSource& source) {
  if (!section.find_table("cells")) return;
  TomlSection cells = section.section("cells");
  source.cells.emplace();
  for (const char* key : {"crs", "size"}) cells.require(key);
  cells.read("crs", source.cells->crs);
  if (cells.find("size")->is_array()) {
    read_pair(cells, "size", source.cells->size);
  } else {
    cells.read("size", source.cells->size.x);
    source.cells->size.y = source.cells->size.x;
  }
  read_pair(cells, "origin", source.cells->origin);
  cells.read("rows", source.cells->rows);
  cells.finish();
  cells.at("crs", [&] { (void)proj_string({source.cells->crs}); });
  if (!(source.cells->size.x > 0.0 && source.cells->size.y > 0.0)) cells.fail_at("size", "must be greater than 0");
}

void read_address(TomlSection& section, CatalogueSource& source) {
  section.read_choice("kind", source.kind, kinds);
  section.read("url", source.url);
  section.read("crs", source.crs);
  if (!source.crs.empty()) section.at("crs", [&] { (void)proj_string({source.crs}); });
  section.read("layer", source.layer);
  section.read("style", source.style);
  section.read("format", source.format);
  section.read("tile_matrix_set", source.tile_matrix_set);
  section.read("time", source.time);
  section.read("subdomains", source.subdomains);
  for (const auto& [key, zoom] : {std::pair{"min_zoom", &source.min_zoom}, {"max_zoom", &source.max_zoom}}) {
    if (!section.has(key)) continue;
    zoom->emplace(0);
    section.read(key, **zoom);
  }
  section.read("resolution_m", source.resolution_m);
  read_cells(section, source);
}

void check_source(const TomlSection& section, const CatalogueSource& source, const Catalogue& catalogue) {
  if (!source.url.starts_with("https://")) section.fail_at("url", "must begin with https://");
  if (source.what != "osm" && !(source.resolution_m > 0.0)) section.fail_at("resolution_m", "must be greater than 0");
  const bool is_osm_kind = source.kind == "overpass" || source.kind == "osm_extract";
  if ((source.what == "osm") != is_osm_kind)
    section.fail_at("kind", fmt::format("is '{}', which is no kind of {}", source.kind, source.what));
  if (source.what == "terrain" && (source.vertical_datum.empty() || source.vertical_unit.empty()))
    section.fail_here(fmt::format("'{}' is terrain and needs vertical_datum and vertical_unit", source.id));
  if (!source.automatic && source.note.empty())
    section.fail_here(fmt::format("'{}' is not automatic and needs a note that says how to get it", source.id));
  std::vector<std::string> known{"world"};
  for (const CatalogueArea& area : catalogue.areas) known.push_back(area.id);
  for (const std::string& area : source.areas)
    if (std::find(known.begin(), known.end(), area) == known.end())
      section.fail_at("areas",
                      fmt::format("names '{}', which areas.toml does not have{}", area, suggestion(area, known)));
  if (source.areas.empty()) section.fail_at("areas", "is empty");
}

CatalogueSource read_source(TomlSection& section, const std::string& what, const Catalogue& catalogue) {
  CatalogueSource source;
  for (const char* key : {"id", "name", "what", "areas", "kind", "url", "licence", "attribution", "checked"})
    section.require(key);
  section.read("id", source.id);
  section.read("name", source.name);
  section.read_choice("what", source.what, {what});
  section.read("areas", source.areas);
  read_address(section, source);
  section.read("licence", source.licence);
  section.read("licence_url", source.licence_url);
  section.read("attribution", source.attribution);
  section.read("vertical_datum", source.vertical_datum);
  section.read_choice("vertical_unit", source.vertical_unit, {"m", "ft", "us-ft"});
  section.read("surface", source.surface);
  section.read("gaps", source.gaps);
  section.read("automatic", source.automatic);
  section.read("most_km2", source.most_km2);
  section.read("note", source.note);
  section.read_choice("checked", source.checked, {"documentation", "use", "memory"});
  section.read("checked_against", source.checked_against);
  section.finish();
  check_source(section, source, catalogue);
  return source;
}

template <typename Entry, typename Read>
void read_entries(const fs::path& file, const char* key, std::vector<Entry>& entries, const Read& read) {
  if (!fs::is_regular_file(file)) throw InputError(file.string(), "no such file; install the catalogue again");
  const toml::table table = parse_toml(io::read_file(file), file);
  TomlSection root(table, file);
  root.for_each_table(key, [&](TomlSection& section) {
    Entry entry = read(section);
    for (const Entry& other : entries)
      if (other.id == entry.id) section.fail_at("id", fmt::format("'{}' is there already", entry.id));
    entries.push_back(std::move(entry));
  });
  root.finish();
}

bool lies_in(const Catalogue& catalogue, const CatalogueSource& source, Vec2 p) {
  for (const std::string& id : source.areas) {
    if (id == "world") return true;
    for (const CatalogueArea& area : catalogue.areas)
      if (area.id == id && contains(area.outline, p)) return true;
  }
  return false;
}

/// Corners, and places in a grid over the bounds.
std::vector<Vec2> samples_of(const Polygon& lonlat) {
  constexpr int steps = 16;
  std::vector<Vec2> samples = lonlat.outer;
  const Box2 box = bounds_of(lonlat.outer);
  for (int i = 0; i < steps; ++i)
    for (int k = 0; k < steps; ++k) {
      const Vec2 p{box.min_x + box.width() * (i + 0.5) / steps, box.min_y + box.height() * (k + 0.5) / steps};
      if (contains(lonlat, p)) samples.push_back(p);
    }
  return samples;
}

/// A cell: how many lie between it and the origin, to the east and to the north.
struct CellPlace {
  double column, row;
};

std::string cell_url(const CatalogueSource& source, const SourceCells& cells, const CellPlace& cell, bool in_degrees) {
  constexpr double metres_per_degree = 111320.0;
  const double west = cells.origin.x + cell.column * cells.size.x, south = cells.origin.y + cell.row * cells.size.y;
  const auto corner = [](double lat, double lon, const char* north_south, const char* east_west, const char* between) {
    return fmt::format("{}{:02.0f}{}{}{:03.0f}", north_south[lat < 0.0 ? 1 : 0], std::abs(lat), between,
                       east_west[lon < 0.0 ? 1 : 0], std::abs(lon));
  };
  const auto number = [](double value) { return fmt::format("{:.12g}", value); };
  const auto pixels = [&](double size) {
    return fmt::format("{}", std::lround(size * (in_degrees ? metres_per_degree : 1.0) / source.resolution_m));
  };
  const auto row_name = static_cast<std::size_t>(std::max(0.0, -1.0 - cell.row));
  const std::pair<const char*, std::string> fields[] = {
      {"{west}", number(west)},
      {"{south}", number(south)},
      {"{east}", number(west + cells.size.x)},
      {"{north}", number(south + cells.size.y)},
      {"{west_km}", number(west / 1000.0)},
      {"{south_km}", number(south / 1000.0)},
      {"{width}", pixels(cells.size.x)},
      {"{height}", pixels(cells.size.y)},
      {"{sw}", corner(south, west, "NS", "EW", "_00_") + "_00"},
      {"{nw}", corner(south + cells.size.y, west, "ns", "ew", "")},
      {"{row}", row_name < cells.rows.size() ? cells.rows[row_name] : ""},
      {"{column}", fmt::format("{:02.0f}", cell.column)}};
  std::string url = source.url;
  for (const auto& [field, text] : fields)
    for (auto at = url.find(field); at != std::string::npos; at = url.find(field, at + text.size()))
      url.replace(at, std::string_view(field).size(), text);
  return url;
}

/// Whether the sheets' names reach as far as the cell.
bool has_name(const SourceCells& cells, const CellPlace& cell) {
  if (cells.rows.empty()) return true;
  return cell.row < 0.0 && -cell.row <= static_cast<double>(cells.rows.size()) && cell.column >= 0.0;
}

}  // namespace

Catalogue read_catalogue(const fs::path& folder) {
  Catalogue catalogue;
  read_entries(folder / "areas.toml", "area", catalogue.areas, read_area_entry);
  for (const char* what : {"photo", "terrain", "osm"})
    read_entries(folder / (std::string(what) + ".toml"), "source", catalogue.sources,
                 [&](TomlSection& section) { return read_source(section, what, catalogue); });
  return catalogue;
}

std::vector<Country> read_countries(const fs::path& folder) {
  std::vector<Country> countries;
  read_entries(folder / "countries.toml", "country", countries, read_country);
  std::vector<CountryPart> parts;
  read_entries(folder / "parts.toml", "part", parts,
               [&](TomlSection& section) { return read_part(section, countries); });
  for (Country& country : countries)
    for (CountryPart& part : parts)
      if (part.id.starts_with(country.id + "-")) country.parts.push_back(std::move(part));
  return countries;
}

const Country* country_at(const std::vector<Country>& countries, Vec2 lonlat) {
  const auto found = std::ranges::find_if(countries, [&](const Country& c) { return contains(c.outline, lonlat); });
  return found == countries.end() ? nullptr : &*found;
}

const Country* country_of(const std::vector<Country>& countries, const std::string& id) {
  const auto found = std::ranges::find(countries, id.substr(0, id.find('-')), &Country::id);
  return found == countries.end() ? nullptr : &*found;
}

std::string law_at(const Country& country, Vec2 lonlat) {
  const std::string* law = &country.id;
  double least = std::numeric_limits<double>::infinity();
  for (const CountryPart& part : country.parts)
    for (const Polygon& polygon : part.outline)
      if (contains(polygon, lonlat) && area_m2(polygon) < least) law = &part.id, least = area_m2(polygon);
  return *law;
}

SpeedLaws read_speed_laws(const fs::path& folder) {
  std::vector<OfCountry<SpeedLaw>> entries;
  read_entries(folder / "speed_limits.toml", "country", entries, read_speed_law);
  SpeedLaws laws;
  for (OfCountry<SpeedLaw>& entry : entries) laws.laws.push_back(std::move(entry.rules));
  return laws;
}

RoadMarkRules read_road_marks(const fs::path& folder) {
  std::vector<OfCountry<RoadMarkRule>> entries;
  read_entries(folder / "road_marks.toml", "country", entries, read_road_mark_rule);
  RoadMarkRules rules;
  for (OfCountry<RoadMarkRule>& entry : entries) rules.rules.push_back(std::move(entry.rules));
  return rules;
}

PlaceRules rules_at(const Crs& crs, const Box2& box) {
  if (crs.definition.empty()) return {};
  const std::vector<Country> countries = read_countries(catalogue_folder());
  const CoordinateTransform lonlat_from_crs(crs, Crs{"EPSG:4326"});
  const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  const Vec2 lonlat = lonlat_from_crs.target_from_source(middle);
  const Country* country = country_at(countries, lonlat);
  return country ? PlaceRules{law_at(*country, lonlat), country->driving_side} : PlaceRules{};
}

DrivingSide driving_side_in(const std::optional<DrivingSide>& told, const Crs& crs, const Box2& box) {
  return told ? *told : rules_at(crs, box).driving_side;
}

void check_country(const std::string& id) {
  const std::vector<Country> countries = read_countries(catalogue_folder());
  std::vector<std::string> known;
  known.reserve(countries.size());
  for (const Country& country : countries) known.push_back(country.id);
  for (const SpeedLaw& law : read_speed_laws(catalogue_folder()).laws) known.push_back(law.country);
  if (std::ranges::find(known, id) != known.end()) return;
  if (const Country* country = country_of(countries, id); country && id.size() > country->id.size() + 1)
    throw OptionError(fmt::format("'{}' is no part of {} that has a law of its own in the catalogue; take {}", id,
                                  country->name, country->id));
  const std::optional<std::string> meant = closest_word(id, known);
  throw OptionError(fmt::format(
      "'{}' is no country that the catalogue knows; take a code of ISO 3166-1 such as SE, or of 3166-2 such as US-CA{}",
      id, meant ? "; did you mean '" + *meant + "'?" : ""));
}

fs::path catalogue_folder() {
  return find_resource(resource_folders("catalogue", "catalogue"), "areas.toml", "catalogue",
                       "install the tool again, or name the folder with --catalogue")
      .parent_path();
}

double coverage_of(const Catalogue& catalogue, const CatalogueSource& source, const Polygon& lonlat) {
  const std::vector<Vec2> samples = samples_of(lonlat);
  const auto inside =
      std::count_if(samples.begin(), samples.end(), [&](Vec2 p) { return lies_in(catalogue, source, p); });
  return static_cast<double>(inside) / static_cast<double>(samples.size());
}

const CatalogueArea* extract_area(const Catalogue& catalogue, const Polygon& lonlat) {
  const std::vector<Vec2> samples = samples_of(lonlat);
  const CatalogueArea* smallest = nullptr;
  double least = 0.0;
  for (const CatalogueArea& area : catalogue.areas) {
    if (area.geofabrik.empty()) continue;
    if (!std::all_of(samples.begin(), samples.end(), [&](Vec2 p) { return contains(area.outline, p); })) continue;
    double size = 0.0;
    for (const Polygon& part : area.outline) size += area_m2(part);
    if (smallest && size >= least) continue;
    smallest = &area;
    least = size;
  }
  return smallest;
}

std::vector<std::string> cell_urls(const CatalogueSource& source, const Polygon& lonlat) {
  if (!source.cells) return {source.url};
  const CoordinateTransform cells_from_lonlat(Crs{"EPSG:4326"}, Crs{source.cells->crs});
  Ring placed;
  for (std::size_t i = 0; i < lonlat.outer.size(); ++i) {  // with places along the edges: they are bent there
    const Vec2 from = lonlat.outer[i], along = lonlat.outer[(i + 1) % lonlat.outer.size()] - from;
    for (int k = 0; k < 8; ++k) placed.push_back(cells_from_lonlat.target_from_source(from + along * (k / 8.0)));
  }
  const SourceCells& cells = *source.cells;
  // Terrain is read 50 m beyond the area. Cells of degrees are too large to take one more for that.
  const bool in_degrees = proj_string({cells.crs}).find("+proj=longlat") != std::string::npos;
  const Box2 box = bounds_of(placed).grown(in_degrees ? 0.0 : 100.0);
  const auto at = [](double place, double origin, double size) { return (place - origin) / size; };
  const double west = std::floor(at(box.min_x, cells.origin.x, cells.size.x)),
               south = std::floor(at(box.min_y, cells.origin.y, cells.size.y)),
               east = std::ceil(at(box.max_x, cells.origin.x, cells.size.x)),
               north = std::ceil(at(box.max_y, cells.origin.y, cells.size.y));
  if ((east - west) * (north - south) > most_cells)
    throw OptionError(fmt::format("the area needs {:.0f} squares of {}, more than {:.0f}; give a smaller one",
                                  (east - west) * (north - south), source.id, most_cells));
  std::vector<std::string> urls;
  for (double row = south; row < north; ++row)
    for (double column = west; column < east; ++column)
      if (has_name(cells, {column, row})) urls.push_back(cell_url(source, cells, {column, row}, in_degrees));
  if (urls.empty()) throw OptionError(fmt::format("no sheet of {} reaches the area; name another source", source.id));
  return urls;
}

}  // namespace orthodrive

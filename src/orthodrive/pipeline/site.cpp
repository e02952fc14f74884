#include "orthodrive/pipeline/site.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/pipeline/site_fetch.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

toml::table parse(const fs::path& path) {
  if (!fs::exists(path))
    throw InputError(path.string(), "no such site file; `orthodrive synth -o DIR` makes one to start from");
  try {
    return toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    throw InputError(path.string(), fmt::format("line {}: {}", error.source().begin.line, error.description()));
  }
}

void apply_override(toml::table& table, const std::string& text) {
  const auto equals = text.find('='), dot = text.find('.');
  const bool top_level = dot == std::string::npos || dot > equals;
  if (equals == std::string::npos || equals == 0) throw OptionError("--set " + text + ": expected section.key=value");
  const std::string section = top_level ? "" : text.substr(0, dot);
  const std::string key = top_level ? text.substr(0, equals) : text.substr(dot + 1, equals - dot - 1);
  const std::string value = text.substr(equals + 1);
  toml::table parsed;
  try {
    parsed = toml::parse(fmt::format("{} = {}", key, value));
  } catch (const toml::parse_error&) {  // a bare word: drive.route=Circuit
    parsed.insert_or_assign(key, value);
  }
  if (!section.empty() && !table.contains(section)) table.insert(section, toml::table{});
  toml::table* target = section.empty() ? &table : table[section].as_table();
  if (!target) throw OptionError("--set " + text + ": '" + section + "' is not a section");
  for (auto&& [k, v] : parsed) target->insert_or_assign(k, v);
}

void check_keys(const toml::table& table, const std::string& where) {
  static const std::map<std::string, std::vector<std::string>> known{
      {"",
       {"name", "area", "sources", "segment", "refine", "elevate", "network", "drive", "attribution", "truth",
        "fetch"}},
      {"area", {"crs", "bounds", "bbox_wgs84"}},
      {"sources", {"photo", "osm", "dtm", "buildings", "trees", "surroundings", "gpx", "drive_logs"}},
      {"segment", {"model", "crf", "adapt"}},
      {"refine", {"weights", "driving_side"}},
      {"elevate", {"sampling"}},
      {"network", {"crg", "junction_grids", "opendrive", "weather"}},
      {"drive", {"route"}},
      {"attribution", {"text"}},
      {"truth", {"dir"}}};
  const auto check = [&](const std::string& section, const toml::table& part) {
    const auto& keys = known.at(section);
    for (auto&& [key, value] : part) {
      if (std::find(keys.begin(), keys.end(), std::string(key.str())) == keys.end())
        throw OptionError(fmt::format("{}: unknown key '{}{}{}', expected one of: {}", where, section,
                                      section.empty() ? "" : ".", key.str(), fmt::join(keys, ", ")));
    }
  };
  check("", table);
  for (const auto& [section, keys] : known) {
    if (section.empty() || !table.contains(section)) continue;
    const toml::table* part = table[section].as_table();
    if (!part) throw OptionError(where + ": '" + section + "' must be a section");
    check(section, *part);
  }
}

std::string text(const toml::table& table, const fs::path& file, const char* section, const char* key,
                 std::string fallback) {
  const auto node = table[section][key];
  if (!node) return fallback;
  if (const auto value = node.value<std::string>()) return *value;
  throw OptionError(fmt::format("{}: {}.{} must be a text", file.string(), section, key));
}

bool flag(const toml::table& table, const fs::path& file, const char* section, const char* key, bool fallback) {
  const auto node = table[section][key];
  if (!node) return fallback;
  if (const auto value = node.value_exact<bool>()) return *value;
  throw OptionError(fmt::format("{}: {}.{} must be true or false", file.string(), section, key));
}

std::vector<std::string> texts(const toml::table& table, const fs::path& file, const char* section, const char* key) {
  const auto node = table[section][key];
  std::vector<std::string> result;
  if (const auto one = node.value<std::string>()) result.push_back(*one);
  if (const toml::array* many = node.as_array())
    for (const auto& item : *many) {
      const auto value = item.value<std::string>();
      if (!value) throw OptionError(fmt::format("{}: {}.{} must hold texts", file.string(), section, key));
      result.push_back(*value);
    }
  return result;
}

std::optional<std::array<double, 4>> box(const toml::table& table, const fs::path& file, const char* key) {
  const toml::array* values = table["area"][key].as_array();
  if (!values) return std::nullopt;
  std::array<double, 4> result{};
  bool good = values->size() == 4;
  for (std::size_t i = 0; good && i < 4; ++i) {
    const auto value = (*values)[i].value<double>();
    good = value && std::isfinite(*value);
    if (good) result[i] = *value;
  }
  if (!good || result[0] >= result[2] || result[1] >= result[3])
    throw OptionError(
        fmt::format("{}: area.{} must be four numbers: west, south, east, north with west < east and south < north",
                    file.string(), key));
  return result;
}

SiteFrame read_frame(const toml::table& table, const fs::path& file) {
  const auto lonlat = box(table, file, "bbox_wgs84"), metric = box(table, file, "bounds");
  const std::string crs = text(table, file, "area", "crs", "auto");
  if (lonlat.has_value() == metric.has_value())
    throw OptionError(file.string() +
                      ": [area] needs bbox_wgs84 (degrees) or bounds (metres, with crs), and only one of them");
  SiteFrame frame;
  if (metric) {
    if (crs == "auto") throw OptionError(file.string() + ": area.bounds needs area.crs, for example \"EPSG:32633\"");
    const auto [west, south, east, north] = *metric;
    frame.crs = {crs};
    (void)proj_string(frame.crs);  // an unknown CRS is told here, not three stages later
    frame.area.outer = {{west, south}, {east, south}, {east, north}, {west, north}};
    return frame;
  }
  const auto [west, south, east, north] = *lonlat;
  frame.crs = crs == "auto" ? utm_crs(0.5 * (west + east), 0.5 * (south + north)) : Crs{crs};
  const CoordinateTransform transform(Crs{"EPSG:4326"}, frame.crs);
  const Vec2 corners[4] = {{west, south}, {east, south}, {east, north}, {west, north}};
  constexpr int steps = 32;  // an edge of a few km bends by millimetres between two points
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < steps; ++i)
      frame.area.outer.push_back(transform.target_from_source(corners[c] + (corners[(c + 1) % 4] - corners[c]) *
                                                                               (i / static_cast<double>(steps))));
  return frame;
}

}  // namespace

Site read_site(const fs::path& path, const std::vector<std::string>& overrides) {
  toml::table table = parse(path);
  for (const std::string& item : overrides) apply_override(table, item);
  check_keys(table, path.string());

  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const auto located = [&](const std::string& name) { return (folder / name).lexically_normal(); };
  Site site;
  site.name = table["name"].value_or(path.stem().string());
  site.frame = read_frame(table, path);
  for (const char* key : {"photo", "osm", "dtm"})
    if (texts(table, path, "sources", key).empty())
      throw OptionError(fmt::format("{}: sources.{} is missing", path.string(), key));
  site.photo = located(texts(table, path, "sources", "photo").front());
  for (const std::string& name : texts(table, path, "sources", "osm")) site.osm.push_back(located(name));
  for (const std::string& name : texts(table, path, "sources", "buildings")) site.buildings.push_back(located(name));
  for (const std::string& name : texts(table, path, "sources", "trees")) site.trees.push_back(located(name));
  for (const std::string& name : texts(table, path, "sources", "surroundings"))
    site.surroundings.push_back(located(name));
  for (const std::string& name : texts(table, path, "sources", "gpx")) site.gpx.push_back(located(name));
  for (const std::string& name : texts(table, path, "sources", "dtm")) site.dtm.push_back(located(name));
  for (const std::string& name : texts(table, path, "sources", "drive_logs")) site.drive_logs.push_back(located(name));
  const std::string truth = text(table, path, "truth", "dir", "");
  if (!truth.empty()) site.truth_dir = located(truth);
  site.fetch = read_fetch_tables(table, path);
  site.attribution = merged_attribution(texts(table, path, "attribution", "text"), site.fetch);
  site.model = text(table, path, "segment", "model", site.model);
  site.crf = flag(table, path, "segment", "crf", site.crf);
  site.adapt = flag(table, path, "segment", "adapt", site.adapt);
  const std::string weights = text(table, path, "refine", "weights", "");
  if (!weights.empty()) site.refine_weights = located(weights);
  try {
    site.driving_side = driving_side_of(text(table, path, "refine", "driving_side", "right"));
  } catch (const OptionError& error) {
    throw OptionError(fmt::format("{}: refine: {}", path.string(), error.what()));
  }
  site.dtm_sampling = text(table, path, "elevate", "sampling", site.dtm_sampling);
  if (site.dtm_sampling != "bilinear" && site.dtm_sampling != "cubic")
    throw OptionError(path.string() + ": elevate.sampling must be bilinear or cubic");
  site.crg = texts(table, path, "network", "crg");
  site.opendrive = text(table, path, "network", "opendrive", site.opendrive);
  if (site.opendrive != "1.7" && site.opendrive != "1.8")
    throw OptionError(path.string() + ": network.opendrive must be \"1.7\" or \"1.8\"");
  site.junction_grids = flag(table, path, "network", "junction_grids", site.junction_grids);
  if (site.junction_grids && site.opendrive != "1.8")
    throw OptionError(path.string() + ": network.junction_grids needs network.opendrive = \"1.8\"");
  try {
    site.weather = weather_of(text(table, path, "network", "weather", "dry"));
  } catch (const OptionError& error) {
    throw OptionError(fmt::format("{}: network: {}", path.string(), error.what()));
  }
  site.route = text(table, path, "drive", "route", site.route);
  return site;
}

}  // namespace orthodrive

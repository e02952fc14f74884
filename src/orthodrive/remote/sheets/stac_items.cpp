// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/sheets/stac_items.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"
#include "orthodrive/remote/http/link_address.hpp"
#include "orthodrive/remote/http/xml_text.hpp"
#include "orthodrive/remote/sheets/sheet.hpp"
#include "orthodrive/remote/tiles/capabilities.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
using nlohmann::json;
constexpr std::size_t most_items_of_page = 100000, most_assets = 1000, most_corners_of_item = 10000;

json parsed(std::string_view text, const std::string& name) {
  constexpr int most_depth = 64;
  constexpr std::size_t most_values = 5'000'000;
  const auto no_answer = [&](const std::string& why) {
    return InputError(name, fmt::format("is no answer of a STAC search ({}); check the url", why));
  };
  if (roadquery::trimmed(text).empty()) throw no_answer("it is empty");
  if (looks_like_html(text)) throw no_answer(fmt::format("the server answers a page of HTML: {}", glimpse(text)));
  std::size_t values = 0;
  const auto bounded = [&](int depth, json::parse_event_t, json&) {
    if (depth > most_depth) throw no_answer(fmt::format("more than {} levels of JSON", most_depth));
    if (++values > most_values) throw no_answer(fmt::format("more than {} values", most_values));
    return true;
  };
  try {
    return json::parse(text, bounded);
  } catch (const json::exception&) {
    throw no_answer(fmt::format("no JSON: {}", glimpse(text)));
  }
}

const json* member(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() || found->is_null() ? nullptr : &*found;
}

std::string string_in(const json& object, const char* key) {
  const json* found = member(object, key);
  return found && found->is_string() ? found->get<std::string>() : std::string();
}

void add_json_ring(const json& rings, MultiPolygon& into) {
  if (!rings.is_array() || rings.empty() || !rings[0].is_array() || rings[0].size() > most_corners_of_item) return;
  Polygon polygon;
  for (const json& point : rings[0]) {
    if (!point.is_array() || point.size() < 2 || !point[0].is_number() || !point[1].is_number()) return;
    polygon.outer.push_back({point[0].get<double>(), point[1].get<double>()});
  }
  if (polygon.outer.size() >= 4 && polygon.outer.front() == polygon.outer.back()) polygon.outer.pop_back();
  if (is_on_earth(polygon.outer)) into.push_back(std::move(polygon));
}

/// The geometry, else the bbox of four or six numbers. One across the antimeridian counts as not known.
MultiPolygon footprint_of_item(const json& item) {
  MultiPolygon footprint;
  if (const json* geometry = member(item, "geometry")) {
    const json* coordinates = member(*geometry, "coordinates");
    const std::string type = string_in(*geometry, "type");
    if (coordinates && type == "Polygon") add_json_ring(*coordinates, footprint);
    if (coordinates && type == "MultiPolygon" && coordinates->is_array())
      for (const json& part : *coordinates)
        if (footprint.size() < 100) add_json_ring(part, footprint);
  }
  const json* bbox = member(item, "bbox");
  if (footprint.empty() && bbox && bbox->is_array() && (bbox->size() == 4 || bbox->size() == 6) &&
      std::all_of(bbox->begin(), bbox->end(), [](const json& v) { return v.is_number(); })) {
    const std::size_t half = bbox->size() / 2;
    const Polygon box = lonlat_rectangle((*bbox)[0].get<double>(), (*bbox)[1].get<double>(),
                                         (*bbox)[half].get<double>(), (*bbox)[half + 1].get<double>());
    if (is_on_earth(box.outer)) footprint.push_back(box);
  }
  return footprint;
}

/// Of the properties of an item, or of an asset.
std::string crs_of_item(const json& properties) {
  if (const std::string code = string_in(properties, "proj:code"); !code.empty()) return crs_code_of(code);
  const json* epsg = member(properties, "proj:epsg");
  const bool sound =
      epsg && epsg->is_number_integer() && epsg->get<std::int64_t>() > 0 && epsg->get<std::int64_t>() < 1'000'000;
  return sound ? fmt::format("EPSG:{}", epsg->get<std::int64_t>()) : std::string();
}

StacItem item_of(const json& node) {
  StacItem item{.id = string_in(node, "id"),
                .collection = string_in(node, "collection"),
                .date = {},
                .crs = {},
                .footprint = footprint_of_item(node),
                .assets = {}};
  if (const json* properties = member(node, "properties")) {
    for (const char* key : {"datetime", "end_datetime", "start_datetime"})
      if (item.date.empty()) item.date = string_in(*properties, key);
    item.crs = crs_of_item(*properties);
  }
  const json* assets = member(node, "assets");
  if (!assets || !assets->is_object()) return item;
  for (const auto& [key, asset] : assets->items()) {
    if (item.assets.size() >= most_assets) break;
    StacAsset found{key, string_in(asset, "href"), roadquery::lowered(string_in(asset, "type")), {},
                    0,   crs_of_item(asset)};
    if (const json* roles = member(asset, "roles"); roles && roles->is_array())
      for (const json& role : *roles)
        if (role.is_string() && found.roles.size() < 100) found.roles.push_back(role.get<std::string>());
    if (const json* size = member(asset, "file:size"); size && size->is_number_integer())
      found.bytes = std::clamp<std::int64_t>(size->get<std::int64_t>(), 0, std::int64_t{1} << 50);
    if (!found.href.empty()) item.assets.push_back(std::move(found));
  }
  return item;
}

std::optional<StacNext> next_of(const json& page) {
  const json* links = member(page, "links");
  if (!links || !links->is_array()) return std::nullopt;
  for (const json& link : *links) {
    if (string_in(link, "rel") != "next") continue;
    StacNext next{.href = string_in(link, "href")};
    const json* body = member(link, "body");
    if (roadquery::lowered(string_in(link, "method")) == "post" || body)
      next.body = body && body->is_object() ? body->dump(-1, ' ', false, json::error_handler_t::replace) : "{}";
    const json* merge = member(link, "merge");
    next.merge = merge && merge->is_boolean() && merge->get<bool>();
    if (!next.href.empty()) return next;
  }
  return std::nullopt;
}

bool has_role(const StacAsset& asset, const char* role) {
  return std::find(asset.roles.begin(), asset.roles.end(), role) != asset.roles.end();
}

bool is_raster_asset(const StacAsset& asset) {
  for (const char* other : {"thumbnail", "overview", "metadata", "visual-overview"})
    if (has_role(asset, other)) return false;
  const auto is = [&](const char* part) { return asset.type.find(part) != std::string::npos; };
  if (is("tiff") || is("jp2") || is("jpx") || is("jpeg2000") || asset.type == "application/zip") return true;
  return !is("json") && !is("xml") && !is("text/") && !is("image/png") && !is("image/jpeg") && names_sheet(asset.href);
}
/// Whether the name is as the pattern has it, with any characters for each *.
bool matches(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, resumed = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++, resumed = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1, n = ++resumed;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}
}  // namespace

StacPage parse_stac_page(std::string_view text, const std::string& name) {
  const json page = parsed(text, name);
  const json* features = member(page, "features");
  if (!features || !features->is_array()) {
    std::string said;
    for (const char* key : {"description", "detail", "message", "title"})
      if (said.empty()) said = string_in(page, key);
    throw InputError(name, fmt::format("is no answer of a STAC search ({}); check the url",
                                       said.empty() ? "it has no features" : "the server says: " + glimpse(said)));
  }
  if (features->size() > most_items_of_page)
    throw InputError(name, fmt::format("answers {} items at once, most are {}", features->size(), most_items_of_page));
  StacPage result;
  for (const json& feature : *features)
    if (feature.is_object()) result.items.push_back(item_of(feature));
  result.next = next_of(page);
  return result;
}

const StacAsset* chosen_asset(const StacItem& item, const std::string& layer, const std::string& name) {
  std::vector<const StacAsset*> data, rasters, named;
  for (const StacAsset& asset : item.assets) {
    if (!layer.empty() && asset.key == layer) return &asset;
    if (!layer.empty() && matches(layer, asset.key)) named.push_back(&asset);
    if (!is_raster_asset(asset)) continue;
    rasters.push_back(&asset);
    if (has_role(asset, "data")) data.push_back(&asset);
  }
  const std::vector<const StacAsset*>& candidates = !layer.empty() ? named : data.empty() ? rasters : data;
  if (candidates.empty()) return nullptr;
  if (candidates.size() == 1) return candidates.front();
  std::string keys;
  for (std::size_t i = 0; i < std::min<std::size_t>(candidates.size(), 12); ++i)
    keys += (i ? ", " : "") + printable(candidates[i]->key).substr(0, 40);
  throw InputError(name, fmt::format("item {} has {} pictures ({}); say which with layer",
                                     printable(item.id).substr(0, 80), candidates.size(), keys));
}

std::string merged_json(const std::string& first, const std::string& second) {
  json all = json::parse(first, nullptr, false);
  const json more = json::parse(second, nullptr, false);
  if (!all.is_object()) all = json::object();
  if (more.is_object()) all.update(more);
  return all.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace orthodrive::remote

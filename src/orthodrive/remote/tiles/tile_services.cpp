// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/tile_services.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/crs_facts.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
std::string joined(const std::vector<std::string>& names, std::size_t most = 6) {
  std::string result;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) result += (i ? ", " : "") + names[i];
  return names.size() > most ? result + fmt::format(" and {} more", names.size() - most) : result;
}

/// The one asked for, else the first that compresses photos best.
std::string choose_format(const std::vector<std::string>& offered, const std::string& wanted, const std::string& name) {
  if (!wanted.empty()) {
    if (!offered.empty() && std::find(offered.begin(), offered.end(), wanted) == offered.end())
      throw InputError(name, fmt::format("format '{}' is not offered; there are: {}", wanted, joined(offered)));
    return wanted;
  }
  for (const char* good : {"image/jpeg", "image/jpg", "image/png", "image/png8", "image/webp", "image/vnd.jpeg-png",
                           "image/vnd.jpeg-png8"})
    if (std::find(offered.begin(), offered.end(), good) != offered.end()) return good;
  throw InputError(name, fmt::format("no format that can be read (JPEG, PNG, WebP); there are: {}", joined(offered)));
}

std::string service_name(const FetchSource& source, const Secrets& secrets) { return secrets.hide(source.url); }

/// The keys that the site file has in its address, for addresses of the same host out of the capabilities, which lack
/// them.
std::string with_keys_of(const std::string& url, const std::string& given) {
  const std::size_t mark = given.find('?');
  if (mark == std::string::npos || host_of(url) != host_of(given)) return url;
  static const std::set<std::string> protocol{"service", "request", "version",       "layer",
                                              "layers",  "format",  "acceptversions"};
  std::string result = url;
  std::size_t at = mark + 1;
  while (at < given.size()) {
    const std::size_t end = std::min(given.find('&', at), given.size());
    const std::string part = given.substr(at, end - at);
    const std::string name = roadquery::lowered(part.substr(0, part.find('=')));
    at = end + 1;
    if (part.empty() || protocol.contains(name)) continue;
    const std::string lower = roadquery::lowered(result);
    if (lower.find("?" + name + "=") != std::string::npos || lower.find("&" + name + "=") != std::string::npos)
      continue;
    result += (result.find('?') == std::string::npos            ? "?"
               : result.ends_with('?') || result.ends_with('&') ? ""
                                                                : "&") +
              part;
  }
  return result;
}
}  // namespace

Service template_service(const FetchSource& source, Secrets& secrets) {
  const std::vector<std::string> names = names_in(source.url);
  const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  for (const std::string& name : names)
    if (name != "z" && name != "x" && name != "y" && name != "-y" && name != "s")
      throw OptionError(fmt::format("{}: the url has {{{}}}, expected {{z}} {{x}} {{y}}, {{-y}}, {{s}} or {{env:NAME}}",
                                    source.to_text, name));
  if (!has("z") || !has("x") || has("y") == has("-y"))
    throw OptionError(source.to_text + ": the url needs {z}, {x} and one of {y} and {-y}");
  if (has("s") && source.subdomains.empty())
    throw OptionError(source.to_text + ": the url has {s}, so subdomains = \"abc\" is needed");
  Service service;
  service.set = web_mercator_quad(source.min_zoom, source.max_zoom);
  service.format = source.format;
  const bool from_south = (source.kind == FetchKind::tms) != has("-y");
  service.identity = fmt::format("{} {}", name_of(source.kind), secrets.hide(source.url));
  service.url_of = [pattern = secrets.resolve(source.url), letters = source.subdomains, from_south](const TileMatrix& m,
                                                                                                    TileAddress t) {
    const std::string y = std::to_string(from_south ? m.rows - 1 - t.row : t.row);
    std::map<std::string, std::string> values{
        {"z", m.identifier}, {"x", std::to_string(t.column)}, {"y", y}, {"-y", y}};
    if (!letters.empty()) values["s"] = letters.substr(static_cast<std::size_t>(t.column + t.row) % letters.size(), 1);
    return filled(pattern, values);
  };
  return service;
}

const WmtsLayer& find_layer(const WmtsCapabilities& capabilities, const std::string& wanted, const std::string& name) {
  std::vector<std::string> names;
  for (const WmtsLayer& layer : capabilities.layers) {
    if (layer.identifier == wanted) return layer;
    names.push_back(layer.identifier);
  }
  if (names.empty()) throw InputError(name, "the capabilities list no layer at all; check the url");
  throw InputError(name, fmt::format("no layer '{}'; there are: {}", wanted, joined(by_likeness(names, wanted))));
}

namespace {
/// A matrix set as numbers, and how well it suits: 0 web mercator's quad, 1 UTM of the site, 2 another projection, 3
/// degrees. Nullopt where its CRS is not known here or it has no sound matrix.
struct Candidate {
  int rank = 0;
  TileMatrixSet set;
};
std::optional<Candidate> candidate_of(const WmtsMatrixSet& raw, const SiteFrame& site) {
  const std::string code = crs_code_of(raw.crs);
  if (code.empty() || raw.matrices.empty()) return std::nullopt;
  Candidate candidate{0, {raw.identifier, {code == "OGC:CRS84" ? "EPSG:4326" : code}, {}}};
  io::CrsFacts facts;
  try {
    facts = io::crs_facts(candidate.set.crs);
    (void)CoordinateTransform(site.crs, candidate.set.crs);
  } catch (const Error&) {
    return std::nullopt;
  }
  // A plain "EPSG:4326" is written in the order x, y by the services that write it so; an URN follows the authority.
  const bool urn = raw.crs.find("urn:") == 0 || raw.crs.find("http") == 0;
  const bool swap = facts.north_first && urn && code != "OGC:CRS84";
  for (const WmtsMatrix& m : raw.matrices)
    candidate.set.matrices.push_back({m.identifier, m.scale_denominator * 0.00028 / facts.metres_per_unit,
                                      m.corner[swap ? 1 : 0], m.corner[swap ? 0 : 1], m.tile_width, m.tile_height,
                                      m.columns, m.rows});
  const bool quad = candidate.set.crs.definition == "EPSG:3857" && quad_zoom(candidate.set.matrices.back());
  const bool utm =
      candidate.set.crs == site.crs || proj_string(candidate.set.crs).find("+proj=utm") != std::string::npos;
  candidate.rank = quad ? 0 : facts.geographic ? 3 : utm ? 1 : 2;
  return candidate;
}
}  // namespace

TileMatrixSet choose_matrix_set(const WmtsCapabilities& capabilities, const WmtsLayer& layer, const std::string& wanted,
                                const SiteFrame& site, const std::string& name) {
  std::optional<Candidate> best;
  std::vector<std::string> seen;
  for (const WmtsMatrixSet& raw : capabilities.matrix_sets) {
    if (std::find(layer.matrix_sets.begin(), layer.matrix_sets.end(), raw.identifier) == layer.matrix_sets.end())
      continue;
    seen.push_back(fmt::format("{} ({})", raw.identifier, raw.crs));
    if (!wanted.empty() && raw.identifier != wanted) continue;
    std::optional<Candidate> candidate = candidate_of(raw, site);
    if (candidate && (!best || candidate->rank < best->rank)) best = std::move(candidate);
  }
  if (best) return std::move(best->set);
  if (seen.empty())
    throw InputError(name,
                     fmt::format("layer '{}' has no tile matrix set that the capabilities describe", layer.identifier));
  if (!wanted.empty())
    throw InputError(name, fmt::format("layer '{}' has no usable tile matrix set '{}'; there are: {}", layer.identifier,
                                       wanted, joined(seen)));
  throw InputError(name,
                   fmt::format("layer '{}' has no tile matrix set in a known CRS, like EPSG:3857 or UTM; there are: {}",
                               layer.identifier, joined(seen)));
}

Service wmts_service(const FetchSource& source, const SiteFrame& site, HttpClient& client, Secrets& secrets) {
  const std::string given = secrets.resolve(source.url), name = service_name(source, secrets);
  const bool by_query = given.find('?') != std::string::npos || !given.ends_with(".xml");
  const std::string ask =
      by_query ? with_query(given, {{"SERVICE", "WMTS"}, {"REQUEST", "GetCapabilities"}, {"VERSION", "1.0.0"}}) : given;
  const HttpReply answer = client.get({.url = ask});
  const WmtsCapabilities capabilities = parse_wmts_capabilities(answer.body, name);
  const WmtsLayer& layer = find_layer(capabilities, source.layer, name);
  Service service;
  service.set = choose_matrix_set(capabilities, layer, source.tile_matrix_set, site, name);
  if (const auto limits = layer.limits.find(service.set.identifier); limits != layer.limits.end())
    service.limits = limits->second;
  service.format = choose_format(layer.formats, source.format, name);
  if (!source.style.empty() && std::find(layer.styles.begin(), layer.styles.end(), source.style) == layer.styles.end())
    throw InputError(name, fmt::format("layer '{}' has no style '{}'; there are: {}", layer.identifier, source.style,
                                       joined(layer.styles)));
  const std::string style = !source.style.empty()  ? source.style
                            : layer.styles.empty() ? "default"
                                                   : layer.styles.front();
  std::map<std::string, std::string> fixed = layer.dimensions;
  if (!source.time.empty()) fixed["Time"] = source.time;
  service.identity = fmt::format("wmts {} {} {} {} {} {}", name, layer.identifier, style, service.format,
                                 service.set.identifier, source.time);

  const auto rest = layer.resource_urls.find(service.format);
  if (rest != layer.resource_urls.end() && is_http(rest->second)) {
    std::map<std::string, std::string> values = fixed;
    values["Style"] = style, values["TileMatrixSet"] = service.set.identifier, values["Layer"] = layer.identifier;
    const std::string pattern = with_keys_of(filled(rest->second, values), given);
    service.url_of = [pattern](const TileMatrix& m, TileAddress t) {
      return filled(pattern, {{"TileMatrix", percent_encoded(m.identifier)},
                              {"TileCol", std::to_string(t.column)},
                              {"TileRow", std::to_string(t.row)}});
    };
    return service;
  }
  const std::string base = with_keys_of(is_http(capabilities.kvp_url) ? capabilities.kvp_url : given, given);
  std::vector<std::pair<std::string, std::string>> query{{"SERVICE", "WMTS"},
                                                         {"REQUEST", "GetTile"},
                                                         {"VERSION", "1.0.0"},
                                                         {"LAYER", layer.identifier},
                                                         {"STYLE", style},
                                                         {"FORMAT", service.format},
                                                         {"TILEMATRIXSET", service.set.identifier}};
  for (const auto& [dimension, value] : fixed) query.emplace_back(dimension, value);
  service.url_of = [base, query](const TileMatrix& m, TileAddress t) {
    auto all = query;
    all.insert(
        all.end(),
        {{"TILEMATRIX", m.identifier}, {"TILEROW", std::to_string(t.row)}, {"TILECOL", std::to_string(t.column)}});
    return with_query(base, all);
  };
  return service;
}

namespace {
/// A grid of 512 pixels a tile that begins at whole tiles, so that neighbouring areas have the same tiles.
TileMatrixSet site_grid(const SiteFrame& site, double resolution_m) {
  const double tile_m = 512.0 * resolution_m;
  const double left = -std::floor(2e7 / tile_m) * tile_m, top = -left;
  return {"site",
          site.crs,
          {{fmt::format("{:g}", resolution_m), resolution_m, left, top, 512, 512, std::int64_t{1} << 31,
            std::int64_t{1} << 31}}};
}
}  // namespace

Service wms_service(const FetchSource& source, const SiteFrame& site, double resolution_m, HttpClient& client,
                    Secrets& secrets) {
  const std::string given = secrets.resolve(source.url), name = service_name(source, secrets);
  const HttpReply answer = client.get({.url = with_query(given, {{"SERVICE", "WMS"}, {"REQUEST", "GetCapabilities"}})});
  const WmsCapabilities capabilities = parse_wms_capabilities(answer.body, name);
  std::vector<std::string> names;
  names.reserve(capabilities.layers.size());
  for (const WmsLayer& layer : capabilities.layers) names.push_back(layer.name);
  const auto layer = std::find_if(capabilities.layers.begin(), capabilities.layers.end(),
                                  [&](const WmsLayer& l) { return l.name == source.layer; });
  if (layer == capabilities.layers.end())
    throw InputError(name, names.empty() ? "the capabilities list no layer at all; check the url"
                                         : fmt::format("no layer '{}'; there are: {}", source.layer,
                                                       joined(by_likeness(names, source.layer))));
  std::string asked;  // as the server writes it: old ones know EPSG:900913 only
  const auto knows = [&](const std::string& code) {
    const auto found = std::find_if(layer->crs.begin(), layer->crs.end(),
                                    [&](const std::string& c) { return crs_code_of(c) == code; });
    if (found != layer->crs.end()) asked = *found;
    return found != layer->crs.end();
  };
  Service service;
  const bool tiff = source.to.extension() != ".mbtiles";
  if (!(tiff && knows(site.crs.definition)) && knows("EPSG:3857")) {
    service.set = web_mercator_quad(source.min_zoom, source.max_zoom);
  } else if (knows(site.crs.definition) && !io::crs_facts(site.crs).north_first) {
    service.set = site_grid(site, resolution_m);
  } else {
    throw InputError(name, fmt::format("layer '{}' is offered neither in EPSG:3857 nor in {}; there are: {}",
                                       source.layer, site.crs.definition, joined(layer->crs)));
  }
  service.format = choose_format(capabilities.formats, source.format, name);
  const bool old = capabilities.version.starts_with("1.1") || capabilities.version.starts_with("1.0");
  const std::string base = with_keys_of(is_http(capabilities.map_url) ? capabilities.map_url : given, given);
  std::vector<std::pair<std::string, std::string>> query{
      {"SERVICE", "WMS"},        {"REQUEST", "GetMap"},    {"VERSION", old ? "1.1.1" : "1.3.0"},
      {"LAYERS", source.layer},  {"STYLES", source.style}, {old ? "SRS" : "CRS", asked},
      {"FORMAT", service.format}};
  if (service.format.find("png") != std::string::npos) query.emplace_back("TRANSPARENT", "TRUE");
  if (!source.time.empty()) query.emplace_back("TIME", source.time);
  service.identity = fmt::format("wms {} {} {} {} {}", name, source.layer, source.style, service.format, source.time);
  service.url_of = [base, query](const TileMatrix& m, TileAddress t) {
    const Box2 box = bounds_of_tile(m, t);
    auto all = query;
    all.insert(all.end(),
               {{"WIDTH", std::to_string(m.tile_width)},
                {"HEIGHT", std::to_string(m.tile_height)},
                {"BBOX", fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}", box.min_x, box.min_y, box.max_x, box.max_y)}});
    return with_query(base, all);
  };
  return service;
}

}  // namespace orthodrive::remote

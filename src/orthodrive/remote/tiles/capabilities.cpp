// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/capabilities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <optional>
#include <pugixml.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/http/xml_text.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
constexpr std::size_t most_bytes = std::size_t{64} << 20;
constexpr std::size_t most_layers = 100000;
constexpr int most_levels = 100;

pugi::xml_node load(pugi::xml_document& document, std::string_view xml, const std::string& name,
                    std::initializer_list<std::string_view> roots, const char* service) {
  const auto no_document = [&](const std::string& why) {
    return InputError(name, fmt::format("is no capabilities document of a {} ({}); check the url", service, why));
  };
  if (xml.size() > most_bytes) throw no_document("more than 64 MB");
  if (xml.find_first_not_of(" \t\r\n") == std::string_view::npos) throw no_document("the answer is empty");
  if (looks_like_html(xml)) throw no_document(fmt::format("the server answers a page of HTML: {}", glimpse(xml)));
  const pugi::xml_parse_result result = document.load_buffer(xml.data(), xml.size());
  if (!result) throw no_document(fmt::format("XML: {} at byte {}", result.description(), result.offset));
  const pugi::xml_node root = document.document_element();
  const std::string_view found = local_name(root);
  if (std::find(roots.begin(), roots.end(), found) != roots.end()) return root;
  if (found == "ExceptionReport" || found == "ServiceExceptionReport") {
    std::string said = text_of(child(root, "Exception"), "ExceptionText");
    if (said.empty()) said = text_of(root, "ServiceException");
    throw no_document(fmt::format("the server says: {}", glimpse(said)));
  }
  throw no_document(fmt::format("its root is <{}>", glimpse(found)));
}

WmtsMatrix matrix_of(const pugi::xml_node& node) {
  WmtsMatrix m;
  m.identifier = text_of(node, "Identifier");
  m.scale_denominator = number_of(text_of(node, "ScaleDenominator"));
  const std::string corner = text_of(node, "TopLeftCorner");
  const std::size_t second = corner.find_first_of(" \t\n\r,");
  m.corner[0] = number_of(corner);
  m.corner[1] = second == std::string::npos
                    ? std::nan("")
                    : number_of(std::string(roadquery::trimmed(std::string_view(corner).substr(second + 1))));
  m.tile_width = static_cast<int>(std::min<std::int64_t>(count_of(text_of(node, "TileWidth")), 1 << 20));
  m.tile_height = static_cast<int>(std::min<std::int64_t>(count_of(text_of(node, "TileHeight")), 1 << 20));
  m.columns = count_of(text_of(node, "MatrixWidth"));
  m.rows = count_of(text_of(node, "MatrixHeight"));
  return m;
}

/// Numbers that tiles can be addressed with; 4096 pixels a side is what their decoder takes.
bool is_sound(const WmtsMatrix& m) {
  return std::isfinite(m.scale_denominator) && m.scale_denominator > 1e-6 && m.scale_denominator < 1e12 &&
         std::isfinite(m.corner[0]) && std::isfinite(m.corner[1]) && std::abs(m.corner[0]) < 1e12 &&
         std::abs(m.corner[1]) < 1e12 && m.tile_width > 0 && m.tile_width <= 4096 && m.tile_height > 0 &&
         m.tile_height <= 4096 && m.columns > 0 && m.columns <= (std::int64_t{1} << 40) && m.rows > 0 &&
         m.rows <= (std::int64_t{1} << 40) && !m.identifier.empty();
}

std::map<std::string, TileLimits> limits_of(const pugi::xml_node& link) {
  std::map<std::string, TileLimits> limits;
  for_children(child(link, "TileMatrixSetLimits"), "TileMatrixLimits", [&](const pugi::xml_node& node) {
    const TileLimits l{count_of(text_of(node, "MinTileCol")), count_of(text_of(node, "MaxTileCol")),
                       count_of(text_of(node, "MinTileRow")), count_of(text_of(node, "MaxTileRow"))};
    if (l.min_column >= 0 && l.max_column >= l.min_column && l.min_row >= 0 && l.max_row >= l.min_row)
      limits.emplace(text_of(node, "TileMatrix"), l);
  });
  return limits;
}

WmtsLayer layer_of(const pugi::xml_node& node) {
  WmtsLayer layer{.identifier = text_of(node, "Identifier")};
  for_children(node, "Style", [&](const pugi::xml_node& style) {
    const bool is_default = attribute(style, "isDefault") == "true";
    layer.styles.insert(is_default ? layer.styles.begin() : layer.styles.end(), text_of(style, "Identifier"));
  });
  for_children(node, "Format",
               [&](const pugi::xml_node& f) { layer.formats.emplace_back(roadquery::trimmed(f.child_value())); });
  for_children(node, "TileMatrixSetLink", [&](const pugi::xml_node& link) {
    const std::string set = text_of(link, "TileMatrixSet");
    layer.matrix_sets.push_back(set);
    layer.limits[set] = limits_of(link);
  });
  for_children(node, "Dimension", [&](const pugi::xml_node& dimension) {
    std::string value = text_of(dimension, "Default");
    if (value.empty()) value = text_of(dimension, "Value");
    layer.dimensions.emplace(text_of(dimension, "Identifier"), value);
  });
  for_children(node, "ResourceURL", [&](const pugi::xml_node& url) {
    if (attribute(url, "resourceType") == "tile")
      layer.resource_urls.emplace(attribute(url, "format"), attribute(url, "template"));
  });
  return layer;
}

/// Of the operation GetTile, what takes key-value pairs: a Get without a constraint, or one whose encodings hold KVP.
std::string kvp_url_of(const pugi::xml_node& root) {
  std::string url;
  for_children(child(root, "OperationsMetadata"), "Operation", [&](const pugi::xml_node& operation) {
    if (attribute(operation, "name") != "GetTile") return;
    for_children(child(child(operation, "DCP"), "HTTP"), "Get", [&](const pugi::xml_node& get) {
      bool constrained = false, kvp = false;
      for_children(get, "Constraint", [&](const pugi::xml_node& constraint) {
        for_children(child(constraint, "AllowedValues"), "Value", [&](const pugi::xml_node& value) {
          constrained = true;
          kvp = kvp || std::string_view(value.child_value()) == "KVP";
        });
      });
      if (url.empty() && (!constrained || kvp)) url = attribute(get, "href");
    });
  });
  return url;
}

void add_wms_layers(const pugi::xml_node& node, const WmsLayer& parent, int level, WmsCapabilities& into) {
  if (level > most_levels || into.layers.size() >= most_layers) return;
  WmsLayer layer = parent;
  layer.name = text_of(node, "Name");
  for (const char* tag : {"CRS", "SRS"})
    for_children(node, tag, [&](const pugi::xml_node& crs) {
      const std::string text(roadquery::trimmed(crs.child_value()));  // 1.1.1 may list several in one
      for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find_first_of(" \n\t", at), text.size());
        if (end > at && layer.crs.size() < 10000) layer.crs.push_back(text.substr(at, end - at));
        at = end + 1;
      }
    });
  if (const pugi::xml_node box = child(node, "EX_GeographicBoundingBox")) {
    layer.has_box = true;
    layer.west = number_of(text_of(box, "westBoundLongitude")),
    layer.east = number_of(text_of(box, "eastBoundLongitude"));
    layer.south = number_of(text_of(box, "southBoundLatitude")),
    layer.north = number_of(text_of(box, "northBoundLatitude"));
  } else if (const pugi::xml_node old = child(node, "LatLonBoundingBox")) {
    layer.has_box = true;
    layer.west = number_of(attribute(old, "minx")), layer.east = number_of(attribute(old, "maxx"));
    layer.south = number_of(attribute(old, "miny")), layer.north = number_of(attribute(old, "maxy"));
  }
  if (!layer.name.empty()) into.layers.push_back(layer);
  for_children(node, "Layer", [&](const pugi::xml_node& below) { add_wms_layers(below, layer, level + 1, into); });
}

std::size_t name_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}
}  // namespace

WmtsCapabilities parse_wmts_capabilities(std::string_view xml, const std::string& name) {
  pugi::xml_document document;
  const pugi::xml_node root = load(document, xml, name, {"Capabilities"}, "WMTS");
  WmtsCapabilities result;
  result.kvp_url = kvp_url_of(root);
  result.attribution = text_of(child(root, "ServiceProvider"), "ProviderName");
  const pugi::xml_node contents = child(root, "Contents");
  for_children(contents, "Layer", [&](const pugi::xml_node& node) {
    if (result.layers.size() < most_layers) result.layers.push_back(layer_of(node));
  });
  for_children(contents, "TileMatrixSet", [&](const pugi::xml_node& node) {
    WmtsMatrixSet set{text_of(node, "Identifier"), text_of(node, "SupportedCRS"), {}};
    for_children(node, "TileMatrix", [&](const pugi::xml_node& m) {
      if (WmtsMatrix matrix = matrix_of(m); is_sound(matrix) && set.matrices.size() < 1000)
        set.matrices.push_back(std::move(matrix));
    });
    std::stable_sort(set.matrices.begin(), set.matrices.end(),
                     [](const auto& a, const auto& b) { return a.scale_denominator > b.scale_denominator; });
    result.matrix_sets.push_back(std::move(set));
  });
  return result;
}

WmsCapabilities parse_wms_capabilities(std::string_view xml, const std::string& name) {
  pugi::xml_document document;
  const pugi::xml_node root = load(document, xml, name, {"WMS_Capabilities", "WMT_MS_Capabilities"}, "WMS");
  WmsCapabilities result;
  result.version = attribute(root, "version");
  const pugi::xml_node capability = child(root, "Capability"), service = child(root, "Service");
  const pugi::xml_node get_map = child(child(capability, "Request"), "GetMap");
  for_children(get_map, "Format",
               [&](const pugi::xml_node& f) { result.formats.emplace_back(roadquery::trimmed(f.child_value())); });
  result.map_url = attribute(child(child(child(child(get_map, "DCPType"), "HTTP"), "Get"), "OnlineResource"), "href");
  const auto size_of = [&](const char* tag) {
    return static_cast<int>(std::clamp<std::int64_t>(count_of(text_of(service, tag)), 0, 1 << 20));
  };
  result.max_width = size_of("MaxWidth"), result.max_height = size_of("MaxHeight");
  for_children(capability, "Layer", [&](const pugi::xml_node& layer) { add_wms_layers(layer, {}, 0, result); });
  return result;
}

std::string crs_code_of(const std::string& text) {
  const std::string name = roadquery::lowered(text);
  if (name.find("crs84") != std::string::npos) return "OGC:CRS84";
  if (name.find("epsg") == std::string::npos) return {};
  std::size_t end = name.find_last_of("0123456789");
  if (end == std::string::npos || end + 1 != name.size()) return {};
  std::size_t begin = end;
  while (begin > 0 && std::isdigit(static_cast<unsigned char>(name[begin - 1]))) --begin;
  if (end - begin > 7) return {};
  const std::string code = name.substr(begin);
  if (code == "900913" || code == "102100" || code == "102113" || code == "3785") return "EPSG:3857";
  return "EPSG:" + code;
}

std::vector<std::string> by_likeness(std::vector<std::string> names, const std::string& wanted) {
  const std::string target = roadquery::lowered(wanted).substr(0, 200);
  std::vector<std::pair<std::size_t, std::string>> ranked;
  for (std::string& name : names) {
    const std::string other = roadquery::lowered(name).substr(0, 200);
    const bool part = !target.empty() && !other.empty() &&
                      (other.find(target) != std::string::npos || target.find(other) != std::string::npos);
    ranked.emplace_back(part ? 1 : name_distance(target, other) + 1, std::move(name));
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> result;
  result.reserve(ranked.size());
  for (auto& [likeness, name] : ranked) result.push_back(std::move(name));
  return result;
}

}  // namespace orthodrive::remote

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/sheets/atom_feed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/remote/http/link_address.hpp"
#include "orthodrive/remote/http/xml_text.hpp"
#include "orthodrive/remote/sheets/sheet.hpp"
#include "orthodrive/remote/tiles/capabilities.hpp"
#include "roadquery/text/text.hpp"

namespace orthodrive::remote {
namespace {
constexpr std::size_t most_feed_bytes = std::size_t{64} << 20, most_entries = 200000, most_links = 500000,
                      most_numbers = 20000;

pugi::xml_node feed_of(pugi::xml_document& document, std::string_view xml, const std::string& name) {
  const auto no_feed = [&](const std::string& why) {
    return InputError(name, fmt::format("is no Atom feed ({}); check the url", why));
  };
  if (xml.size() > most_feed_bytes) throw no_feed("more than 64 MB");
  if (roadquery::trimmed(xml).empty()) throw no_feed("the answer is empty");
  if (looks_like_html(xml)) throw no_feed(fmt::format("the server answers a page of HTML: {}", glimpse(xml)));
  const pugi::xml_parse_result result = document.load_buffer(xml.data(), xml.size());
  if (!result) throw no_feed(fmt::format("XML: {} at byte {}", result.description(), result.offset));
  const pugi::xml_node root = document.document_element();
  if (local_name(root) == "feed") return root;
  const std::string said = text_of(child(root, "Exception"), "ExceptionText");
  throw no_feed(said.empty() ? fmt::format("its root is <{}>", glimpse(local_name(root)))
                             : fmt::format("the server says: {}", glimpse(said)));
}

/// Between blanks or commas. Empty when one is no number.
std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  constexpr std::string_view between = " \t\r\n,;";
  for (std::size_t at = text.find_first_not_of(between);
       at != std::string_view::npos && numbers.size() < most_numbers;) {
    const std::size_t end = std::min(text.find_first_of(between, at), text.size());
    numbers.push_back(number_of(std::string(text.substr(at, end - at))));
    if (!std::isfinite(numbers.back())) return {};
    at = text.find_first_not_of(between, end);
  }
  return numbers;
}

/// Of latitude and longitude, as GeoRSS has it; the other order where these are no latitudes.
void add_latlon_ring(const std::vector<double>& numbers, MultiPolygon& into) {
  if (numbers.size() < 6 || numbers.size() % 2 != 0 || into.size() >= 100) return;
  Polygon polygon, swapped;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    polygon.outer.push_back({numbers[i + 1], numbers[i]});
    swapped.outer.push_back({numbers[i], numbers[i + 1]});
  }
  for (Polygon* p : {&polygon, &swapped}) {
    if (p->outer.front() == p->outer.back()) p->outer.pop_back();
    if (!is_on_earth(p->outer)) continue;
    into.push_back(std::move(*p));
    return;
  }
}

void add_latlon_box(const std::vector<double>& n, MultiPolygon& into) {
  if (n.size() != 4) return;
  add_latlon_ring({n[0], n[1], n[0], n[3], n[2], n[3], n[2], n[1]}, into);
}

std::string_view value_of(const pugi::xml_node& node) { return node.child_value(); }

/// georss:polygon, georss:box, and gml:Polygon or gml:Envelope in georss:where.
MultiPolygon footprint_of_node(const pugi::xml_node& node) {
  MultiPolygon footprint;
  for_children(node, "polygon", [&](const pugi::xml_node& p) { add_latlon_ring(numbers_of(value_of(p)), footprint); });
  for_children(node, "box", [&](const pugi::xml_node& b) { add_latlon_box(numbers_of(value_of(b)), footprint); });
  for_children(node, "where", [&](const pugi::xml_node& where) {
    const pugi::xml_node ring = child(child(child(where, "Polygon"), "exterior"), "LinearRing");
    add_latlon_ring(numbers_of(value_of(child(ring, "posList"))), footprint);
    const pugi::xml_node envelope = child(where, "Envelope");
    std::vector<double> corners = numbers_of(value_of(child(envelope, "lowerCorner")));
    const std::vector<double> upper = numbers_of(value_of(child(envelope, "upperCorner")));
    corners.insert(corners.end(), upper.begin(), upper.end());
    add_latlon_box(corners, footprint);
  });
  return footprint;
}

AtomLink link_of(const pugi::xml_node& node) {
  AtomLink link{.href = attribute(node, "href"),
                .rel = roadquery::lowered(attribute(node, "rel")),
                .type = roadquery::lowered(attribute(node, "type")),
                .title = attribute(node, "title"),
                .bbox = {},
                .bytes = std::max<std::int64_t>(0, count_of(attribute(node, "length")))};
  if (link.rel.empty()) link.rel = "alternate";
  const std::vector<double> box = numbers_of(attribute(node, "bbox"));
  if (box.size() == 4) link.bbox = {box[0], box[1], box[2], box[3]};
  return link;
}

void add_links(const pugi::xml_node& node, std::vector<AtomLink>& links, std::size_t& count, const std::string& name) {
  for_children(node, "link", [&](const pugi::xml_node& l) {
    if (++count > most_links)
      throw InputError(name, fmt::format("has more than {} links, which is not read", most_links));
    if (AtomLink link = link_of(l); !link.href.empty()) links.push_back(std::move(link));
  });
}

AtomEntry entry_of(const pugi::xml_node& node, std::size_t& count, const std::string& name) {
  AtomEntry entry{.title = text_of(node, "title"),
                  .id = text_of(node, "id"),
                  .updated = text_of(node, "updated"),
                  .code = text_of(node, "spatial_dataset_identifier_code"),
                  .crs = {},
                  .footprint = footprint_of_node(node),
                  .links = {}};
  for_children(node, "category", [&](const pugi::xml_node& category) {
    for (const char* key : {"term", "label"})
      if (entry.crs.empty()) entry.crs = crs_code_of(attribute(category, key));
  });
  add_links(node, entry.links, count, name);
  return entry;
}

bool holds(std::string_view text, std::initializer_list<const char*> parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const char* part) { return text.find(part) != std::string_view::npos; });
}
}  // namespace

AtomFeed parse_atom_feed(std::string_view xml, const std::string& name) {
  pugi::xml_document document;
  const pugi::xml_node root = feed_of(document, xml, name);
  AtomFeed feed{.title = text_of(root, "title"), .footprint = footprint_of_node(root), .links = {}, .entries = {}};
  std::size_t links = 0;
  add_links(root, feed.links, links, name);
  for_children(root, "entry", [&](const pugi::xml_node& node) {
    if (feed.entries.size() >= most_entries)
      throw InputError(name, fmt::format("has more than {} entries, which is not read", most_entries));
    feed.entries.push_back(entry_of(node, links, name));
  });
  return feed;
}

bool leads_to_sheet(const AtomLink& link) {
  if (!holds(" alternate enclosure section item data ", {(" " + link.rel + " ").c_str()})) return false;
  if (holds(link.type, {"xml", "html", "json", "pdf", "text/", "svg", "gzip", "gml", "shape", "image/png", "image/jpeg",
                        "image/gif"}))
    return false;
  return holds(link.type, {"image/", "tiff", "jp2", "jpeg2000", "zip"}) || names_sheet(link.href);
}

bool leads_to_feed(const AtomLink& link) {
  if (!holds(" alternate enclosure section item subsection ", {(" " + link.rel + " ").c_str()})) return false;
  const std::string path = roadquery::lowered(link.href.substr(0, link.href.find_first_of("?#")));
  return holds(link.type, {"atom+xml"}) ||
         ((link.type.empty() || holds(link.type, {"application/xml", "text/xml"})) && path.ends_with(".atom")) ||
         (link.type.empty() && path.ends_with(".xml"));
}

std::optional<Polygon> box_of_link(const AtomLink& link, const MultiPolygon& around) {
  if (!link.bbox) return std::nullopt;
  const std::array<double, 4>& b = *link.bbox;
  const Polygon of_longitude = lonlat_rectangle(b[0], b[1], b[2], b[3]),
                of_latitude = lonlat_rectangle(b[1], b[0], b[3], b[2]);
  const bool first = is_on_earth(of_longitude.outer), second = is_on_earth(of_latitude.outer);
  if (!first && !second) return std::nullopt;
  if (first && second && !around.empty()) {
    const Box2 place = bounds_of_all(around);
    const bool meets = bounds_of(of_longitude.outer).overlaps(place);
    return meets || !bounds_of(of_latitude.outer).overlaps(place) ? of_longitude : of_latitude;
  }
  return first ? of_longitude : of_latitude;
}

}  // namespace orthodrive::remote

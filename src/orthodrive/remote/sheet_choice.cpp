// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/sheet_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/remote/tile_plan.hpp"

namespace orthodrive::remote {
namespace {
constexpr double cut_margin_m = 100.0, overlay_grid_m = 0.01;

double total_m2(const MultiPolygon& polygons) {
  double total = 0.0;
  for (const Polygon& polygon : polygons) total += area_m2(polygon);
  return total;
}

std::size_t corners_of(const MultiPolygon& polygons) {
  std::size_t count = 0;
  for (const Polygon& polygon : polygons) count += polygon.outer.size();
  return count;
}

SiteFrame boxed(const SiteFrame& site) {
  if (site.area.outer.size() < 3) return site;
  const Box2 b = bounds_of(site.area.outer).grown(cut_margin_m);
  return {site.crs, {{{b.min_x, b.min_y}, {b.max_x, b.min_y}, {b.max_x, b.max_y}, {b.min_x, b.max_y}}, {}}};
}

/// Whether two sheets show the same place: what they have in common is most of both.
bool is_same_place(const MultiPolygon& a, const MultiPolygon& b) {
  constexpr double most = 0.95;
  if (a.empty() || b.empty()) return false;
  const Box2 box_a = bounds_of_all(a), box_b = bounds_of_all(b);
  const double width = std::min(box_a.max_x, box_b.max_x) - std::max(box_a.min_x, box_b.min_x),
               height = std::min(box_a.max_y, box_b.max_y) - std::max(box_a.min_y, box_b.min_y);
  const double larger = std::max(box_a.width() * box_a.height(), box_b.width() * box_b.height());
  if (width <= 0.0 || height <= 0.0 || width * height < most * larger) return false;
  return total_m2(intersection_of(a, b, overlay_grid_m)) > most * std::max(total_m2(a), total_m2(b));
}

using Offer = std::pair<std::string, std::string>;  // CRS and format

/// The offer that covers most of the area. Formats that only a licensed GDAL reads (ECW, MrSID) come last of equals.
Offer best_offer(const std::vector<Sheet>& sheets, const SheetArea& area, const Crs& site_crs) {
  constexpr double equal = 0.995;
  std::vector<Offer> order;
  std::map<Offer, std::vector<Polygon>> parts;
  for (const Sheet& sheet : sheets) {
    const Offer offer{sheet.crs, sheet.type};
    if (!parts.contains(offer)) order.push_back(offer);
    for (Polygon& part : area.part_of(sheet.footprint)) parts[offer].push_back(std::move(part));
    parts[offer];
  }
  const auto rank = [&](const Offer& offer) {
    const bool free = offer.second.find("ecw") == std::string::npos && offer.second.find("sid") == std::string::npos;
    return std::pair(free, offer.first == site_crs.definition);
  };
  std::stable_sort(order.begin(), order.end(), [&](const Offer& a, const Offer& b) { return rank(a) > rank(b); });
  Offer best = order.front();
  double most_m2 = -1.0;
  for (const Offer& offer : order) {
    const double covered_m2 =
        order.size() == 1 || parts[offer].empty() ? 0.0 : total_m2(union_of(parts[offer], overlay_grid_m));
    if (equal * covered_m2 > most_m2) best = offer, most_m2 = covered_m2;
  }
  return best;
}
}  // namespace

SheetArea::SheetArea(const SiteFrame& site, const std::string& name) {
  const Polygon degrees = area_in(boxed(site), Crs{"EPSG:4326"}, 1.0, name);
  (void)lonlat_box(site, 1.0, name);  // says so where it lies across the antimeridian
  box_ = bounds_of(degrees.outer);
  middle_ = {0.5 * (box_.min_x + box_.max_x), 0.5 * (box_.min_y + box_.max_y)};
  metres_per_degree_ = {111320.0 * std::max(0.01, std::cos(middle_.y * std::numbers::pi / 180.0)), 110570.0};
  area_ = in_metres({degrees});
}

MultiPolygon SheetArea::in_metres(const MultiPolygon& degrees) const {
  MultiPolygon metres = degrees;
  for (Polygon& polygon : metres)
    for (Vec2& p : polygon.outer)
      p = {(p.x - middle_.x) * metres_per_degree_.x, (p.y - middle_.y) * metres_per_degree_.y};
  return metres;
}

MultiPolygon SheetArea::part_of(const MultiPolygon& footprint) const {
  constexpr std::size_t most_corners = 10000;
  if (footprint.empty() || !bounds_of_all(footprint).overlaps(box_)) return {};
  MultiPolygon whole = footprint;
  if (corners_of(footprint) > most_corners) {
    const Box2 b = bounds_of_all(footprint);
    whole = {lonlat_rectangle(b.min_x, b.min_y, b.max_x, b.max_y)};
  }
  const MultiPolygon metres = in_metres(whole);
  return intersection_of(union_of(metres, overlay_grid_m), area_, overlay_grid_m);
}

bool SheetArea::touches(const MultiPolygon& footprint) const { return total_m2(part_of(footprint)) > 1.0; }

double SheetArea::area_m2() const { return total_m2(area_); }

SheetChoice choose_sheets(std::vector<Sheet> sheets, const SheetArea& area, const Crs& site_crs,
                          const std::string& name) {
  SheetChoice choice;
  std::set<std::string> addresses;
  std::erase_if(sheets, [&](const Sheet& sheet) { return !addresses.insert(sheet.url).second; });
  if (sheets.empty()) return choice;
  const Offer offer = best_offer(sheets, area, site_crs);
  choice.other_offers = sheets.size();
  std::erase_if(sheets, [&](const Sheet& sheet) { return Offer{sheet.crs, sheet.type} != offer; });
  choice.other_offers -= sheets.size();
  std::stable_sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) { return a.date > b.date; });
  std::vector<MultiPolygon> places;
  for (Sheet& sheet : sheets) {
    MultiPolygon place = area.part_of(sheet.footprint);
    if (std::any_of(places.begin(), places.end(), [&](const auto& other) { return is_same_place(place, other); })) {
      ++choice.same_place;
      continue;
    }
    places.push_back(std::move(place));
    choice.sheets.push_back(std::move(sheet));
    if (choice.sheets.size() > most_sheets)
      throw InputError(name, fmt::format("the area needs more than {} sheets; take a smaller area", most_sheets));
  }
  return choice;
}

}  // namespace orthodrive::remote

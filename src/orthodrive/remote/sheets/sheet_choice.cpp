// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/sheets/sheet_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/remote/tiles/tile_plan.hpp"

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
  return {site.crs, polygon_of(bounds_of(site.area.outer).grown(cut_margin_m))};
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

/// Formats that only a licensed GDAL reads are not.
bool is_free(const Offer& offer) {
  return offer.second.find("ecw") == std::string::npos && offer.second.find("sid") == std::string::npos;
}

/// The offer that covers most of the area. Formats that are not free come last of equals.
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
  const auto rank = [&](const Offer& offer) { return std::pair(is_free(offer), offer.first == site_crs.definition); };
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
/// What the sheets show of the area. In metres.
class ShownPlaces {
 public:
  /// Whether one of them is the same place.
  [[nodiscard]] bool has(const MultiPolygon& place) const {
    return std::any_of(places_.begin(), places_.end(), [&](const auto& other) { return is_same_place(place, other); });
  }
  /// Whether more than a sliver of it is seen in none of them.
  [[nodiscard]] bool lacks(const MultiPolygon& place) const {
    constexpr double sliver = 0.05, least_m2 = 1.0;
    if (place.empty()) return false;
    const Box2 box = bounds_of_all(place);
    std::vector<Polygon> near;
    for (const MultiPolygon& other : places_)
      if (!other.empty() && bounds_of_all(other).overlaps(box)) near.insert(near.end(), other.begin(), other.end());
    const double missing_m2 =
        near.empty() ? total_m2(place) : total_m2(difference_of(place, union_of(near, overlay_grid_m), overlay_grid_m));
    return missing_m2 > std::max(least_m2, sliver * total_m2(place));
  }
  void add(MultiPolygon place) { places_.push_back(std::move(place)); }

 private:
  std::vector<MultiPolygon> places_;
};
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
  const auto rank = [&](const Sheet& sheet) {
    const Offer own{sheet.crs, sheet.type};
    return own == offer ? 0 : is_free(own) || !is_free(offer) ? 1 : 2;
  };
  std::stable_sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) { return a.date > b.date; });
  std::stable_sort(sheets.begin(), sheets.end(), [&](const Sheet& a, const Sheet& b) { return rank(a) < rank(b); });
  ShownPlaces shown;
  for (Sheet& sheet : sheets) {
    MultiPolygon place = area.part_of(sheet.footprint);
    const int of_offer = rank(sheet);
    if (of_offer == 0 && shown.has(place)) {
      ++choice.same_place;
    } else if (of_offer == 2 || (of_offer == 1 && !shown.lacks(place))) {
      ++choice.other_offers;
    } else {
      shown.add(std::move(place));
      choice.sheets.push_back(std::move(sheet));
      if (choice.sheets.size() > most_sheets)
        throw InputError(name, fmt::format("the area needs more than {} sheets; take a smaller area", most_sheets));
    }
  }
  std::stable_sort(choice.sheets.begin(), choice.sheets.end(),
                   [](const Sheet& a, const Sheet& b) { return a.date > b.date; });
  return choice;
}

}  // namespace orthodrive::remote

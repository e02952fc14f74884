// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/site_area.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/ground_scale.hpp"
#include "orthodrive/geo/overlay.hpp"

namespace orthodrive {
namespace {

constexpr double widest_guess_deg = 5.0;  // what people mean by a site is smaller

std::string text_of(const LonLatBox& box) {
  return fmt::format("{:.10g},{:.10g},{:.10g},{:.10g}", box[0], box[1], box[2], box[3]);
}

bool lies_on_earth(const LonLatBox& box) {
  return std::abs(box[0]) <= 180.0 && std::abs(box[2]) <= 180.0 && std::abs(box[1]) <= 90.0 && std::abs(box[3]) <= 90.0;
}

bool is_site_like(const LonLatBox& box) {
  return lies_on_earth(box) && box[0] < box[2] && box[1] < box[3] && box[2] - box[0] < widest_guess_deg &&
         box[3] - box[1] < widest_guess_deg;
}

/// The same four numbers in orders that make a box: corners swapped, latitude first, or pairs of longitudes and
/// latitudes, of which either may come first.
std::vector<LonLatBox> meant_boxes(const LonLatBox& b) {
  const LonLatBox sorted{std::min(b[0], b[2]), std::min(b[1], b[3]), std::max(b[0], b[2]), std::max(b[1], b[3])};
  const LonLatBox latitude_first{sorted[1], sorted[0], sorted[3], sorted[2]};
  const LonLatBox pairs{std::min(b[0], b[1]), std::min(b[2], b[3]), std::max(b[0], b[1]), std::max(b[2], b[3])};
  const LonLatBox latitudes_first{pairs[1], pairs[0], pairs[3], pairs[2]};
  if (is_site_like(sorted)) return {sorted};
  if (is_site_like(latitude_first)) return {latitude_first};
  std::vector<LonLatBox> meant;
  for (const LonLatBox& order : {pairs, latitudes_first})
    if (is_site_like(order)) meant.push_back(order);
  return meant;
}

[[noreturn]] void refuse_box(const LonLatBox& box, const std::string& what) {
  std::string meant;
  for (const LonLatBox& order : meant_boxes(box))
    if (order != box) meant += (meant.empty() ? "" : " or ") + text_of(order);
  throw OptionError(fmt::format("{}: {}, need west,south,east,north in degrees{}", text_of(box), what,
                                meant.empty() ? "" : "; did you mean " + meant + "?"));
}

void check_latitudes(double south, double north) {
  if (south < -highest_latitude_deg || north > highest_latitude_deg)
    throw OptionError(
        fmt::format("reaches latitude {:.10g}, and UTM ends at {:.0f} degrees: give an area nearer to the equator, or "
                    "[area] bounds in metres of a polar CRS with local sources",
                    north > highest_latitude_deg ? north : south, highest_latitude_deg));
}

/// Where two edges that are no neighbours come together.
std::optional<Vec2> find_crossing(const Ring& ring) {
  const auto cross = [](Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; };
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Vec2 p = ring[i], d = ring[i + 1] - p, q = ring[j], e = ring[(j + 1) % n] - q;
      const double along = cross(d, e);
      if (along == 0.0) continue;
      const double s = cross(q - p, e) / along, t = cross(q - p, d) / along;
      if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) return p + d * s;
    }
  return std::nullopt;
}

void check_ring(const Ring& ring, const char* which) {
  if (ring.size() < 3)
    throw OptionError(fmt::format("its {} has {} corners, a polygon needs three", which, ring.size()));
  if (is_simple(ring)) return;
  constexpr std::size_t most_corners = 5000;  // the search is quadratic
  const std::optional<Vec2> place = ring.size() <= most_corners ? find_crossing(ring) : std::nullopt;
  throw OptionError(fmt::format("its {} crosses or touches itself{}; give a ring that does not, for example its hull",
                                which, place ? fmt::format(" near {:.6f}, {:.6f}", place->x, place->y) : ""));
}

Ring placed_ring(const Ring& lonlat, const CoordinateTransform& frame_from_lonlat) {
  constexpr double longest_step_deg = 5.0 / 111.0;
  constexpr int least_steps = 32;  // an edge of a few km bends by millimetres between two points
  const bool many_corners = lonlat.size() > 64;
  Ring ring;
  for (std::size_t i = 0; i < lonlat.size(); ++i) {
    const Vec2 from = lonlat[i], along = lonlat[(i + 1) % lonlat.size()] - from;
    const double longest = std::max(std::abs(along.x), std::abs(along.y));
    const int steps = std::max(many_corners ? 1 : least_steps, static_cast<int>(std::ceil(longest / longest_step_deg)));
    for (int k = 0; k < steps; ++k)
      ring.push_back(frame_from_lonlat.target_from_source(from + along * (k / static_cast<double>(steps))));
  }
  return ring;
}

/// Longitude of the middle of a WGS84 UTM zone ("EPSG:326zz", "EPSG:327zz").
std::optional<double> central_meridian(const Crs& crs) {
  const std::string& code = crs.definition;
  if (code.size() != 10 || !(code.starts_with("EPSG:326") || code.starts_with("EPSG:327"))) return std::nullopt;
  int zone = 0;
  std::from_chars(code.data() + 8, code.data() + code.size(), zone);
  if (zone < 1 || zone > 60) return std::nullopt;
  return -183.0 + 6.0 * zone;
}

}  // namespace

Polygon polygon_of_box(const LonLatBox& box) {
  const auto [west, south, east, north] = box;
  for (const double value : box)
    if (!std::isfinite(value))
      throw OptionError(text_of(box) + ": need four numbers, west,south,east,north in degrees");
  if (!lies_on_earth(box)) refuse_box(box, "no such place on earth");
  if (west > 90.0 && east < -90.0)
    throw OptionError(fmt::format("{}: crosses the antimeridian, and a site cannot; build two: {} and {}", text_of(box),
                                  text_of({west, south, 180.0, north}), text_of({-180.0, south, east, north})));
  if (west == east || south == north) refuse_box(box, "is empty");
  if (west > east || south > north) refuse_box(box, west > east ? "west is east of east" : "south is north of north");
  try {
    check_latitudes(south, north);
  } catch (const OptionError& error) {
    if (!meant_boxes(box).empty() && meant_boxes(box).front() != box) refuse_box(box, error.what());
    throw OptionError(fmt::format("{}: {}", text_of(box), error.what()));
  }
  if (east - west > widest_guess_deg || north - south > widest_guess_deg)
    if (!meant_boxes(box).empty()) refuse_box(box, "is larger than a site can be");
  return {{{west, south}, {east, south}, {east, north}, {west, north}}, {}};
}

void check_lonlat_area(const Polygon& lonlat) {
  for (const Vec2 p : lonlat.outer) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) throw OptionError("has a corner that is no number");
    if (std::abs(p.x) > 180.0 || std::abs(p.y) > 90.0)
      throw OptionError(
          fmt::format("has a corner at {:.10g}, {:.10g}, which are no degrees of longitude and latitude; "
                      "save it in WGS84 (EPSG:4326)",
                      p.x, p.y));
  }
  if (lonlat.outer.empty()) throw OptionError("has no corner");
  const Box2 box = bounds_of(lonlat.outer);
  if (box.width() > 180.0)
    throw OptionError("crosses the antimeridian, and a site cannot; cut it at longitude 180 and build two sites");
  check_latitudes(box.min_y, box.max_y);
  check_ring(lonlat.outer, "outer ring");
  for (const Ring& hole : lonlat.holes) check_ring(hole, "hole");
}

void check_area(const SiteFrame& frame) {
  const Box2 box = bounds_of(frame.area.outer);
  if (std::min(box.width(), box.height()) < narrowest_area_m ||
      area_m2(frame.area) < narrowest_area_m * narrowest_area_m)
    throw OptionError(fmt::format("is {:.0f} x {:.0f} m, a site needs at least {:.0f} m each way; give a larger area",
                                  box.width(), box.height(), narrowest_area_m));
}

void check_crs(const Crs& crs) {
  const std::string text = proj_string(crs);
  if (text.find("+proj=geocent") != std::string::npos)
    throw OptionError(
        fmt::format("CRS '{}' counts from the middle of the earth, and a site needs a map; leave area.crs out for UTM",
                    crs.definition));
  if (text.find("+proj=longlat") != std::string::npos)
    throw OptionError(
        fmt::format("CRS '{}' has degrees, and a site needs metres; leave area.crs out for UTM", crs.definition));
}

void check_scale(const Crs& crs, Vec2 lonlat) {
  const GroundScale scale = ground_scale(crs, lonlat);
  if (scale.error() <= largest_scale_error) return;
  const std::string least = fmt::format("{:.3g}", scale.least_m), most = fmt::format("{:.3g}", scale.most_m);
  throw OptionError(
      fmt::format("CRS '{}' has a unit of {} m on the ground here, and a site needs metres: all of it would have "
                  "another scale; leave area.crs out for UTM",
                  crs.definition, least == most ? least : least + " to " + most));
}

SiteFrame site_frame_of(const Polygon& lonlat, const std::string& crs) {
  check_lonlat_area(lonlat);
  const Box2 box = bounds_of(lonlat.outer);
  SiteFrame frame;
  frame.crs = crs == "auto" ? utm_crs(0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)) : Crs{crs};
  check_crs(frame.crs);
  if (crs != "auto") check_scale(frame.crs, {0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)});
  const CoordinateTransform frame_from_lonlat(Crs{"EPSG:4326"}, frame.crs);
  frame.area.outer = placed_ring(lonlat.outer, frame_from_lonlat);
  for (const Ring& hole : lonlat.holes) frame.area.holes.push_back(placed_ring(hole, frame_from_lonlat));
  check_area(frame);
  return frame;
}

namespace {
Findings findings_of_scale(const Polygon& lonlat, const SiteFrame& frame) {
  constexpr double largest_usual = 0.002;  // of national CRSs and of UTM in its zone
  const Box2 box = bounds_of(lonlat.outer);
  const Vec2 middle{0.5 * (box.min_x + box.max_x), 0.5 * (box.min_y + box.max_y)};
  const double error = ground_scale(frame.crs, middle).error();
  if (error <= largest_usual) return {};
  const Vec2 place = CoordinateTransform(Crs{"EPSG:4326"}, frame.crs).target_from_source(middle);
  return {{Severity::warning, "area.scale",
           fmt::format("lengths in {} are off by {:.1f} per mille here: its scale is not that of the ground; leave "
                       "area.crs out for UTM",
                       frame.crs.definition, 1000.0 * error),
           place.x, place.y}};
}
}  // namespace

Findings findings_of_area(const Polygon& lonlat, const SiteFrame& frame) {
  const std::optional<double> meridian = central_meridian(frame.crs);
  if (!meridian) return findings_of_scale(lonlat, frame);
  const auto farther = [&](Vec2 a, Vec2 b) { return std::abs(a.x - *meridian) < std::abs(b.x - *meridian); };
  const Vec2 farthest = *std::max_element(lonlat.outer.begin(), lonlat.outer.end(), farther);
  const double off_deg = std::abs(farthest.x - *meridian);
  if (off_deg <= farthest_from_meridian_deg) return {};
  const Vec2 place = CoordinateTransform(Crs{"EPSG:4326"}, frame.crs).target_from_source(farthest);
  const double off_rad = off_deg * std::numbers::pi / 180.0;
  const double east = off_rad * std::cos(farthest.y * std::numbers::pi / 180.0);
  const double scale = 0.9996 * (1.0 + 0.5 * east * east);  // of transverse Mercator on a sphere, to 1e-5 here
  return {{Severity::info, "area.off_meridian",
           fmt::format("the area reaches {:.1f} degrees from the middle of its UTM zone ({}), where lengths are off by "
                       "{:.1f} per mille; choose another area.crs or smaller sites",
                       off_deg, frame.crs.definition, 1000.0 * std::abs(scale - 1.0)),
           place.x, place.y}};
}

}  // namespace orthodrive

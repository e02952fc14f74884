// SPDX-License-Identifier: Apache-2.0
#include "roadquery/surface/road_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "roadquery/surface/cross_section.hpp"
#include "roadquery/surface/poly_curve.hpp"

namespace roadquery {
namespace {

// Gauss-Legendre quadrature with 8 points on [-1, 1]: nodes and weights of the positive half (Abramowitz and Stegun,
// table 25.4).
constexpr std::array<double, 4> gauss_nodes = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                               0.9602898564975363};
constexpr std::array<double, 4> gauss_weights = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                 0.1012285362903763};
// Over a panel in which the heading turns by up to this the rule above is exact to rounding: its error for cos(w x) is
// below (w/2)^16 * 2e-13 of the panel's length.
constexpr double max_turn_in_panel_rad = 1.5;

PlanPoint evaluate_line(const PlanElement& e, double ds) {
  return {e.x + ds * std::cos(e.hdg), e.y + ds * std::sin(e.hdg), e.hdg, 0.0};
}

PlanPoint evaluate_arc(const PlanElement& e, const Arc& arc, double ds) {
  // Chord of length ds * sinc(turn / 2) in the mean direction: no division by the curvature, so flat arcs stay exact.
  const double half_turn = 0.5 * arc.curvature * ds;
  const double sinc = std::abs(half_turn) < 1e-4 ? 1.0 - half_turn * half_turn / 6.0 : std::sin(half_turn) / half_turn;
  return {e.x + ds * sinc * std::cos(e.hdg + half_turn), e.y + ds * sinc * std::sin(e.hdg + half_turn),
          e.hdg + 2.0 * half_turn, arc.curvature};
}

/// Euler spiral: integral of (cos, sin) of the heading, which is quadratic in s.
PlanPoint evaluate_spiral(const PlanElement& e, const Spiral& spiral, double ds) {
  const double k0 = spiral.curvature_start;
  const double slope = e.length > 0.0 ? (spiral.curvature_end - k0) / e.length : 0.0;
  const double k1 = k0 + slope * ds;
  const double turn = std::max(std::abs(k0), std::abs(k1)) * std::abs(ds);
  constexpr double most_panels = 1000.0;  // no tables are made of a line that turns so often, nor of a NaN
  const double wished = turn / max_turn_in_panel_rad;
  const int panels = 1 + static_cast<int>(wished < most_panels ? wished : most_panels);
  const double half = 0.5 * ds / panels;
  double dx = 0.0, dy = 0.0;
  for (int panel = 0; panel < panels; ++panel) {
    const double mid = (2 * panel + 1) * half;
    for (std::size_t i = 0; i < gauss_nodes.size(); ++i) {
      for (const double u : {mid - half * gauss_nodes[i], mid + half * gauss_nodes[i]}) {
        const double hdg = e.hdg + u * (k0 + 0.5 * slope * u);
        dx += gauss_weights[i] * std::cos(hdg);
        dy += gauss_weights[i] * std::sin(hdg);
      }
    }
  }
  return {e.x + half * dx, e.y + half * dy, e.hdg + ds * (k0 + 0.5 * slope * ds), k1};
}

PlanPoint evaluate_poly(const PlanElement& e, const ParamPoly3& q, double ds) {
  const PolyPlace place = place_along(e, q, ds);
  const double p = place.p;
  const double u = q.a_u + p * (q.b_u + p * (q.c_u + p * q.d_u));
  const double v = q.a_v + p * (q.b_v + p * (q.c_v + p * q.d_v));
  const double du = q.b_u + p * (2.0 * q.c_u + p * 3.0 * q.d_u);
  const double dv = q.b_v + p * (2.0 * q.c_v + p * 3.0 * q.d_v);
  const double ddu = 2.0 * q.c_u + 6.0 * p * q.d_u, ddv = 2.0 * q.c_v + 6.0 * p * q.d_v;
  const double speed = std::hypot(du, dv);
  const double c = std::cos(e.hdg), s = std::sin(e.hdg);
  PlanPoint point{e.x + c * u - s * v, e.y + s * u + c * v, e.hdg, 0.0, place.stretch};
  if (speed > 0.0) {
    point.hdg += std::atan2(dv, du);
    point.curvature = (du * ddv - dv * ddu) / (speed * speed * speed);
  }
  return point;
}

/// The last item with item.s <= s, or nullptr when s lies before the first.
template <typename Items>
const typename Items::value_type* item_at(const Items& items, double s) {
  const auto next =
      std::upper_bound(items.begin(), items.end(), s, [](double v, const auto& item) { return v < item.s; });
  return next == items.begin() ? nullptr : &*(next - 1);
}

}  // namespace

PlanPoint evaluate(const PlanElement& element, double ds) {
  struct Visitor {
    const PlanElement& e;
    double ds;
    PlanPoint operator()(const Line&) const { return evaluate_line(e, ds); }
    PlanPoint operator()(const Arc& arc) const { return evaluate_arc(e, arc, ds); }
    PlanPoint operator()(const Spiral& spiral) const { return evaluate_spiral(e, spiral, ds); }
    PlanPoint operator()(const ParamPoly3& poly) const { return evaluate_poly(e, poly, ds); }
  };
  return std::visit(Visitor{element, ds}, element.shape);
}

PlanPoint reference_point(const Road& road, double s) {
  if (road.plan.empty()) return {};
  s = std::clamp(s, 0.0, road.length);
  const PlanElement* found = item_at(road.plan, s);
  const PlanElement& element = found != nullptr ? *found : road.plan.front();
  return evaluate(element, s - element.s);
}

double evaluate(std::span<const Cubic> cubics, double s) {
  const Cubic* c = item_at(cubics, s);
  if (c == nullptr) return 0.0;
  const double ds = s - c->s;
  return c->a + ds * (c->b + ds * (c->c + ds * c->d));
}

double derivative(std::span<const Cubic> cubics, double s) {
  const Cubic* c = item_at(cubics, s);
  if (c == nullptr) return 0.0;
  const double ds = s - c->s;
  return c->b + ds * (2.0 * c->c + ds * 3.0 * c->d);
}

double second_derivative(std::span<const Cubic> cubics, double s) {
  const Cubic* c = item_at(cubics, s);
  return c == nullptr ? 0.0 : 2.0 * c->c + (s - c->s) * 6.0 * c->d;
}

double elevation(const Road& road, double s) { return evaluate(road.elevation, s); }
double gradient(const Road& road, double s) { return derivative(road.elevation, s); }
double superelevation(const Road& road, double s) { return evaluate(road.superelevation, s); }

double lane_width(const Lane& lane, double s_in_section) { return evaluate(lane.width, s_in_section); }

const LaneSection& section_at(const Road& road, double s) {
  const LaneSection* found = item_at(road.sections, s);
  return found != nullptr ? *found : road.sections.front();
}

Edges road_edges(const Road& road, double s) {
  s = std::clamp(s, 0.0, road.length);
  const double offset = evaluate(road.lane_offset, s);
  const LaneSection& section = section_at(road, s);
  const double s_in_section = s - section.s;
  Edges edges{offset, offset};
  for (const Lane& lane : section.left) edges.left_t += lane_width(lane, s_in_section);
  for (const Lane& lane : section.right) edges.right_t -= lane_width(lane, s_in_section);
  return edges;
}

int lane_id_at(const Road& road, double s, double t) {
  constexpr double edge_rounding_m = 1e-6;
  const LaneSection& section = section_at(road, s);
  const double from_middle = t - evaluate(road.lane_offset, s);
  const std::vector<Lane>& lanes = from_middle > 0.0 || section.right.empty() ? section.left : section.right;
  double rest = std::abs(from_middle);
  for (const Lane& lane : lanes) {
    rest -= lane_width(lane, s - section.s);
    if (rest <= edge_rounding_m) return lane.id;
  }
  return 0;
}

ShapePoint shape(const Road& road, double s, double t) {
  const std::vector<ShapeCubic>& all = road.shape;
  if (all.empty()) return {};
  const auto after =
      std::upper_bound(all.begin(), all.end(), s, [](double v, const ShapeCubic& cubic) { return v < cubic.s; });
  if (after == all.begin()) return {};
  // The cubics of the s that *last is one of: [first, end).
  const auto at_t = [t](auto first, auto end) {
    const auto next = std::upper_bound(first, end, t, [](double v, const ShapeCubic& cubic) { return v < cubic.t; });
    const ShapeCubic& q = *(next == first ? first : next - 1);
    const double dt = t - q.t;
    return ShapePoint{q.a + dt * (q.b + dt * (q.c + dt * q.d)), 0.0, q.b + dt * (2.0 * q.c + dt * 3.0 * q.d)};
  };
  auto first = after - 1;
  while (first != all.begin() && (first - 1)->s == first->s) --first;
  ShapePoint point = at_t(first, after);
  if (after == all.end()) return point;
  auto end = after;
  while (end != all.end() && end->s == after->s) ++end;
  const ShapePoint next = at_t(after, end);
  const double length = after->s - first->s, u = (s - first->s) / length;
  point.dh_ds = (next.h - point.h) / length;
  point.h += u * (next.h - point.h);
  point.dh_dt += u * (next.dh_dt - point.dh_dt);
  return point;
}

double t_at(const Road& road, double s, double left_m) {
  const double bank = superelevation(road, s), cos_bank = std::cos(bank), sin_bank = std::sin(bank);
  double t = left_m / cos_bank;
  if (road.shape.empty() || bank == 0.0) return t;
  // Newton. The shape moves points sideways by h sin(bank), a thousandth of t: three steps are below rounding.
  for (int i = 0; i < 3; ++i) {
    const ShapePoint q = shape(road, s, t);
    t += (left_m - (t * cos_bank - q.h * sin_bank)) / (cos_bank - q.dh_dt * sin_bank);
  }
  return t;
}

LaneHeightAt lane_height_at(std::span<const LaneHeight> heights, double s_in_section) {
  if (heights.empty()) return {};
  const auto next = std::upper_bound(heights.begin(), heights.end(), s_in_section,
                                     [](double v, const LaneHeight& h) { return v < h.s_offset; });
  const LaneHeight& a = next == heights.begin() ? *next : *(next - 1);
  LaneHeightAt at{{a.inner, a.outer}, {0.0, 0.0}};
  if (next == heights.begin() || next == heights.end()) return at;
  const double length = next->s_offset - a.s_offset, ds = s_in_section - a.s_offset;
  at.rise[0] = (next->inner - a.inner) / length, at.rise[1] = (next->outer - a.outer) / length;
  for (std::size_t i = 0; i < 2; ++i) at.value[i] += ds * at.rise[i];
  return at;
}

ShapePoint lane_height(const Road& road, double s, double t) {
  if (road.sections.empty()) return {};
  const LaneSection& section = section_at(road, s);
  const auto has_height = [](const Lane& lane) { return !lane.heights.empty(); };
  if (std::none_of(section.left.begin(), section.left.end(), has_height) &&
      std::none_of(section.right.begin(), section.right.end(), has_height))
    return {};
  const int id = lane_id_at(road, s, t);
  if (id == 0) return {};
  const bool left = id > 0;
  double inner = evaluate(road.lane_offset, s), inner_slope = derivative(road.lane_offset, s);
  for (const Lane& lane : left ? section.left : section.right) {
    const double sign = left ? 1.0 : -1.0, s_in_section = s - section.s;
    const double width = sign * lane_width(lane, s_in_section),
                 width_slope = sign * derivative(lane.width, s_in_section);
    if (lane.id != id) {
      inner += width, inner_slope += width_slope;
      continue;
    }
    const LaneHeightAt at = lane_height_at(lane.heights, s_in_section);
    const double across = at.value[1] - at.value[0];
    if (lane.heights.empty() || width == 0.0) return {at.value[0], at.rise[0], 0.0};
    const double share = (t - inner) / width, share_slope = -(inner_slope + share * width_slope) / width;
    return {at.value[0] + share * across, at.rise[0] + share * (at.rise[1] - at.rise[0]) + share_slope * across,
            across / width};
  }
  return {};
}

namespace {

SectionPoint section_point(const Road& road, double s, double t, double h) {
  const double bank = superelevation(road, s), slope = gradient(road, s),
               cos_pitch = 1.0 / std::sqrt(1.0 + slope * slope);
  return {t, h, std::sin(bank), std::cos(bank), slope * cos_pitch, cos_pitch};
}

SectionSlopes slopes_at(const Road& road, double s, const PlanPoint& line, const ShapePoint& q) {
  return {line.speed,
          line.curvature,
          gradient(road, s),
          second_derivative(road.elevation, s),
          derivative(road.superelevation, s),
          q.dh_ds,
          q.dh_dt};
}

}  // namespace

double surface_height(const Road& road, double s, double t) {
  return elevation(road, s) + section_point(road, s, t, shape(road, s, t).h).rise() + lane_height(road, s, t).h;
}

RoadPosition position_over(const Road& road, double x, double y, double s_near) {
  constexpr int most_steps = 32;
  constexpr double small_m = 1e-6, least_share = 0.05;  // Newton's next step would be below 1e-11 m
  RoadPosition at{std::clamp(s_near, 0.0, road.length)};
  for (int i = 0; i < most_steps; ++i) {
    const PlanPoint line = reference_point(road, at.s);
    const double c = std::cos(line.hdg), n = std::sin(line.hdg), dx = x - line.x, dy = y - line.y;
    at.t = t_at(road, at.s, dy * c - dx * n);
    const ShapePoint q = shape(road, at.s, at.t);
    const SectionPoint section = section_point(road, at.s, at.t, q.h);
    at.beyond_m = dx * c + dy * n - section.ahead();
    const SectionTangents tangents = tangents_at(section, slopes_at(road, at.s, line, q), true);
    const double step = at.beyond_m * tangents.t_left / std::max(tangents.area(), least_share * line.speed);
    const double next = std::clamp(at.s + step, 0.0, road.length);
    if (std::abs(step) < small_m) {
      at = {next, at.t - step * tangents.s_left / tangents.t_left, 0.0};
      break;
    }
    if (next == at.s) break;  // at the road's end
    at.s = next;
  }
  return at;
}

SurfacePoint surface_point(const Road& road, double s, double t) {
  s = std::clamp(s, 0.0, road.length);
  return surface_point(road, s, t, reference_point(road, s));
}

SurfacePoint surface_point(const Road& road, double s, double t, const PlanPoint& reference) {
  const double cos_hdg = std::cos(reference.hdg), sin_hdg = std::sin(reference.hdg);
  const ShapePoint q = shape(road, s, t);
  const ShapePoint lane = lane_height(road, s, t);
  const SectionPoint section = section_point(road, s, t, q.h);
  const double left = section.left(), ahead = section.ahead();
  SurfacePoint point;
  point.x = reference.x + cos_hdg * ahead - sin_hdg * left;
  point.y = reference.y + sin_hdg * ahead + cos_hdg * left;
  point.z = elevation(road, s) + section.rise() + lane.h;
  SectionTangents tangents = tangents_at(section, slopes_at(road, s, reference, q), true);
  tangents.s_up += lane.dh_ds, tangents.t_up += lane.dh_dt;
  const double n_forward = tangents.normal_forward(), n_left = tangents.normal_left(), n_up = tangents.area();
  const double norm = std::sqrt(n_forward * n_forward + n_left * n_left + n_up * n_up);
  // Beyond the centre of curvature the surface is folded over (n_up < 0): no surface to speak of, keep "up".
  if (norm > 0.0 && n_up > 0.0) {
    point.normal[0] = (cos_hdg * n_forward - sin_hdg * n_left) / norm;
    point.normal[1] = (sin_hdg * n_forward + cos_hdg * n_left) / norm;
    point.normal[2] = n_up / norm;
  }
  return point;
}

void remove_lane_heights(RoadMap& map) {
  for (Road& road : map.roads)
    for (LaneSection& section : road.sections)
      for (auto* side : {&section.left, &section.right})
        for (Lane& lane : *side) lane.heights.clear();
}

}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_paint.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

using roadquery::Road;
using roadquery::RoadObject;

constexpr double largest_m = 100.0;
constexpr double bar_m = 0.5, bar_gap_m = 0.5;                             // of a zebra
constexpr double line_m = 0.12, line_stroke_m = 0.5, line_gap_m = 0.2;     // at traffic lights
constexpr double block_m = 0.5, block_gap_m = 0.25;                        // of a give-way line
constexpr double longest_bar_m = 2.0;                                      // in one piece: roads bend
constexpr double hatch_m = 0.5, hatch_gap_m = 1.0, hatch_border_m = 0.15;  // at right angles to the strokes

/// A rectangle in s and t.
struct Extent {
  double s0 = 0.0, s1 = 0.0, t0 = 0.0, t1 = 0.0;
};

Extent extent_of(const RoadObject& object) {
  if (object.outline.empty()) {
    // The box turned by hdg; of what lies along or across the road.
    const double c = std::abs(std::cos(object.hdg)), d = std::abs(std::sin(object.hdg));
    const double half_s = 0.5 * (c * object.length + d * object.width);
    const double half_t = 0.5 * (d * object.length + c * object.width);
    return {object.s - half_s, object.s + half_s, object.t - half_t, object.t + half_t};
  }
  Extent e{object.outline[0][0], object.outline[0][0], object.outline[0][1], object.outline[0][1]};
  for (const auto& [s, t] : object.outline)
    e = {std::min(e.s0, s), std::max(e.s1, s), std::min(e.t0, t), std::max(e.t1, t)};
  return e;
}

Vec2 place(const Road& road, double s, double t) {
  const auto p = roadquery::surface_point(road, std::clamp(s, 0.0, road.length), t);
  return {p.x, p.y};
}

/// Corners in s and t, counter-clockwise.
void add_piece(const Road& road, const std::array<std::array<double, 2>, 4>& corners, std::vector<MarkingPiece>& to) {
  MarkingPiece piece;
  for (std::size_t i = 0; i < 4; ++i) piece.corners[i] = place(road, corners[i][0], corners[i][1]);
  to.push_back(piece);
}

void add_rectangle(const Road& road, const Extent& e, std::vector<MarkingPiece>& to) {
  const int parts = std::max(1, static_cast<int>(std::ceil((e.s1 - e.s0) / longest_bar_m)));
  for (int i = 0; i < parts; ++i) {
    const double s0 = e.s0 + (e.s1 - e.s0) * i / parts, s1 = e.s0 + (e.s1 - e.s0) * (i + 1) / parts;
    add_piece(road, {{{s0, e.t0}, {s1, e.t0}, {s1, e.t1}, {s0, e.t1}}}, to);
  }
}

/// Strokes across the road as many as fit, in its middle.
void add_strokes(const Road& road, const Extent& e, double stroke_m, double gap_m, std::vector<MarkingPiece>& to) {
  const int count = static_cast<int>(std::floor((e.t1 - e.t0 + gap_m) / (stroke_m + gap_m) + 1e-9));
  const double first = 0.5 * (e.t0 + e.t1 - (count * (stroke_m + gap_m) - gap_m));
  for (int i = 0; i < count; ++i) {
    const double t = first + i * (stroke_m + gap_m);
    add_rectangle(road, {e.s0, e.s1, t, t + stroke_m}, to);
  }
}

/// Adds pieces of an arrow given by u along it (0 at its foot, 1 at its tip) and v to its left, both as shares of the
/// box's length and half its width.
class Arrow {
 public:
  Arrow(const Road& road, const RoadObject& box, std::vector<MarkingPiece>& to) : road_(road), box_(box), to_(to) {}

  void add(const std::array<std::array<double, 2>, 4>& corners) {
    std::array<std::array<double, 2>, 4> st;
    const double c = std::cos(box_.hdg), d = std::sin(box_.hdg);
    for (std::size_t i = 0; i < 4; ++i) {
      const double u = (corners[i][0] - 0.5) * box_.length, v = corners[i][1] * 0.5 * box_.width;
      st[i] = {box_.s + c * u - d * v, box_.t + d * u + c * v};
    }
    add_piece(road_, st, to_);
  }
  void shaft(double to_u) { add({{{0.0, -shaft_v}, {to_u, -shaft_v}, {to_u, shaft_v}, {0.0, shaft_v}}}); }
  void straight() { add({{{head_u, -0.45}, {1.0, 0.0}, {1.0, 0.0}, {head_u, 0.45}}}); }
  /// `side`: 1 left, -1 right. An arm that leaves the shaft at `u` and a head that points sideways.
  void turn(double u, double side) {
    const auto mirrored = [&](std::array<std::array<double, 2>, 4> corners) {
      if (side < 0.0) {
        for (auto& corner : corners) corner[1] = -corner[1];
        std::ranges::reverse(corners);
      }
      add(corners);
    };
    mirrored({{{u - 0.12, 0.0}, {u, 0.0}, {u + 0.10, 0.5}, {u + 0.02, 0.5}}});
    mirrored({{{u - 0.04, 0.5}, {u + 0.16, 0.5}, {u + 0.06, 1.0}, {u + 0.06, 1.0}}});
  }

 private:
  static constexpr double shaft_v = 0.125, head_u = 0.6;
  const Road& road_;
  const RoadObject& box_;
  std::vector<MarkingPiece>& to_;
};

void add_arrow(const Road& road, const RoadObject& box, std::vector<MarkingPiece>& to) {
  const std::string& kind = box.subtype;
  const auto shows = [&](const char* word) { return kind.find(word) != std::string::npos; };
  const bool straight = shows("Straight"), left = shows("Left"), right = shows("Right");
  Arrow arrow(road, box, to);
  const double branch = straight ? 0.4 : 0.82;
  arrow.shaft(straight ? 0.6 : branch);
  if (straight) arrow.straight();
  if (left) arrow.turn(branch, 1.0);
  if (right) arrow.turn(branch, -1.0);
}

using RoadPlace = std::array<double, 2>;  ///< s and t

RoadPlace between(const RoadPlace& a, const RoadPlace& b, double share) {
  return {a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share};
}

/// The part of a convex polygon where f is not negative; f is linear.
template <typename F>
std::vector<RoadPlace> part_where(const std::vector<RoadPlace>& polygon, const F& f) {
  std::vector<RoadPlace> part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const RoadPlace &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double fa = f(a), fb = f(b);
    if (fa >= 0.0) part.push_back(a);
    if ((fa > 0.0 && fb < 0.0) || (fa < 0.0 && fb > 0.0)) part.push_back(between(a, b, fa / (fa - fb)));
  }
  return part;
}

/// Two lines along the road and strokes of 45 degrees between them.
class Hatching {
 public:
  Hatching(const Road& road, std::vector<MarkingPiece>& to) : road_(road), to_(to) {}

  /// The outline's corners go along one side and back along the other.
  void add(const std::vector<RoadPlace>& outline) {
    const std::size_t count = outline.size();
    for (std::size_t i = 0; i + 1 < count / 2; ++i) {
      const RoadPlace &a = outline[i], &b = outline[i + 1], &c = outline[count - 2 - i], &d = outline[count - 1 - i];
      add_strokes({a, b, c, d});
      // The lines become narrower only where both would meet.
      const double first_m = width_m(a, d) - 2.0 * hatch_border_m, last_m = width_m(b, c) - 2.0 * hatch_border_m;
      if (first_m * last_m >= 0.0) {
        add_lines(a, b, c, d);
        continue;
      }
      const double share = first_m / (first_m - last_m);
      const RoadPlace ab = between(a, b, share), dc = between(d, c, share);
      add_lines(a, ab, dc, d);
      add_lines(ab, b, c, dc);
    }
  }

 private:
  using Quad = std::array<RoadPlace, 4>;

  static double width_m(const RoadPlace& from, const RoadPlace& to) { return std::abs(to[1] - from[1]); }
  void add_lines(const RoadPlace& a, const RoadPlace& b, const RoadPlace& c, const RoadPlace& d) {
    add_line(a, b, c, d);
    add_line(c, d, a, b);
  }

  void add_quad(Quad quad) {
    double twice_m2 = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      twice_m2 += quad[i][0] * quad[(i + 1) % 4][1] - quad[(i + 1) % 4][0] * quad[i][1];
    constexpr double least_m2 = 1e-4;
    if (std::abs(twice_m2) < 2.0 * least_m2) return;
    if (twice_m2 < 0.0) std::ranges::reverse(quad);
    add_piece(road_, quad, to_);
  }
  /// Beside a - b, inside a quadrangle a, b, c, d.
  void add_line(const RoadPlace& a, const RoadPlace& b, const RoadPlace& c, const RoadPlace& d) {
    const auto inwards = [](const RoadPlace& from, const RoadPlace& to) {
      const double width = width_m(from, to);
      return between(from, to, width > 0.0 ? std::min(0.5, hatch_border_m / width) : 0.0);
    };
    add_quad({a, b, inwards(b, c), inwards(a, d)});
  }
  void add_strokes(const Quad& quad) {
    const auto across = [](const RoadPlace& p) { return (p[0] + p[1]) / std::sqrt(2.0); };
    const std::vector<RoadPlace> whole(quad.begin(), quad.end());
    double low = across(quad[0]), high = low;
    for (const RoadPlace& p : quad) low = std::min(low, across(p)), high = std::max(high, across(p));
    constexpr double period_m = hatch_m + hatch_gap_m;
    for (double from = std::floor(low / period_m) * period_m; from < high; from += period_m) {
      std::vector<RoadPlace> part = part_where(whole, [&](const RoadPlace& p) { return across(p) - from; });
      part = part_where(part, [&](const RoadPlace& p) { return from + hatch_m - across(p); });
      for (std::size_t i = 1; i + 1 < part.size(); i += 2)
        add_quad({part[0], part[i], part[i + 1], part[std::min(i + 2, part.size() - 1)]});
    }
  }

  const Road& road_;
  std::vector<MarkingPiece>& to_;
};

void add_crosswalk(const Road& road, const RoadObject& object, std::vector<MarkingPiece>& to) {
  const Extent e = extent_of(object);
  // Before 1.7 crosswalks had no subtypes.
  if (object.subtype == "zebra" || object.subtype.empty()) add_strokes(road, e, bar_m, bar_gap_m, to);
  if (object.subtype != "pedestrian") return;
  for (const double s : {e.s0, e.s1 - line_m})
    add_strokes(road, {s, s + line_m, e.t0, e.t1}, line_stroke_m, line_gap_m, to);
}

/// A disc about the box's middle.
void add_disc(const Road& road, const RoadObject& object, std::vector<MarkingPiece>& to) {
  constexpr int pieces = 12;
  const Vec2 middle = place(road, object.s, object.t);
  const auto on_edge = [&](int half_steps) {
    const double angle = half_steps * M_PI / pieces;
    return middle + Vec2{std::cos(angle), std::sin(angle)} * (0.5 * object.length);
  };
  for (int i = 0; i < pieces; ++i) to.push_back({{middle, on_edge(2 * i), on_edge(2 * i + 1), on_edge(2 * i + 2)}});
}

}  // namespace

std::vector<MarkingPiece> road_paint(const Road& road) {
  std::vector<MarkingPiece> pieces;
  for (const RoadObject& object : road.objects) {
    const Extent e = extent_of(object);
    if (!(e.s1 - e.s0 < largest_m && e.t1 - e.t0 < largest_m && e.s1 > e.s0 && e.t1 > e.t0)) continue;
    if (object.type == "crosswalk") add_crosswalk(road, object, pieces);
    if (object.type != "roadMark") continue;
    if (object.subtype == "signalLines" && object.name == "give way line")
      add_strokes(road, e, block_m, block_gap_m, pieces);
    else if (object.subtype == "signalLines")
      add_rectangle(road, e, pieces);
    else if (object.subtype == "hatchedArea" && object.outline.size() >= 4 && object.outline.size() % 2 == 0)
      Hatching(road, pieces).add(object.outline);
    else if (object.subtype.starts_with("arrow") && !object.subtype.starts_with("arrowMerge"))
      add_arrow(road, object, pieces);
    else if (object.subtype == "paint" && object.name == "mini-roundabout")
      add_disc(road, object, pieces);
  }
  return pieces;
}

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#include "roadquery/opendrive/cross_section_surface.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <string>
#include <utility>

#include "roadquery/surface/road_surface.hpp"
#include "roadquery/surface/shift_cubic.hpp"

namespace roadquery {
namespace {

constexpr double tolerance_m = 1e-4, jump_m = 0.01;
constexpr double shortest_piece_m = 0.05, least_share = 1e-3;  // of the road: no more rows, whatever a file says

/// The strips by their places; null: the road has none there.
struct Strips {
  const std::vector<Cubic>& t_offset;
  const SurfaceStrip *inner[2] = {}, *outer[2] = {};  ///< right, left

  explicit Strips(const CrossSectionSurface& surface) : t_offset(surface.t_offset) {
    for (const SurfaceStrip& strip : surface.strips)
      (std::abs(strip.id) == 1 ? inner : outer)[strip.id > 0 ? 1 : 0] = &strip;
  }

  /// Powers of dt.
  static void powers(const SurfaceStrip& strip, double s, double (&p)[4]) {
    p[0] = evaluate(strip.constant, s), p[1] = evaluate(strip.linear, s);
    p[2] = evaluate(strip.quadratic, s), p[3] = evaluate(strip.cubic, s);
  }
  [[nodiscard]] double width(int side, double s) const {
    return inner[side] != nullptr ? std::max(evaluate(inner[side]->width, s), 0.0) : 0.0;
  }

  /// The cubics at s, from right to left. The first one holds to its right, too.
  [[nodiscard]] std::vector<ShapeCubic> row(double s) const {
    std::vector<ShapeCubic> row;
    const double middle = evaluate(t_offset, s);
    const auto add = [&](const double(&p)[4], double edge, double from_t) {
      double q[4];
      shift_cubic(p, from_t - edge, q);
      if (!row.empty() && from_t - row.back().t < least_strip_m) row.pop_back();
      row.push_back({s, from_t, q[0], q[1], q[2], q[3]});
    };
    const auto add_outer = [&](int side, double edge, double from_t) {
      if (outer[side] == nullptr) return;
      double p[4];
      powers(*outer[side], s, p);
      if (outer[side]->relative) {
        double at_edge[4], of_inner[4] = {};
        if (inner[side] != nullptr) powers(*inner[side], s, of_inner);
        shift_cubic(of_inner, edge - middle, at_edge);
        p[0] += at_edge[0];
      }
      add(p, edge, from_t);
    };
    const auto add_inner = [&](int side, double from_t) {
      double p[4] = {};
      if (inner[side] != nullptr) powers(*inner[side], s, p);
      add(p, middle, from_t);
    };
    const double right_edge = middle - width(0, s), left_edge = middle + width(1, s);
    constexpr double beside_m = 1.0;  // where the outermost cubic on the right begins, which holds to its right
    add_outer(0, right_edge, right_edge - beside_m);
    add_inner(0, outer[0] != nullptr ? right_edge : middle - beside_m);
    add_inner(1, middle);
    add_outer(1, left_edge, left_edge);
    return row;
  }

  static constexpr double least_strip_m = 1e-6;
};

double height(const std::vector<ShapeCubic>& row, double t) {
  const auto next = std::upper_bound(row.begin(), row.end(), t, [](double v, const ShapeCubic& q) { return v < q.t; });
  const ShapeCubic& q = next == row.begin() ? *next : *(next - 1);
  const double dt = t - q.t;
  return q.a + dt * (q.b + dt * (q.c + dt * q.d));
}

/// Rows between which the surface is as good as linear in s.
class RowPlaces {
 public:
  RowPlaces(const Strips& strips, double length) : strips_(strips), length_(length) {}

  [[nodiscard]] std::vector<double> places(const CrossSectionSurface& surface) {
    std::set<double> fixed = {0.0, length_};
    const auto add = [&](const std::vector<Cubic>& list) {
      for (const Cubic& c : list)
        if (c.s > 0.0 && c.s < length_) fixed.insert(c.s), fixed.insert(std::max(0.0, c.s - jump_m));
    };
    add(surface.t_offset);
    for (const SurfaceStrip& strip : surface.strips)
      for (const auto* list : {&strip.width, &strip.constant, &strip.linear, &strip.quadratic, &strip.cubic})
        add(*list);
    std::vector<double> result;
    for (auto at = fixed.begin(); at != fixed.end(); ++at) {
      result.push_back(*at);
      if (std::next(at) != fixed.end() && *std::next(at) - *at > 1.5 * jump_m) split(*at, *std::next(at), result);
    }
    return result;
  }

 private:
  void split(double from, double to, std::vector<double>& result) const {
    if (to - from < 2.0 * std::max(shortest_piece_m, least_share * length_) || is_linear(from, to)) return;
    const double middle = 0.5 * (from + to);
    split(from, middle, result);
    result.push_back(middle);
    split(middle, to, result);
  }
  /// At the strips' edges and beyond them, as far as lanes reach.
  [[nodiscard]] bool is_linear(double from, double to) const {
    constexpr double reach_m = 10.0;
    const std::vector<ShapeCubic> a = strips_.row(from), b = strips_.row(to);
    for (const double share : {0.25, 0.5, 0.75}) {
      const std::vector<ShapeCubic> exact = strips_.row(from + share * (to - from));
      for (const ShapeCubic& q : exact)
        for (const double beside :
             {-reach_m, -0.3 * reach_m, -0.05 * reach_m, 0.0, 0.05 * reach_m, 0.3 * reach_m, reach_m}) {
          const double t = q.t + beside;
          const double between = (1.0 - share) * height(a, t) + share * height(b, t);
          if (!(std::abs(between - height(exact, t)) < tolerance_m)) return false;
        }
    }
    return true;
  }

  const Strips& strips_;
  double length_;
};

void keep_known_strips(const Road& road, CrossSectionSurface& surface, NoteList& notes) {
  const auto note = [&](const std::string& what) {
    notes.add("opendrive.cross_section_surface", what, true, {road.id, 0.0});
  };
  const auto has_width = [&](int id) {
    return std::any_of(surface.strips.begin(), surface.strips.end(),
                       [&](const SurfaceStrip& strip) { return strip.id == id && !strip.width.empty(); });
  };
  std::vector<SurfaceStrip> kept;
  for (const SurfaceStrip& strip : surface.strips) {
    if (strip.id == 0 || std::abs(strip.id) > 2) {
      note("a <strip> has the id " + std::to_string(strip.id) + ", need 1, 2, -1 or -2: it is passed over");
    } else if (std::abs(strip.id) == 2 && !has_width(strip.id / 2)) {
      note("an outer <strip> is passed over, as the inner one has no <width>");
    } else {
      kept.push_back(strip);
    }
  }
  surface.strips = std::move(kept);
}

}  // namespace

void shapes_from_strips(Road& road, CrossSectionSurface surface, NoteList& notes) {
  keep_known_strips(road, surface, notes);
  if (surface.strips.empty()) return;
  if (!road.superelevation.empty())
    notes.add("opendrive.cross_section_surface", "<crossSectionSurface> stands beside <superelevation>, both count",
              true, {road.id, 0.0});
  if (!road.shape.empty()) {
    notes.add("opendrive.cross_section_surface", "<crossSectionSurface> is passed over where a road has <shape>, too",
              true, {road.id, 0.0});
    return;
  }
  const Strips strips(surface);
  for (const double s : RowPlaces(strips, road.length).places(surface)) {
    const std::vector<ShapeCubic> row = strips.row(s);
    road.shape.insert(road.shape.end(), row.begin(), row.end());
  }
}

}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
// Chains of clothoids from exact truth: what can be taken out is, and what the limits hold stays.

#include "orthodrive/network/curves/clothoid_chain.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "orthodrive/core/random.hpp"

namespace orthodrive::network {
namespace {

using Element = ClothoidChain::Element;

Vec2 unit(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

struct Part {
  double length_m, curvature0, curvature1;
};
/// Points and headings every `step_m` on a road of such parts from the origin; its length is a multiple of the step.
struct ChainRoad {
  std::vector<Vec2> points;
  std::vector<double> headings;

  ChainRoad(const std::vector<Part>& parts, double step_m) {
    Vec2 start;
    double heading = 0.3, part_s = 0.0, s = 0.0;
    for (const Part& part : parts) {
      const double rate = (part.curvature1 - part.curvature0) / part.length_m;
      for (; s <= part_s + part.length_m + 1e-9; s += step_m) {
        const double u = s - part_s;
        points.push_back(start + tangent_moments(heading, part.curvature0, rate, u).m0);
        headings.push_back(heading + u * (part.curvature0 + 0.5 * rate * u));
      }
      start = start + tangent_moments(heading, part.curvature0, rate, part.length_m).m0;
      heading += 0.5 * (part.curvature0 + part.curvature1) * part.length_m;
      part_s += part.length_m;
    }
  }
};

/// 60 m straight, into a curve of 50 m radius over 40 m, 60 m of it, out again over 40 m, 60 m straight.
const std::vector<Part> one_bend{{60, 0, 0}, {40, 0, 0.02}, {60, 0.02, 0.02}, {40, 0.02, 0}, {60, 0, 0}};

/// A chain with a knot at every node. The nodes must live as long as it does.
ClothoidChain chain_through(const std::vector<Vec2>& nodes, const std::vector<double>& headings, bool closed,
                            const ChainLimits& limits) {
  const ClothoidSpline spline = clothoid_spline(nodes, headings, closed);
  EXPECT_TRUE(spline.found);
  std::vector<std::size_t> at(nodes.size());
  std::iota(at.begin(), at.end(), 0u);
  return {nodes, closed, spline, at, limits};
}

/// The end of an element, by quadrature.
Knot end_of(const Element& e) {
  const double rate = (e.end_curvature - e.start.curvature) / e.length_m;
  return {e.start.p + tangent_moments(e.start.heading_rad, e.start.curvature, rate, e.length_m).m0,
          e.start.heading_rad + 0.5 * (e.start.curvature + e.end_curvature) * e.length_m, e.end_curvature};
}

/// Place, heading and curvature go on from element to element.
void expect_g2(const std::vector<Element>& elements, bool closed) {
  ASSERT_FALSE(elements.empty());
  for (std::size_t i = 0; i + (closed ? 0 : 1) < elements.size(); ++i) {
    const Knot end = end_of(elements[i]), next = elements[(i + 1) % elements.size()].start;
    EXPECT_LT(distance(end.p, next.p), 1e-8) << i;
    EXPECT_LT(std::abs(std::remainder(end.heading_rad - next.heading_rad, 2.0 * std::numbers::pi)), 1e-9) << i;
    EXPECT_NEAR(end.curvature, next.curvature, 1e-9) << i;
  }
}

/// Distances to the line as a dense walk along it finds them, for every node.
double farthest_m(const std::vector<Element>& elements, const std::vector<Vec2>& nodes) {
  std::vector<Vec2> line;
  for (const Element& e : elements) {
    const double rate = (e.end_curvature - e.start.curvature) / e.length_m;
    for (double u = 0.0; u < e.length_m; u += 0.02)
      line.push_back(e.start.p + tangent_moments(e.start.heading_rad, e.start.curvature, rate, u).m0);
    line.push_back(end_of(e).p);
  }
  double farthest = 0.0;
  for (const Vec2 p : nodes) {
    double nearest = INFINITY;
    for (const Vec2 q : line) nearest = std::min(nearest, distance(p, q));
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

/// What feet() says is true: the node lies so far across the tangent of its foot.
void expect_feet(const ClothoidChain& chain, const std::vector<Vec2>& nodes) {
  const std::vector<Element> elements = chain.elements();
  const std::vector<ClothoidChain::Foot> feet = chain.feet();
  ASSERT_EQ(feet.size(), nodes.size());
  for (std::size_t i = 0; i < feet.size(); ++i) {
    const Element& e = elements[feet[i].element];
    const double rate = (e.end_curvature - e.start.curvature) / e.length_m, u = feet[i].ds_m;
    EXPECT_GE(u, 0.0);
    EXPECT_LE(u, e.length_m);
    const Vec2 foot = e.start.p + tangent_moments(e.start.heading_rad, e.start.curvature, rate, u).m0;
    const Vec2 t = unit(e.start.heading_rad + u * (e.start.curvature + 0.5 * rate * u)), off = nodes[i] - foot;
    EXPECT_NEAR(std::abs(cross(t, off)), feet[i].distance_m, 2e-3) << i;
    EXPECT_LT(std::abs(dot(t, off)), 0.02) << i;
  }
}

TEST(ClothoidChain, starts_as_the_spline_it_is_given) {
  const ChainRoad road(one_bend, 4.0);
  const ClothoidChain chain = chain_through(road.points, road.headings, false, {.max_curvature_rate = 0.25});
  EXPECT_EQ(chain.elements().size(), road.points.size() - 1);
  expect_g2(chain.elements(), false);
  for (const ClothoidChain::Foot& foot : chain.feet()) EXPECT_LT(foot.distance_m, 1e-9);
}

TEST(ClothoidChain, takes_out_the_knots_that_an_exact_road_does_not_need) {
  const ChainRoad road(one_bend, 4.0);
  ClothoidChain chain =
      chain_through(road.points, road.headings, false, {.tolerance_m = 0.02, .max_curvature_rate = 0.25});
  chain.remove_knots(1);
  chain.snap_kinds();
  chain.remove_knots(1);
  chain.polish();
  const std::vector<Element> elements = chain.elements();
  EXPECT_LE(elements.size(), 7u) << "five would do";
  expect_g2(elements, false);
  EXPECT_LE(farthest_m(elements, road.points), 0.022);
  expect_feet(chain, road.points);
  double length_m = 0.0;
  for (const Element& e : elements) length_m += e.length_m;
  EXPECT_NEAR(length_m, 260.0, 0.05);
  // The straights are lines and the bend is an arc of its radius.
  EXPECT_EQ(elements.front().kind, ElementKind::line);
  EXPECT_EQ(elements.back().kind, ElementKind::line);
  const auto arc =
      std::find_if(elements.begin(), elements.end(), [](const Element& e) { return e.kind == ElementKind::arc; });
  ASSERT_NE(arc, elements.end());
  EXPECT_NEAR(arc->start.curvature, 0.02, 3e-4);
  EXPECT_EQ(arc->start.curvature, arc->end_curvature);
}

TEST(ClothoidChain, lines_have_no_curvature_and_arcs_a_constant_one) {
  const ChainRoad road(one_bend, 4.0);
  ClothoidChain chain = chain_through(road.points, road.headings, false, {.max_curvature_rate = 0.25});
  chain.snap_kinds();
  int lines = 0, arcs = 0;
  for (const Element& e : chain.elements()) {
    if (e.kind == ElementKind::line) {
      ++lines;
      EXPECT_EQ(e.start.curvature, 0.0);
      EXPECT_EQ(e.end_curvature, 0.0);
    } else if (e.kind == ElementKind::arc) {
      ++arcs;
      EXPECT_EQ(e.start.curvature, e.end_curvature);
    }
  }
  EXPECT_GT(lines, 0);
  EXPECT_GT(arcs, 0);
  expect_g2(chain.elements(), false);
}

TEST(ClothoidChain, keeps_every_knot_where_the_tolerance_leaves_no_room) {
  const ChainRoad road(one_bend, 4.0);
  std::vector<Vec2> noisy = road.points;
  Random random(5);
  for (std::size_t i = 0; i < noisy.size(); ++i)
    noisy[i] = noisy[i] + left_normal(unit(road.headings[i])) * random.uniform(-0.05, 0.05);
  ClothoidChain strict = chain_through(noisy, road.headings, false, {.tolerance_m = 1e-5, .max_curvature_rate = 0.25});
  strict.remove_knots(1);
  EXPECT_EQ(strict.elements().size(), noisy.size() - 1);
  ClothoidChain loose = chain_through(noisy, road.headings, false, {.tolerance_m = 0.1, .max_curvature_rate = 0.25});
  loose.remove_knots(1);
  EXPECT_LT(loose.elements().size(), 10u);
  EXPECT_LE(farthest_m(loose.elements(), noisy), 0.105);
}

TEST(ClothoidChain, accepts_no_window_with_elements_below_the_least_length) {
  const ChainRoad road(one_bend, 4.0);
  ClothoidChain chain = chain_through(road.points, road.headings, false,
                                      {.tolerance_m = 0.02, .min_element_m = 4.5, .max_curvature_rate = 0.25});
  chain.remove_knots(1);  // every window has neighbours of 4 m
  EXPECT_EQ(chain.elements().size(), road.points.size() - 1);
}

TEST(ClothoidChain, curvature_and_its_change_stay_below_their_bounds) {
  // 90 degrees between straights, nodes at a radius of 10 m: the change of curvature is bounded to 0.02 / m^2, and no
  // removal may make the line sharper than 1 / 9 m.
  const ChainRoad road({{40, 0, 0}, {8, 0, 0.1}, {8, 0.1, 0.1}, {8, 0.1, 0}, {40, 0, 0}}, 2.0);
  const std::vector<double> bound(road.points.size(), 1.0 / 9.0);
  const ChainLimits limits{.tolerance_m = 0.2, .max_curvature_rate = 0.02, .max_curvature = bound};
  ClothoidChain chain = chain_through(road.points, road.headings, false, limits);
  double sharpest = 0.0, fastest = 0.0;  // of the start, which is not made worse
  const auto measure = [&] {
    sharpest = fastest = 0.0;
    for (const Element& e : chain.elements()) {
      sharpest = std::max({sharpest, std::abs(e.start.curvature), std::abs(e.end_curvature)});
      fastest = std::max(fastest, std::abs(e.end_curvature - e.start.curvature) / e.length_m);
    }
  };
  measure();
  const double sharpest_before = sharpest, fastest_before = fastest;
  chain.remove_knots(1);
  chain.snap_kinds();
  chain.polish();
  measure();
  EXPECT_LE(sharpest, std::max(1.0 / 9.0, sharpest_before) + 1e-8);
  EXPECT_LE(fastest, std::max(0.02, fastest_before) + 1e-8);
  EXPECT_LT(chain.elements().size(), 12u);
  for (const Element& e : chain.elements()) EXPECT_GE(e.length_m, limits.min_element_m);
}

TEST(ClothoidChain, a_closed_line_goes_on_over_its_seam) {
  // An ellipse of 60 m by 40 m: no circle, curvature changes everywhere.
  std::vector<Vec2> nodes;
  std::vector<double> headings;
  constexpr int count = 80;
  for (int i = 0; i < count; ++i) {
    const double a = 2.0 * std::numbers::pi * i / count;
    nodes.push_back({60.0 * std::cos(a), 40.0 * std::sin(a)});
    headings.push_back(std::atan2(40.0 * std::cos(a), -60.0 * std::sin(a)));
  }
  ClothoidChain chain = chain_through(nodes, headings, true, {.tolerance_m = 0.05, .max_curvature_rate = 0.25});
  EXPECT_EQ(chain.elements().size(), static_cast<std::size_t>(count));
  chain.remove_knots(1);
  chain.snap_kinds();
  chain.polish();
  const std::vector<Element> elements = chain.elements();
  expect_g2(elements, true);
  EXPECT_LT(elements.size(), 20u);
  EXPECT_GE(elements.size(), 4u);
  EXPECT_LE(farthest_m(elements, nodes), 0.055);
  expect_feet(chain, nodes);
  double turn = 0.0;
  for (const Element& e : elements) turn += 0.5 * (e.start.curvature + e.end_curvature) * e.length_m;
  EXPECT_NEAR(turn, 2.0 * std::numbers::pi, 1e-8);
}

TEST(ClothoidChain, one_element_stays_one) {
  const std::vector<Vec2> nodes{{0, 0}, {10, 0}};
  const std::vector<double> headings{0.0, 0.0};
  ClothoidChain chain = chain_through(nodes, headings, false, {.max_curvature_rate = 0.25});
  chain.remove_knots(1);
  chain.snap_kinds();
  chain.polish();
  ASSERT_EQ(chain.elements().size(), 1u);
  EXPECT_NEAR(chain.elements()[0].length_m, 10.0, 1e-6);
  EXPECT_EQ(chain.elements()[0].kind, ElementKind::line);
}

}  // namespace
}  // namespace orthodrive::network

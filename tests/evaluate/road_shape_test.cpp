// SPDX-License-Identifier: Apache-2.0
// Measures of refined roads that go beyond area and offset: smoothness, moves away from the truth, polygons.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "evaluate/road_lines.hpp"
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"

namespace orthodrive {
namespace {

RoadNetwork shape_network(std::vector<RoadPath> paths) { return {utm33, std::move(paths)}; }
Polygon box(double x0, double y0, double x1, double y1) {
  return {{origin + Vec2{x0, y0}, origin + Vec2{x1, y0}, origin + Vec2{x1, y1}, origin + Vec2{x0, y1}}, {}};
}
RoadScores score_shape(const RoadNetwork& roads, const RoadNetwork& truth, const EvaluateRoadsOptions& options = {}) {
  return evaluate_roads(roads, road_truth(truth, utm33), options);
}

TEST(RoadShape, width_variance_is_the_mean_over_paths_and_not_over_nodes) {
  RoadPath waves = path_along(straight(0, 0, 100, 0, 99), 6.0), even = path_along(straight(0, 50, 100, 50, 3), 4.0, 2);
  for (std::size_t i = 0; i < waves.nodes.size(); ++i) waves.nodes[i].width_m += i % 2 ? 0.5 : -0.5;  // sigma^2 = 0.25
  const RoadNetwork roads = shape_network({waves, even});
  EXPECT_NEAR(evaluate_roads(roads, {}).width_variance_m2, 0.125, 1e-12);
  EXPECT_NEAR(evaluate_roads(roads, {}, {.region = {.area = MultiPolygon{box(-10, -10, 110, 10)}}}).width_variance_m2,
              0.25, 1e-12);
  EXPECT_TRUE(std::isnan(evaluate_roads(shape_network({}), {}).width_variance_m2));
}

/// 60 m straight on, then an arc to the left of that radius, points every 5 cm.
Polyline straight_then_arc(double radius_m) {
  Polyline line = straight(-60, 0, 0, 0, 120);
  for (double s = 0.05; s <= 0.5 * std::numbers::pi * radius_m; s += 0.05)
    line.push_back({radius_m * std::sin(s / radius_m), radius_m * (1.0 - std::cos(s / radius_m))});
  return line;
}

TEST(RoadShape, curvature_jump_from_a_straight_to_an_arc) {
  const RoadNetwork roads =
      shape_network({path_along(straight(0, 100, 100, 140), 6.0, 5), path_along(straight_then_arc(25.0), 6.0, 6)});
  const CurvatureJump jump = evaluate_roads(roads, {}).curvature_jump;
  EXPECT_GT(jump.per_m, 7.0 / 8.0 / 25.0 - 1e-4);
  EXPECT_LT(jump.per_m, 1.0 / 25.0 + 1e-4);
  EXPECT_EQ(jump.osm_id, 6);
  EXPECT_LT(distance(jump.where, origin), 3.0) << "where the arc begins";
  EXPECT_NEAR(jump.mean_per_m, 0.5 * jump.per_m, 1e-6) << "the straight road has none";
}

TEST(RoadShape, curvature_jump_of_a_corner_does_not_depend_on_its_nodes) {
  const double angle = 0.2;
  const auto corner = [&](int pieces) {
    Polyline line = straight(-40, 0, 0, 0, pieces);
    for (int i = 1; i <= pieces; ++i)
      line.push_back(Vec2{40.0 * std::cos(angle), 40.0 * std::sin(angle)} * (1.0 * i / pieces));
    return line;
  };
  const double few = evaluate_roads(shape_network({path_along(corner(1), 6.0)}), {}).curvature_jump.per_m;
  EXPECT_NEAR(few, angle / 2.0, 1e-3) << "the turn over a step of 2 m";
  EXPECT_NEAR(few, evaluate_roads(shape_network({path_along(corner(80), 6.0)}), {}).curvature_jump.per_m, 1e-3);
}

TEST(RoadShape, curvature_jump_of_round_and_of_odd_lines) {
  Polyline circle;
  for (int i = 0; i < 360; ++i)
    circle.push_back({20.0 * std::cos(i * std::numbers::pi / 180), 20.0 * std::sin(i * std::numbers::pi / 180)});
  circle.push_back(circle.front());
  EXPECT_NEAR(evaluate_roads(shape_network({path_along(circle, 6.0)}), {}).curvature_jump.per_m, 0.0, 2e-3)
      << "also across its joint";
  Polyline repeated = straight(0, 0, 40, 0);
  repeated.insert(repeated.begin() + 5, 3, repeated[5]);
  EXPECT_NEAR(evaluate_roads(shape_network({path_along(repeated, 6.0)}), {}).curvature_jump.per_m, 0.0, 1e-9);
  const RoadNetwork tiny = shape_network({path_along({{0, 0}, {0, 0}}, 6.0), path_along({{0, 0}, {3, 0}}, 6.0, 2)});
  EXPECT_TRUE(std::isnan(evaluate_roads(tiny, {}).curvature_jump.per_m));
}

TEST(RoadShape, share_of_places_that_moved_away_from_the_truth) {
  const RoadNetwork truth = shape_network({path_along(straight(0, 0, 100, 0), 6.0)});
  const RoadNetwork before = shape_network({path_along(straight(0, 1, 100, 1), 6.0)});
  // The first 40 m came nearer, 20 m went 0.2 m away, 30 m went 1 m away on the other side, 10 m were lost.
  const RoadNetwork after =
      shape_network({path_along(straight(0, 0.5, 40, 0.5), 6.0), path_along(straight(40, 1.2, 60, 1.2), 6.0, 2),
                     path_along(straight(60, -2, 90, -2), 6.0, 3)});
  const RoadScores scores = score_shape(after, truth, {.before = &before});
  ASSERT_TRUE(scores.moved_away);
  EXPECT_EQ(scores.moved_away->n, 50u);
  EXPECT_NEAR(scores.moved_away->share, 0.6, 1e-9);
  EXPECT_NEAR(scores.moved_away->share_by_more_than_0_3_m, 0.4, 1e-9);
  EXPECT_NEAR(scores.places[0].offset_before_m, 1.0, 1e-9);
  EXPECT_FALSE(score_shape(after, truth).moved_away);
  EXPECT_EQ(score_shape(before, truth, {.before = &before}).moved_away->share, 0.0) << "nothing moved";
  const RoadNetwork elsewhere = shape_network({path_along(straight(0, 500, 100, 500), 6.0)});
  EXPECT_EQ(score_shape(after, truth, {.before = &elsewhere}).moved_away->n, 0u);
}

TEST(RoadShape, places_carry_the_errors_of_the_summary) {
  const RoadNetwork truth =
      shape_network({path_along(straight(0, 0, 100, 0), 6.0), path_along(straight(0, 40, 20, 40), 6.0, 2)});
  const RoadScores scores = score_shape(shape_network({path_along(straight(0, 1, 100, 1), 7.0)}), truth);
  ASSERT_EQ(scores.places.size(), scores.samples);
  EXPECT_EQ(scores.places.size(), 60u);
  EXPECT_NEAR(scores.places[10].offset_m, 1.0, 1e-9);
  EXPECT_NEAR(scores.places[10].width_error_m, 1.0, 1e-9);
  EXPECT_EQ(scores.places[55].line, 1u);
  EXPECT_TRUE(std::isnan(scores.places[55].offset_m)) << "no road there";
}

TEST(RoadShape, surface_errors_are_the_polygons_of_one_side) {
  // Ours y -2..4, truth -3..3 over 100 m; a crossing road of the truth that we lack.
  const RoadNetwork truth =
      shape_network({path_along(straight(0, 0, 100, 0), 6.0), path_along(straight(50, -30, 50, 30), 4.0, 2)});
  const RoadNetwork roads = shape_network({path_along(straight(0, 1, 100, 1), 6.0)});
  const auto total = [](const MultiPolygon& polygons) {
    double sum = 0.0;
    for (const Polygon& polygon : polygons) sum += area_m2(polygon);
    return sum;
  };
  const SurfaceErrors errors = surface_errors(roads, road_truth(truth, utm33));
  EXPECT_NEAR(total(errors.false_positive), 100.0 - 4.0, 0.05);
  EXPECT_NEAR(total(errors.false_negative), 100.0 + 4.0 * (60.0 - 7.0), 0.05);
  EXPECT_TRUE(contains(errors.false_positive, origin + Vec2{20, 3.5}));
  EXPECT_TRUE(contains(errors.false_negative, origin + Vec2{50, 20}));
  EXPECT_FALSE(contains(errors.false_negative, origin + Vec2{20, 0}));
  EXPECT_NEAR(
      total(
          surface_errors(roads, road_truth(truth, utm33), {.area = MultiPolygon{box(0, -50, 10, 50)}}).false_positive),
      10.0, 0.01);
  // A ring keeps its hole.
  RoadTruth ring{.surfaces = {{"ring", {{box(0, 0, 40, 40).outer, {box(10, 10, 30, 30).outer}}}}}};
  const SurfaceErrors missed = surface_errors(shape_network({}), ring);
  EXPECT_NEAR(total(missed.false_negative), 1200.0, 0.01);
  EXPECT_FALSE(contains(missed.false_negative, origin + Vec2{20, 20}));
}

}  // namespace
}  // namespace orthodrive

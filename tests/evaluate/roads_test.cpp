// SPDX-License-Identifier: Apache-2.0
// Road and height scores: disturb exact roads by a known amount and read it off the score.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "evaluate/road_lines.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/evaluate/roads/evaluate_heights.hpp"
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"

namespace orthodrive {
namespace {

Polyline circle(double radius_m) {
  Polyline line;
  for (int i = 0; i <= 360; ++i)
    line.push_back({radius_m * std::cos(i * std::numbers::pi / 180), radius_m * std::sin(i * std::numbers::pi / 180)});
  return line;
}
RoadNetwork network(std::vector<RoadPath> paths) { return {utm33, std::move(paths)}; }
RoadScores score(const RoadNetwork& roads, const RoadNetwork& truth, const EvaluateRoadsOptions& options = {}) {
  return evaluate_roads(roads, road_truth(truth, utm33), options);
}

TEST(EvaluateRoads, truth_against_itself_is_perfect) {
  const RoadNetwork truth = network({path_along(circle(50.0), 6.0), path_along(straight(100, 0, 300, 40), 4.0, 2)});
  const RoadScores scores = score(truth, truth);
  EXPECT_NEAR(scores.surface_iou, 1.0, 1e-9);
  EXPECT_NEAR(scores.offset_m.p95, 0.0, 1e-9);
  EXPECT_NEAR(scores.width_m.p95, 0.0, 1e-9);
  EXPECT_DOUBLE_EQ(scores.matched_share, 1.0);
  EXPECT_EQ(scores.offset_m.n, scores.samples);
  EXPECT_NEAR(static_cast<double>(scores.samples), (100.0 * std::numbers::pi + std::hypot(200.0, 40.0)) / 2.0, 1.0);
}

TEST(EvaluateRoads, line_shifted_to_the_left_has_that_bias_and_iou) {
  const RoadNetwork truth = network({path_along(straight(0, 0, 200, 0), 6.0)});
  RoadPath shifted = path_along(straight(0, 1, 200, 1), 7.0);
  const RoadScores scores = score(network({shifted}), truth);
  EXPECT_NEAR(scores.offset_m.bias, 1.0, 1e-9);
  EXPECT_NEAR(scores.offset_m.mean_abs, 1.0, 1e-9);
  EXPECT_NEAR(scores.width_m.bias, 1.0, 1e-9);
  // Ours -2.5..4.5, truth -3..3: 5.5 of 7.5 in common.
  EXPECT_NEAR(scores.surface_iou, 5.5 / 7.5, 1e-5);
  EXPECT_NEAR(score(network({path_along(straight(200, -2, 0, -2), 6.0)}), truth).offset_m.bias, -2.0, 1e-9)
      << "drawn the other way round, to the right of the truth";
}

TEST(EvaluateRoads, overlapping_roads_count_once) {
  // Two roads crossing: the 6 x 6 m in the middle belongs to both.
  const RoadNetwork truth =
      network({path_along(straight(-50, 0, 50, 0), 6.0), path_along(straight(0, -50, 0, 50), 6.0, 2)});
  const RoadNetwork one = network({path_along(straight(-50, 0, 50, 0), 6.0)});
  EXPECT_NEAR(score(one, truth).surface_iou, 600.0 / (1200.0 - 36.0), 1e-6);
}

TEST(EvaluateRoads, crossing_roads_are_not_confused) {
  const RoadNetwork truth = network({path_along(straight(-50, 0, 50, 0), 6.0)});
  const RoadNetwork roads =
      network({path_along(straight(-50, 2, 50, 2), 6.0), path_along(straight(0, -50, 0, 50), 6.0, 2)});
  const RoadScores scores = score(roads, truth);
  EXPECT_NEAR(scores.offset_m.bias, 2.0, 1e-9);
  EXPECT_NEAR(scores.offset_m.p95, 2.0, 1e-9);
}

TEST(EvaluateRoads, missing_road_is_not_matched) {
  const RoadNetwork truth =
      network({path_along(straight(0, 0, 100, 0), 6.0), path_along(straight(0, 40, 100, 40), 6.0, 2)});
  const RoadScores scores = score(network({path_along(straight(0, 0, 100, 0), 6.0)}), truth);
  EXPECT_DOUBLE_EQ(scores.matched_share, 0.5);
  EXPECT_EQ(scores.offset_m.n, 50u);
  EXPECT_NEAR(scores.surface_iou, 0.5, 1e-9);
}

TEST(EvaluateRoads, width_is_measured_across_the_polygon_that_the_line_names) {
  RoadTruth truth;
  const auto box = [](double x0, double y0, double x1, double y1) {
    return MultiPolygon{
        {{origin + Vec2{x0, y0}, origin + Vec2{x1, y0}, origin + Vec2{x1, y1}, origin + Vec2{x0, y1}}, {}}};
  };
  truth.surfaces = {{"wide", box(0, -10, 100, 10)}, {"mine", box(0, -2, 100, 4)}};
  truth.lines = {{.of = "mine", .line = {origin + Vec2{0, 1}, origin + Vec2{100, 1}}}};
  const RoadNetwork roads = network({path_along(straight(0, 1, 100, 1), 7.5)});
  EXPECT_NEAR(evaluate_roads(roads, truth).width_m.bias, 1.5, 1e-9);
  truth.lines[0].of.clear();  // no name: the first surface under the line
  EXPECT_NEAR(evaluate_roads(roads, truth).width_m.bias, -12.5, 1e-9);
  EXPECT_NEAR(evaluate_roads(roads, truth).surface_iou, 750.0 / 2000.0, 1e-6);
}

TEST(EvaluateRoads, truth_of_polygons_alone_scores_the_surface_alone) {
  RoadTruth truth = road_truth(network({path_along(straight(0, 0, 100, 0), 6.0)}), utm33);
  truth.lines.clear();
  const RoadScores scores = evaluate_roads(network({path_along(straight(0, 0, 100, 0), 3.0)}), truth);
  EXPECT_NEAR(scores.surface_iou, 0.5, 1e-9);
  EXPECT_EQ(scores.offset_m.n, 0u);
  EXPECT_TRUE(std::isnan(scores.offset_m.bias));
  EXPECT_TRUE(std::isnan(scores.matched_share));
}

TEST(EvaluateRoads, area_and_ignore_limit_all_numbers) {
  const RoadNetwork truth = network({path_along(straight(0, 0, 100, 0), 6.0)});
  const RoadNetwork roads =
      network({path_along(straight(0, 0, 50, 0), 6.0), path_along(straight(50, 3, 100, 3), 6.0, 2),
               path_along(straight(0, 500, 100, 500), 6.0, 3)});
  const auto box = [](double x0, double x1) {
    return Polygon{{origin + Vec2{x0, -20}, origin + Vec2{x1, -20}, origin + Vec2{x1, 20}, origin + Vec2{x0, 20}}, {}};
  };
  const RoadScores left = score(roads, truth, {.region = {.area = MultiPolygon{box(0, 40)}}});
  EXPECT_NEAR(left.surface_iou, 1.0, 1e-6);
  EXPECT_NEAR(left.offset_m.mean_abs, 0.0, 1e-6);
  EXPECT_EQ(left.samples, 20u);
  const RoadScores right = score(roads, truth, {.region = {.area = MultiPolygon{box(0, 100)}, .ignore = {box(0, 60)}}});
  EXPECT_NEAR(right.offset_m.bias, 3.0, 1e-6);
  EXPECT_NEAR(right.surface_iou, 1.0 / 3.0, 1e-6);
}

TEST(EvaluateRoads, a_road_that_only_touches_the_area_has_no_share_in_the_score) {
  // Its edge lies on the area's: in common they have a line, which no further overlay takes.
  const RoadNetwork truth = network({path_along(straight(10, 50, 90, 50), 6.0)});
  RoadNetwork roads = truth;
  roads.paths.push_back(path_along(straight(103, 10, 103, 90), 6.0, 2));
  const auto square = [](double size_m) {
    return Polygon{{origin, origin + Vec2{size_m, 0}, origin + Vec2{size_m, size_m}, origin + Vec2{0, size_m}}, {}};
  };
  const ScoreRegion region{MultiPolygon{square(100)}, MultiPolygon{square(5)}};
  EXPECT_NEAR(score(roads, truth, {.region = region}).surface_iou, 1.0, 1e-9);
  EXPECT_TRUE(surface_errors(roads, road_truth(truth, utm33), region).false_positive.empty());
}

TEST(EvaluateRoads, sigma_coverage_of_honest_and_of_vain_sigmas) {
  const RoadNetwork truth = network({path_along(straight(0, 0, 4000, 0, 2000), 6.0)});
  RoadPath noisy = path_along(straight(0, 0, 4000, 0, 2000), 6.0);
  Random random(3);
  for (RoadNode& node : noisy.nodes) node.p.y += 0.1 * random.normal(), node.sigma_offset_m = 0.1;
  // Samples lie midway between nodes: the mean of two has 0.7 of the sigma.
  const double at_one = std::erf(1.0 / std::sqrt(0.5) / std::sqrt(2.0));
  EXPECT_NEAR(score(network({noisy}), truth).offset_sigma.one, at_one, 0.03);
  for (RoadNode& node : noisy.nodes) node.sigma_offset_m = 0.01;
  EXPECT_LT(score(network({noisy}), truth).offset_sigma.two, 0.3);
  EXPECT_TRUE(std::isnan(score(network({noisy}), truth).width_sigma.one)) << "no sigma stated";
}

TEST(EvaluateRoads, no_roads_at_all) {
  const RoadNetwork truth = network({path_along(straight(0, 0, 100, 0), 6.0)});
  const RoadScores scores = score(network({}), truth);
  EXPECT_DOUBLE_EQ(scores.surface_iou, 0.0);
  EXPECT_DOUBLE_EQ(scores.matched_share, 0.0);
  EXPECT_TRUE(std::isnan(score(network({}), network({})).surface_iou));
}

TEST(EvaluateRoads, truth_in_another_utm_zone) {
  const RoadNetwork truth = network({path_along(straight(0, 0, 100, 0), 6.0)});
  RoadNetwork zone32 = truth;
  zone32.crs = {"EPSG:32632"};
  const CoordinateTransform there(utm33, zone32.crs);
  for (RoadNode& node : zone32.paths[0].nodes) node.p = there.target_from_source(node.p);
  EXPECT_NEAR(evaluate_roads(truth, road_truth(zone32, utm33)).offset_m.p95, 0.0, 1e-4);
}

// ---- heights
// ---------------------------------------------------------------------------------------------------------

/// z = 100 + 0.05 x - 0.02 y over the square around the origin.
HeightGrid plane() {
  HeightGrid grid{
      .crs = utm33, .frame = {origin.x - 100.0, origin.y + 100.0, 2.0, 100, 100}, .height_m = Raster<float>(100, 100)};
  for (int row = 0; row < 100; ++row)
    for (int col = 0; col < 100; ++col) {
      const Vec2 p = grid.frame.center_of(col, row) - origin;
      grid.height_m.at(col, row) = static_cast<float>(100.0 + 0.05 * p.x - 0.02 * p.y);
    }
  return grid;
}

RoadPath on_plane(Polyline line) {
  RoadPath path = path_along(line, 6.0);
  const std::vector<Vec2> directions = tangents(line);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Vec2 left = left_normal(directions[i]);
    path.nodes[i].z_m = 100.0 + 0.05 * line[i].x - 0.02 * line[i].y;
    path.nodes[i].gradient = 0.05 * directions[i].x - 0.02 * directions[i].y;
    path.nodes[i].banking = std::atan(0.05 * left.x - 0.02 * left.y);
  }
  return path;
}

TEST(EvaluateHeights, roads_on_the_terrain_have_no_error) {
  const HeightScores scores = evaluate_heights(network({on_plane(straight(-50, -20, 50, 30))}), plane());
  EXPECT_NEAR(scores.z_m.p95, 0.0, 1e-4);
  EXPECT_NEAR(scores.gradient.p95, 0.0, 1e-5);
  EXPECT_NEAR(scores.banking.p95, 0.0, 1e-5);
  EXPECT_EQ(scores.z_m.n, 21u);
  EXPECT_NEAR(scores.gradient_energy, std::pow((0.05 * 100 - 0.02 * 50) / std::hypot(100, 50), 2), 1e-9);
}

TEST(EvaluateHeights, raised_steeper_and_tilted_road) {
  RoadPath road = on_plane(straight(-50, 0, 50, 0));
  for (RoadNode& node : road.nodes) node.z_m += 0.5, node.gradient -= 0.01, node.banking += 0.02;
  for (const HeightScores& scores : {evaluate_heights(network({road}), plane()),
                                     evaluate_heights(network({road}), network({on_plane(straight(-60, 0, 60, 0))}))}) {
    EXPECT_NEAR(scores.z_m.bias, 0.5, 1e-4);
    EXPECT_NEAR(scores.gradient.bias, -0.01, 1e-5);
    EXPECT_NEAR(scores.banking.bias, 0.02, 1e-4);
    EXPECT_NEAR(scores.height_error_energy_m2, 0.25, 1e-4);
  }
}

TEST(EvaluateHeights, true_road_drawn_the_other_way_round_and_shifted_sideways) {
  const RoadNetwork roads = network({on_plane(straight(-50, 3, 50, 3))});
  const HeightScores scores = evaluate_heights(roads, network({on_plane(straight(60, 0, -60, 0))}));
  EXPECT_NEAR(scores.z_m.p95, 0.0, 1e-9) << "the true surface goes on sideways with its banking";
  EXPECT_NEAR(scores.gradient.p95, 0.0, 1e-9);
  EXPECT_NEAR(scores.banking.p95, 0.0, 1e-9);
}

TEST(EvaluateHeights, bridges_are_compared_with_true_bridges_only) {
  RoadPath bridge = on_plane(straight(-50, 0, 50, 0));
  bridge.bridge = true, bridge.layer = 1;
  EXPECT_EQ(evaluate_heights(network({bridge}), plane()).nodes, 0u) << "terrain has no decks";
  RoadPath below = on_plane(straight(-60, 1, 60, 1)), deck = on_plane(straight(-60, 4, 60, 4));
  deck.layer = 1;
  for (RoadNode& node : below.nodes) node.z_m -= 6.0;
  EXPECT_NEAR(evaluate_heights(network({bridge}), network({below, deck})).z_m.p95, 0.0, 1e-9)
      << "the nearer road lies below";
}

TEST(EvaluateHeights, nodes_without_height_or_truth_are_counted_not_scored) {
  RoadPath road = on_plane(straight(-50, 0, 500, 0));
  road.nodes[0].z_m = std::numeric_limits<double>::quiet_NaN();
  const HeightScores scores = evaluate_heights(network({road}), plane());
  EXPECT_EQ(scores.nodes, 20u);
  EXPECT_LT(scores.compared_share, 0.5);
  EXPECT_NEAR(scores.z_m.p95, 0.0, 1e-4);
  EXPECT_TRUE(std::isnan(evaluate_heights(network({}), plane()).z_m.bias));
}

TEST(ProfileShape, finds_a_kink_a_step_and_a_twisted_junction) {
  RoadPath main = on_plane(straight(-50, 0, 50, 0)), side = on_plane(straight(0, 0, 10, 50));
  main.nodes[10].osm_node = side.nodes[0].osm_node = 7;
  const auto shape = [&] { return measure_profile_shape(network({main, side})); };
  EXPECT_EQ(shape().junctions, 1u);
  EXPECT_LT(shape().along.size, 1e-9);
  EXPECT_LT(shape().junction.size, 1e-6);
  EXPECT_LT(shape().step_m.size, 1e-9);

  side.nodes[0].z_m += 0.02;
  EXPECT_NEAR(shape().step_m.size, 0.02, 1e-9);
  for (std::size_t i = 15; i < 21; ++i) {  // a corner of 3 % in node 14, its gradient the mean
    main.nodes[i].z_m += 0.03 * (main.nodes[i].p.x - main.nodes[14].p.x);
    main.nodes[i].gradient += 0.03;
  }
  main.nodes[14].gradient += 0.015;
  EXPECT_NEAR(shape().along.size, 0.03, 1e-9);
  EXPECT_EQ(shape().along.where, main.nodes[14].p);
}

TEST(ProfileShape, three_roads_need_one_plane) {
  std::vector<RoadPath> roads;
  for (const double angle :
       {0.0, 2.0 * std::numbers::pi / 3.0, 4.0 * std::numbers::pi / 3.0}) {  // none goes on in another
    roads.push_back(on_plane(straight(0, 0, 50 * std::cos(angle), 50 * std::sin(angle))));
    roads.back().nodes[0].osm_node = 7;
  }
  EXPECT_LT(measure_profile_shape(network(roads)).junction.size, 1e-6);
  roads[1].nodes[0].gradient += 0.02;
  const double kink = measure_profile_shape(network(roads)).junction.size;
  EXPECT_TRUE(kink > 0.004 && kink < 0.02) << kink;
}

TEST(ProfileShape, clearance_counts_where_there_are_two_levels) {
  RoadPath below = on_plane(straight(-50, 0, 50, 0)), above = on_plane(straight(3, -50, 3, 50));
  const auto shape = [&] { return measure_profile_shape(network({below, above})); };
  EXPECT_EQ(shape().level_crossings, 1u);
  EXPECT_TRUE(std::isnan(shape().min_clearance_m));
  above.layer = 1;
  EXPECT_NEAR(shape().min_clearance_m, 0.0, 1e-9) << "the layer says that it should be on another level";
  for (RoadNode& node : above.nodes) node.z_m += 5.2;
  EXPECT_NEAR(shape().min_clearance_m, 5.2, 1e-9);
  EXPECT_EQ(shape().crossings, 1u);
}

TEST(EvaluateHeights, energies_and_sigmas) {
  RoadPath road = on_plane(straight(-50, 0, 50, 0));
  for (std::size_t i = 0; i < road.nodes.size(); ++i) {
    road.nodes[i].z_m += i % 4 == 0 ? 0.3 : 0.0;
    road.nodes[i].sigma_z_m = 0.2, road.nodes[i].gradient += 0.01;
  }
  const HeightScores scores = evaluate_heights(network({road}), network({on_plane(straight(-60, 0, 60, 0))}));
  EXPECT_NEAR(scores.gradient_error_energy, 1e-4, 1e-9);
  EXPECT_NEAR(scores.true_gradient_energy, 0.05 * 0.05, 1e-9);
  EXPECT_NEAR(scores.sigma.one, 15.0 / 21.0, 1e-9);
  EXPECT_NEAR(scores.sigma.two, 1.0, 1e-9);
}

TEST(EvaluateHeights, other_crs_is_refused) {
  HeightGrid other = plane();
  other.crs = {"EPSG:32632"};
  EXPECT_THROW((void)evaluate_heights(network({}), other), OptionError);
}

}  // namespace
}  // namespace orthodrive

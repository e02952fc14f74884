// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/profiles/estimate_profiles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using Terrain = std::function<double(double x, double y)>;
const Crs crs{"EPSG:32633"};
constexpr double nan_height = std::numeric_limits<double>::quiet_NaN();

HeightGrid make_dtm(const Terrain& z, double gsd_m = 2.0, double size_m = 600.0) {
  const int n = static_cast<int>(size_m / gsd_m);
  HeightGrid grid{crs, {-50.0, size_m - 50.0, gsd_m, n, n}, Raster<float>(n, n)};
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col) {
      const Vec2 p = grid.frame.center_of(col, row);
      grid.height_m.at(col, row) = static_cast<float>(z(p.x, p.y));
    }
  return grid;
}

/// Nodes every 2 m from a to b.
RoadPath make_path(std::int64_t osm_id, Vec2 a, Vec2 b, std::int64_t node_a = 0, std::int64_t node_b = 0) {
  RoadPath path;
  path.osm_id = osm_id;
  path.highway = "residential";
  const int steps = std::max(1, static_cast<int>(std::lround(distance(a, b) / 2.0)));
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    path.nodes.push_back({.p = a + (b - a) * f, .s_m = f * distance(a, b), .width_m = 6.0});
  }
  path.nodes.front().osm_node = node_a, path.nodes.back().osm_node = node_b;
  return path;
}

RoadNetwork network(std::vector<RoadPath> paths) { return {crs, std::move(paths)}; }

std::set<std::string> codes(const Findings& findings) {
  std::set<std::string> result;
  for (const Finding& finding : findings) result.insert(finding.code);
  return result;
}

double worst_height_error(const RoadPath& path, const Terrain& z) {
  double worst = 0.0;
  for (const RoadNode& node : path.nodes) worst = std::max(worst, std::abs(node.z_m - z(node.p.x, node.p.y)));
  return worst;
}

TEST(EstimateProfiles, a_slope_stays_a_slope) {
  const Terrain plane = [](double x, double y) { return 100.0 + 0.08 * x - 0.02 * y; };
  for (const auto sampling : {HeightSampling::bilinear, HeightSampling::cubic}) {
    const auto result =
        estimate_profiles(network({make_path(1, {0, 0}, {300, 40})}), {make_dtm(plane, 10.0)}, {.sampling = sampling});
    const RoadPath& path = result.roads.paths[0];
    EXPECT_LT(worst_height_error(path, plane), 0.02);  // 0.27 with the w_g of the reference
    const double gradient = (0.08 * 300 - 0.02 * 40) / std::hypot(300, 40);
    for (const RoadNode& node : path.nodes) {
      EXPECT_NEAR(node.gradient, gradient, 0.005);
      EXPECT_EQ(node.banking, 0.0);
      EXPECT_EQ(node.banking_source, BankingSource::none);
      EXPECT_GT(node.sigma_z_m, 0.0);
    }
    EXPECT_TRUE(result.solve.converged);
    EXPECT_TRUE(result.findings.empty());
  }
}

TEST(EstimateProfiles, gradient_is_positive_uphill_along_the_path) {
  const Terrain plane = [](double x, double) { return 0.05 * x; };
  const auto result =
      estimate_profiles(network({make_path(1, {0, 0}, {100, 0}), make_path(2, {100, 50}, {0, 50})}), {make_dtm(plane)});
  EXPECT_NEAR(result.roads.paths[0].nodes[20].gradient, 0.05, 0.005);
  EXPECT_NEAR(result.roads.paths[1].nodes[20].gradient, -0.05, 0.005);
}

TEST(EstimateProfiles, hills_are_hardly_flattened) {
  const Terrain hills = [](double x, double) { return 50.0 + 6.0 * std::sin(2.0 * std::numbers::pi * x / 200.0); };
  const auto result = estimate_profiles(network({make_path(1, {0, 0}, {400, 0})}), {make_dtm(hills, 10.0)});
  EXPECT_LT(worst_height_error(result.roads.paths[0], hills), 0.35);  // grades up to 19 %, crests of 170 m radius
}

TEST(EstimateProfiles, noise_is_smoothed_and_energies_say_so) {
  const Terrain plane = [](double x, double) { return 0.03 * x; };
  const Terrain noisy = [&](double x, double y) { return plane(x, y) + 0.3 * std::sin(12.9 * x + 78.2 * y); };
  const auto result = estimate_profiles(network({make_path(1, {0, 0}, {400, 3})}), {make_dtm(noisy, 2.0)});
  EXPECT_LT(worst_height_error(result.roads.paths[0], plane), 0.25);
  EXPECT_EQ(result.before.height_error_m2, 0.0);
  EXPECT_LT(result.after.gradient, 0.2 * result.before.gradient);
  EXPECT_NEAR(result.after.gradient, 9e-4, 3e-4);
  EXPECT_LT(result.after.height_error_m2, 0.06);
}

TEST(EstimateProfiles, an_outlier_of_the_terrain_is_cut_off) {
  // A cliff or a building left in the terrain: the Cauchy loss gives up on it.
  const Terrain flat = [](double, double) { return 10.0; };
  const Terrain bump = [](double x, double) { return x > 190 && x < 204 ? 22.0 : 10.0; };
  const auto result = estimate_profiles(network({make_path(1, {0, 0}, {400, 0})}), {make_dtm(bump, 2.0)});
  EXPECT_LT(worst_height_error(result.roads.paths[0], flat), 1.5);
}

TEST(EstimateProfiles, paths_share_heights_where_they_meet) {
  const Terrain plane = [](double x, double y) { return 20.0 + 0.06 * x + 0.04 * y; };
  RoadPath through = make_path(1, {0, 100}, {200, 100}, 1, 2);
  through.nodes[50].osm_node = 7;
  const auto roads =
      network({through, make_path(2, {100, 100}, {100, 300}, 7, 3), make_path(3, {400, 100}, {200, 100}, 4, 2)});
  const auto result = estimate_profiles(roads, {make_dtm(plane)});
  const auto& p = result.roads.paths;
  EXPECT_EQ(p[0].nodes[50].z_m, p[1].nodes.front().z_m);
  EXPECT_EQ(p[0].nodes.back().z_m, p[2].nodes.back().z_m);
  EXPECT_NEAR(p[0].nodes.back().gradient, -p[2].nodes.back().gradient,
              1e-12);  // they go on in each other, in opposite directions
  EXPECT_NEAR(p[0].nodes.back().gradient, 0.06, 0.01);
  for (const RoadPath& path : p) EXPECT_LT(worst_height_error(path, plane), 0.08);
}

/// A straight road on a dam that crosses a valley of `depth_m` on a bridge from x = 180 to 220.
RoadNetwork valley_roads() {
  RoadPath bridge = make_path(2, {180, 0}, {220, 0}, 2, 3);
  bridge.bridge = true, bridge.layer = 1;
  return network({make_path(1, {0, 0}, {180, 0}, 1, 2), bridge, make_path(3, {220, 0}, {400, 0}, 3, 4),
                  make_path(4, {200, -40}, {200, 200})});
}
Terrain valley(double depth_m) {
  return [depth_m](double x, double) { return 30.0 - (x > 178 && x < 222 ? depth_m : 0.0); };
}

TEST(EstimateProfiles, a_bridge_spans_the_valley) {
  const auto result = estimate_profiles(valley_roads(), {make_dtm(valley(8.0))});
  for (int k : {0, 1, 2})
    for (const RoadNode& node : result.roads.paths[k].nodes) EXPECT_NEAR(node.z_m, 30.0, 0.2);
  EXPECT_NEAR(result.roads.paths[3].nodes[20].z_m, 22.0, 0.1);
  EXPECT_TRUE(result.findings.empty());
}

TEST(EstimateProfiles, a_low_bridge_is_raised_over_the_road_below) {
  const auto result = estimate_profiles(valley_roads(), {make_dtm(valley(3.5))});
  const double deck = result.roads.paths[1].nodes[10].z_m, below = result.roads.paths[3].nodes[20].z_m;
  EXPECT_NEAR(below, 26.5, 0.1);  // the road below stays
  EXPECT_GT(deck - below, 4.55);
  EXPECT_THAT(codes(result.findings), testing::Not(testing::Contains("elevate.low_clearance")));
  double steepest = 0.0;
  for (int k : {0, 1, 2})
    for (const RoadNode& node : result.roads.paths[k].nodes) steepest = std::max(steepest, std::abs(node.gradient));
  EXPECT_LT(steepest, 0.08);
}

TEST(EstimateProfiles, a_layer_without_a_bridge_tag_is_a_bridge) {
  RoadNetwork roads = valley_roads();
  roads.paths[1].bridge = false;  // only the layer says that it passes over
  const auto result = estimate_profiles(roads, {make_dtm(valley(0.0))});
  EXPECT_THAT(codes(result.findings), testing::Contains("elevate.assumed_bridge"));
  EXPECT_GT(result.roads.paths[1].nodes[10].z_m - result.roads.paths[3].nodes[20].z_m, 4.69);
}

TEST(EstimateProfiles, clearance_that_cannot_be_made_is_reported) {
  // A loop of 30 m leaves a road and passes over it: no ramp is that steep, and none is tried.
  RoadPath below = make_path(1, {0, 0}, {200, 0}, 1, 2);
  below.nodes[50].osm_node = 7;
  RoadPath loop = make_path(2, {100, 0}, {104, 6}, 7, 8), over = make_path(3, {104, 6}, {106, -6}, 8, 9);
  over.bridge = true, over.layer = 1;
  RoadPath back = make_path(4, {106, -6}, {94, 0}, 9, 10);
  below.nodes[47].osm_node = 10;
  const auto result = estimate_profiles(network({below, loop, over, back}), {make_dtm(valley(0.0))});
  EXPECT_THAT(codes(result.findings), testing::Contains("elevate.low_clearance"));
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) EXPECT_TRUE(std::isfinite(node.z_m) && std::abs(node.z_m - 30.0) < 1.0);
}

TEST(EstimateProfiles, double_decks_keep_their_clearance_along_their_length) {
  // Two bridges of 100 m over a valley, one above the other, each with ramps of its own.
  std::vector<RoadPath> paths;
  for (const int deck : {0, 1}) {
    const double y = 2.0 * deck;
    const std::int64_t n = 10 * deck;
    paths.push_back(make_path(n + 1, {0, y + 40.0 * deck}, {200, y}, n + 1, n + 2));
    paths.push_back(make_path(n + 2, {200, y}, {300, y}, n + 2, n + 3));
    paths.back().bridge = true, paths.back().layer = 1 + deck;
    paths.push_back(make_path(n + 3, {300, y}, {500, y + 40.0 * deck}, n + 3, n + 4));
  }
  const auto result = estimate_profiles(network(paths), {make_dtm([](double, double) { return 30.0; })});
  const RoadPath &lower = result.roads.paths[1], &upper = result.roads.paths[4];
  double least_m = 100.0;
  for (std::size_t n = 5; n + 5 < upper.nodes.size(); ++n)
    least_m = std::min(least_m, upper.nodes[n].z_m - lower.nodes[n].z_m);
  const std::set<std::string> told = codes(result.findings);
  EXPECT_TRUE(least_m > 4.6 || told.contains("elevate.low_clearance")) << least_m;
  EXPECT_GT(least_m, 4.0) << "the ramps are long enough";
}

TEST(EstimateProfiles, a_tunnel_ignores_the_hill_and_passes_below_its_road) {
  RoadPath tunnel = make_path(2, {150, 0}, {250, 0}, 2, 3);
  tunnel.tunnel = true, tunnel.layer = -1;
  const auto roads = network({make_path(1, {0, 0}, {150, 0}, 1, 2), tunnel, make_path(3, {250, 0}, {400, 0}, 3, 4),
                              make_path(4, {200, -40}, {200, 200})});
  const auto result =
      estimate_profiles(roads, {make_dtm([](double x, double) { return x > 150 && x < 250 ? 25.0 : 5.0; })});
  for (const RoadNode& node : result.roads.paths[1].nodes) EXPECT_NEAR(node.z_m, 5.0, 0.3);
  EXPECT_TRUE(result.findings.empty());
}

TEST(EstimateProfiles, the_first_terrain_with_a_height_counts) {
  const HeightGrid fine = make_dtm([](double x, double) { return x < 150 ? 11.0 : nan_height; });
  const HeightGrid coarse = make_dtm([](double, double) { return 10.0; }, 10.0);
  const auto result = estimate_profiles(network({make_path(1, {0, 0}, {300, 0})}), {fine, coarse});
  EXPECT_NEAR(result.roads.paths[0].nodes[20].z_m, 11.0, 0.02);
  EXPECT_NEAR(result.roads.paths[0].nodes[130].z_m, 10.0, 0.02);
  EXPECT_TRUE(result.findings.empty());
}

TEST(EstimateProfiles, holes_of_the_terrain_are_bridged_and_reported) {
  const Terrain plane = [](double x, double) { return 0.04 * x; };
  const HeightGrid holed = make_dtm([&](double x, double y) { return x > 100 && x < 140 ? nan_height : plane(x, y); });
  const auto roads =
      network({make_path(1, {0, 0}, {300, 0}), make_path(2, {110, 50}, {130, 50})});  // way 2 has no height at all
  const auto result = estimate_profiles(roads, {holed});
  EXPECT_LT(worst_height_error(result.roads.paths[0], plane), 0.15);
  EXPECT_LT(worst_height_error(result.roads.paths[1], plane), 2.0);
  EXPECT_EQ(result.findings.size(), 2u);
  EXPECT_THAT(codes(result.findings), testing::ElementsAre("elevate.no_terrain"));
  EXPECT_GT(result.roads.paths[0].nodes[60].sigma_z_m, result.roads.paths[0].nodes[20].sigma_z_m);
}

TEST(EstimateProfiles, any_thread_count_gives_the_same) {
  const Terrain hills = [](double x, double y) { return 20.0 + 5.0 * std::sin(x / 40.0) * std::cos(y / 60.0); };
  const auto one = estimate_profiles(valley_roads(), {make_dtm(hills)}, {.threads = 1});
  const auto four = estimate_profiles(valley_roads(), {make_dtm(hills)}, {.threads = 4});
  for (std::size_t k = 0; k < one.roads.paths.size(); ++k)
    for (std::size_t n = 0; n < one.roads.paths[k].nodes.size(); ++n) {
      EXPECT_EQ(one.roads.paths[k].nodes[n].z_m, four.roads.paths[k].nodes[n].z_m);
      EXPECT_EQ(one.roads.paths[k].nodes[n].sigma_z_m, four.roads.paths[k].nodes[n].sigma_z_m);
    }
}

TEST(EstimateProfiles, degenerate_ways) {
  const HeightGrid flat = make_dtm([](double, double) { return 5.0; });
  RoadPath same = make_path(1, {10, 10}, {10, 10});        // no length
  RoadPath loop = make_path(2, {50, 50}, {52, 50}, 8, 8);  // both ends the same node
  RoadPath bridge = make_path(3, {90, 90}, {120, 90});     // nothing but a bridge
  bridge.bridge = true;
  const auto result = estimate_profiles(network({same, loop, bridge}), {flat});
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) {
      EXPECT_NEAR(node.z_m, 5.0, 1e-3);
      EXPECT_TRUE(std::isfinite(node.gradient) && std::isfinite(node.sigma_z_m));
    }
}

TEST(EstimateProfiles, wrong_input_is_refused) {
  const RoadNetwork roads = network({make_path(1, {0, 0}, {100, 0})});
  EXPECT_THROW((void)estimate_profiles(roads, {}), OptionError);
  EXPECT_THROW((void)estimate_profiles(roads, {make_dtm([](double, double) { return nan_height; })}), OptionError);
  HeightGrid other = make_dtm([](double, double) { return 0.0; });
  other.crs = {"EPSG:32634"};
  EXPECT_THROW((void)estimate_profiles(roads, {other}), OptionError);
  EXPECT_TRUE(estimate_profiles(network({}), {make_dtm([](double, double) { return 0.0; })}).roads.paths.empty());
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// What must hold of profiles: no kinks, limits of the class, clearance, error bars; and the reference's methods beside
// them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "orthodrive/baselines/reference_heights.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/elevate/profiles/estimate_profiles.hpp"
#include "orthodrive/math/robust_fit.hpp"
#include "orthodrive/model/roads/design_limits.hpp"
#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive {
namespace {

using Hills = std::function<double(double x, double y)>;
const Crs network_crs{"EPSG:32633"};

HeightGrid network_dtm(const Hills& z, double gsd_m, double noise_m = 0.0) {
  constexpr double size_m = 700.0;
  Random random(5);
  const int n = static_cast<int>(size_m / gsd_m);
  HeightGrid grid{network_crs, {-50.0, size_m - 50.0, gsd_m, n, n}, Raster<float>(n, n)};
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col) {
      const Vec2 p = grid.frame.center_of(col, row);
      grid.height_m.at(col, row) = static_cast<float>(z(p.x, p.y) + (noise_m > 0.0 ? noise_m * random.normal() : 0.0));
    }
  return grid;
}

RoadPath network_path(std::int64_t osm_id, Vec2 a, Vec2 b, std::int64_t node_a = 0, std::int64_t node_b = 0,
                      const std::string& highway = "residential") {
  RoadPath path{.osm_id = osm_id, .highway = highway};
  const int steps = std::max(1, static_cast<int>(std::lround(distance(a, b) / 2.0)));
  for (int i = 0; i <= steps; ++i) {
    const double f = static_cast<double>(i) / steps;
    path.nodes.push_back({.p = a + (b - a) * f, .s_m = f * distance(a, b), .width_m = 6.0});
  }
  path.nodes.front().osm_node = node_a, path.nodes.back().osm_node = node_b;
  return path;
}

RoadNetwork network_of(std::vector<RoadPath> paths) { return {network_crs, std::move(paths)}; }

int count(const Findings& findings, const std::string& code) {
  return static_cast<int>(
      std::count_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.code == code; }));
}

/// Largest difference of a road's gradient at a junction from the plane that the first two directions span.
double junction_kink(const RoadNetwork& roads) {
  double worst = 0.0;
  for (const PathJunction& junction : find_junctions(roads, link_path_ends(roads))) {
    const auto gradient = [&](const JunctionArm& arm) { return roads.paths[arm.path].nodes[arm.node].gradient; };
    const JunctionArm& a = junction.arms.front();
    const auto b = std::find_if(junction.arms.begin(), junction.arms.end(), [&](const JunctionArm& arm) {
      return std::abs(cross(a.direction, arm.direction)) > 0.1;
    });
    if (b == junction.arms.end()) continue;
    const double det = cross(a.direction, b->direction);
    const Vec2 tilt{(gradient(a) * b->direction.y - gradient(*b) * a.direction.y) / det,
                    (gradient(*b) * a.direction.x - gradient(a) * b->direction.x) / det};
    for (const JunctionArm& arm : junction.arms)
      worst = std::max(worst, std::abs(gradient(arm) - dot(tilt, arm.direction)));
  }
  return worst;
}

/// Gradients of the nodes against the slopes of the segments: a corner in the profile shows in both segments beside it.
double largest_kink(const RoadPath& path) {
  double worst = 0.0;
  const auto misfit = [](const RoadNode& a, const RoadNode& b) {
    return (b.z_m - a.z_m) / distance(a.p, b.p) - 0.5 * (a.gradient + b.gradient);
  };
  for (std::size_t n = 1; n + 1 < path.nodes.size(); ++n)
    worst = std::max(
        worst, 2.0 * std::abs(misfit(path.nodes[n], path.nodes[n + 1]) - misfit(path.nodes[n - 1], path.nodes[n])));
  return worst;
}

/// A main road along x in two ways, a second road through its middle and a side road, on a slope with a ridge.
RoadNetwork crossing_roads() {
  RoadPath west = network_path(1, {0, 200}, {200, 200}, 1, 2, "tertiary"),
           east = network_path(2, {400, 220}, {200, 200}, 3, 2, "tertiary");
  RoadPath across = network_path(3, {190, 0}, {200, 200}, 4, 2), beyond = network_path(4, {200, 200}, {230, 400}, 2, 5);
  RoadPath side = network_path(5, {100, 200}, {140, 330}, 6, 7, "service");
  west.nodes[50].osm_node = 6;
  return network_of({west, east, across, beyond, side});
}
const Hills ridge = [](double x, double y) {
  return 40.0 + 0.06 * x - 0.05 * y + 4.0 * std::exp(-std::pow((y - 210.0) / 30.0, 2));
};

TEST(NetworkProfiles, roads_meet_in_one_tangent_plane) {
  for (const double gsd_m : {1.0, 10.0}) {
    const auto result = estimate_profiles(crossing_roads(), {network_dtm(ridge, gsd_m, 0.03)});
    EXPECT_TRUE(result.solve.converged);
    EXPECT_LT(junction_kink(result.roads), 1e-3);
    for (const RoadPath& path : result.roads.paths)
      EXPECT_LT(largest_kink(path), 3e-3) << path.osm_id;  // corners have a per cent
    const auto& p = result.roads.paths;
    EXPECT_EQ(p[0].nodes.back().z_m, p[1].nodes.back().z_m);
    EXPECT_EQ(p[0].nodes.back().z_m, p[2].nodes.back().z_m);
    EXPECT_EQ(p[0].nodes.back().z_m, p[3].nodes.front().z_m);
    EXPECT_EQ(p[0].nodes[50].z_m, p[4].nodes.front().z_m);
    EXPECT_NEAR(p[0].nodes.back().gradient, -p[1].nodes.back().gradient, 1e-12) << "one road, in two directions";
  }
}

TEST(NetworkProfiles, the_plane_falls_across_the_main_road_as_its_banking_says) {
  RoadNetwork roads = crossing_roads();
  for (const double banking : {0.0, 0.05}) {
    for (std::size_t k : {0, 1})
      for (RoadNode& node : roads.paths[k].nodes)
        node.banking = (k == 0 ? 1.0 : -1.0) * banking, node.banking_source = BankingSource::truth;
    const auto result = estimate_profiles(roads, {network_dtm([](double, double) { return 10.0; }, 2.0)});
    // The side road leaves the main road to its left, which the banking raises, at 73 degrees.
    EXPECT_NEAR(result.roads.paths[4].nodes.front().gradient, std::tan(banking) * 130.0 / std::hypot(40.0, 130.0),
                0.012);
    EXPECT_EQ(result.roads.paths[0].nodes[3].banking, banking) << "banking is not ours to change";
  }
}

TEST(NetworkProfiles, limits_of_the_class_hold_and_give_way_where_the_terrain_is_sure) {
  // A terrain error of 1.5 m over 12 m would be a crest of 12 m radius; a hill of 24 % is none.
  const Hills bump = [](double x, double) { return 20.0 + (x > 200.0 && x < 212.0 ? 1.5 : 0.0); };
  const auto held =
      estimate_profiles(network_of({network_path(1, {0, 0}, {400, 0}, 0, 0, "primary")}), {network_dtm(bump, 2.0)});
  const DesignLimits limits = design_limits("primary");
  const auto& nodes = held.roads.paths[0].nodes;
  for (std::size_t n = 1; n < nodes.size(); ++n) {
    const double curvature = (nodes[n].gradient - nodes[n - 1].gradient) / 2.0;
    EXPECT_GE(curvature, -1.02 / limits.crest_radius_m);
    EXPECT_LE(curvature, 1.02 / limits.sag_radius_m);
  }
  EXPECT_EQ(count(held.findings, "elevate.curvature_over_limit"), 0);

  const Hills steep = [](double x, double) { return 20.0 + 0.24 * std::clamp(x - 100.0, 0.0, 200.0); };
  const auto given = estimate_profiles(network_of({network_path(1, {0, 0}, {400, 0})}), {network_dtm(steep, 2.0)});
  EXPECT_GE(count(given.findings, "elevate.gradient_over_limit"), 1);
  EXPECT_NEAR(given.roads.paths[0].nodes[100].z_m, steep(200.0, 0.0), 0.3);
}

TEST(NetworkProfiles, standard_deviations_hold) {
  // Noise of 20 cm a pixel on a hilly road of its class: errors in units of their sigma.
  const Hills hills = [](double x, double y) { return 60.0 + 5.0 * std::sin(x / 60.0) + 4.0 * std::cos(y / 70.0); };
  std::size_t within_one = 0, within_two = 0, all = 0;
  std::vector<RoadPath> paths;
  paths.reserve(20);
  for (int i = 0; i < 20; ++i) paths.push_back(network_path(i + 1, {0.0, 25.0 * i}, {600.0, 30.0 * i}));
  const auto result = estimate_profiles(network_of(paths), {network_dtm(hills, 2.0, 0.2)});
  EXPECT_NEAR(result.terrain_sigma_m[0], 0.16, 0.05) << "cubic interpolation averages a little";
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) {
      const double error = std::abs(node.z_m - hills(node.p.x, node.p.y));
      ++all, within_one += error <= node.sigma_z_m ? 1 : 0, within_two += error <= 2.0 * node.sigma_z_m ? 1 : 0;
    }
  EXPECT_NEAR(static_cast<double>(within_one) / static_cast<double>(all), 0.68, 0.12);
  EXPECT_GT(static_cast<double>(within_two) / static_cast<double>(all), 0.88);
}

TEST(NetworkProfiles, a_bench_in_a_slope_is_less_sure_than_a_road_on_the_flat_where_pixels_hide_it) {
  const auto sigma_m = [](double slope, double gsd_m) {
    const Hills hillside = [slope](double, double y) { return 60.0 + slope * y; };
    const auto result =
        estimate_profiles(network_of({network_path(1, {0, 0}, {400, 0})}), {network_dtm(hillside, gsd_m)});
    return result.roads.paths[0].nodes[100].sigma_z_m;
  };
  EXPECT_GT(sigma_m(0.3, 12.0), 0.3 * 3.0 / std::sqrt(3.0)) << "6 m wide, uniform from all cut to all fill";
  EXPECT_LT(sigma_m(0.0, 12.0), 0.2);
  EXPECT_NEAR(sigma_m(0.3, 2.0), sigma_m(0.0, 2.0), 0.005) << "fine pixels show the bench";
}

TEST(NetworkProfiles, untagged_crossings_take_the_level_that_the_terrain_shows) {
  // Road 2 is carried over road 1, which lies in a cutting; decks are not in the terrain.
  const Hills cutting = [](double x, double) {
    return 50.0 - 6.0 * std::clamp((18.0 - std::abs(x - 200.0)) / 8.0, 0.0, 1.0);
  };
  const auto roads = network_of({network_path(1, {200, 0}, {200, 400}), network_path(2, {0, 200}, {400, 203})});
  const auto result = estimate_profiles(roads, {network_dtm(cutting, 1.0)});
  EXPECT_EQ(count(result.findings, "elevate.assumed_bridge"), 1);
  EXPECT_NEAR(result.roads.paths[0].nodes[100].z_m, 44.0, 0.2);
  EXPECT_GT(result.roads.paths[1].nodes[100].z_m, 48.69);
  EXPECT_EQ(count(result.findings, "elevate.low_clearance"), 0);
}

TEST(NetworkProfiles, ends_drawn_across_a_road_are_no_bridges) {
  const auto roads = network_of({network_path(1, {0, 200}, {400, 200}), network_path(2, {200.5, 100}, {200.5, 203})});
  const auto result = estimate_profiles(roads, {network_dtm([](double, double) { return 5.0; }, 2.0)});
  EXPECT_EQ(count(result.findings, "elevate.missing_junction"), 1);
  EXPECT_EQ(count(result.findings, "elevate.assumed_bridge"), 0);
  for (const RoadPath& path : result.roads.paths)
    for (const RoadNode& node : path.nodes) EXPECT_NEAR(node.z_m, 5.0, 1e-3);
}

TEST(NetworkProfiles, a_tunnel_lies_under_the_terrain_and_a_contradiction_is_resolved) {
  RoadPath tunnel = network_path(2, {150, 0}, {250, 0}, 2, 3);
  tunnel.tunnel = tunnel.bridge = true, tunnel.layer = -1;
  const Hills dip = [](double x, double) { return x > 180 && x < 220 ? 8.0 : 10.0; };  // a river above it, say
  const auto result = estimate_profiles(
      network_of({network_path(1, {0, 0}, {150, 0}, 1, 2), tunnel, network_path(3, {250, 0}, {400, 0}, 3, 4)}),
      {network_dtm(dip, 2.0)});
  EXPECT_EQ(count(result.findings, "elevate.contradicting_tags"), 1);
  EXPECT_LT(result.roads.paths[1].nodes[25].z_m, 8.0);
}

TEST(NetworkProfiles, what_the_loss_gives_up_on_is_reported) {
  const Hills bridge = [](double x, double) { return 30.0 - (x > 180 && x < 220 ? 9.0 : 0.0); };  // nobody tagged it
  const auto result =
      estimate_profiles(network_of({network_path(1, {0, 0}, {400, 0}, 0, 0, "secondary")}), {network_dtm(bridge, 1.0)});
  EXPECT_EQ(count(result.findings, "elevate.off_terrain"), 1);
  EXPECT_GT(result.roads.paths[0].nodes[100].z_m, 28.0);
}

TEST(NetworkProfiles, single_pixels_that_are_wrong_leave_the_road_as_it_is) {
  // 40 m up and down, as birds and multiple reflections leave them in models that nobody edited.
  const Hills slope = [](double x, double) { return 50.0 + 0.04 * x; };
  const Hills spikes = [&](double x, double y) {
    return slope(x, y) + (std::abs(x - 121.0) < 1.0 ? 40.0 : std::abs(x - 301.0) < 1.0 ? -40.0 : 0.0);
  };
  const auto result = estimate_profiles(network_of({network_path(1, {0, 0}, {400, 0})}), {network_dtm(spikes, 2.0)});
  for (const RoadNode& node : result.roads.paths[0].nodes) {
    EXPECT_NEAR(node.z_m, slope(node.p.x, node.p.y), 0.1);
    EXPECT_NEAR(node.gradient, 0.04, 0.01);
  }
  // A plateau of wrong pixels is long enough to be told of.
  const Hills block = [&](double x, double y) { return slope(x, y) + (std::abs(x - 200.0) < 8.0 ? 30.0 : 0.0); };
  const auto told = estimate_profiles(network_of({network_path(1, {0, 0}, {400, 0})}), {network_dtm(block, 2.0)});
  EXPECT_EQ(count(told.findings, "elevate.off_terrain"), 1);
  EXPECT_NEAR(told.roads.paths[0].nodes[100].z_m, 58.0, 1.0);
}

TEST(NetworkProfiles, a_road_that_leaves_the_terrain_runs_out_and_feet_are_noticed) {
  const Hills half = [](double x, double) {
    return x < 200.0 ? 10.0 + 0.08 * x : std::numeric_limits<double>::quiet_NaN();
  };
  const auto edge = estimate_profiles(network_of({network_path(1, {0, 0}, {600, 0})}), {network_dtm(half, 10.0)});
  EXPECT_EQ(count(edge.findings, "elevate.no_terrain"), 1);
  const double end_z_m = edge.roads.paths[0].nodes.back().z_m;
  EXPECT_TRUE(end_z_m > 24.0 && end_z_m < 50.0) << end_z_m;
  EXPECT_GT(edge.roads.paths[0].nodes.back().sigma_z_m, 1.0);

  const Hills slope = [](double x, double y) { return 0.06 * x + 0.05 * y; };
  const auto as_given = [&](double unit) {
    const HeightGrid dtm = network_dtm([&](double x, double y) { return unit * slope(x, y); }, 10.0);
    const Findings findings = estimate_profiles(crossing_roads(), {dtm}).findings;
    for (const Finding& finding : findings) {
      if (finding.code != "elevate.implausible_terrain") continue;
      EXPECT_NE(finding.message.find("taken for metres"), std::string::npos) << "what was assumed";
    }
    return count(findings, "elevate.implausible_terrain");
  };
  EXPECT_EQ(as_given(1.0), 0);
  EXPECT_EQ(as_given(3.28084), 1);
  EXPECT_EQ(as_given(300.0), 1) << "heights of no place on earth";
}

// ---- the reference's methods, in place of the network's

SolvedHeights by_reference(const RoadNetwork& roads, const NodeHeights& terrain_m) {
  return reference_heights(roads, terrain_m);
}

TEST(ReferenceMethods, moving_averages_keep_lines_and_shorten_at_the_ends) {
  const Hills spike = [](double x, double) { return std::abs(x - 100.0) < 1.0 ? 11.0 : 0.0; };
  const auto heights = [&](int window) {
    return estimate_profiles(
        network_of({network_path(1, {0, 0.5}, {200, 0.5})}), {network_dtm(spike, 1.0)},
        {.sampling = HeightSampling::bilinear, .instead = [window](const RoadNetwork& roads, const NodeHeights& z_m) {
           return SolvedHeights{.z_m = moving_average(roads, z_m, window)};
         }});
  };
  const double raw = heights(1).roads.paths[0].nodes[50].z_m;
  EXPECT_GT(raw, 5.0);
  const auto eleven = heights(11);
  for (std::size_t n : {45, 50, 55}) EXPECT_NEAR(eleven.roads.paths[0].nodes[n].z_m, raw / 11.0, 1e-4);
  EXPECT_NEAR(eleven.roads.paths[0].nodes[56].z_m, 0.0, 1e-9);
  EXPECT_EQ(heights(67).roads.paths[0].nodes.front().z_m, 0.0);
  EXPECT_EQ(heights(1).after.height_error_m2, 0.0);
  EXPECT_GT(eleven.after.height_error_m2, 0.0);
  EXPECT_THROW((void)heights(10), OptionError);
}

/// Cost of the reference's model at given heights, as sec. 3.4.2 writes it.
double reference_cost(const RoadPath& path, const std::vector<double>& z, const std::vector<double>& terrain) {
  double cost = 0.0;
  std::vector<double> gradient;
  for (std::size_t n = 0; n + 1 < z.size(); ++n)
    gradient.push_back((z[n + 1] - z[n]) / distance(path.nodes[n].p, path.nodes[n + 1].p));
  for (const double g : gradient) cost += 0.5 * std::pow(1.2 * g, 2);
  for (std::size_t n = 1; n < gradient.size(); ++n) cost += 0.5 * std::pow(12.0 * (gradient[n] - gradient[n - 1]), 2);
  for (std::size_t n = 0; n < z.size(); ++n)
    cost += 0.5 * 0.04 * 0.25 * std::log1p(std::pow((z[n] - terrain[n]) / 0.5, 2));
  return cost;
}

TEST(ReferenceMethods, the_optimisation_ends_in_a_minimum_of_the_published_cost) {
  const Hills rough = [](double x, double y) { return 20.0 + 2.0 * std::sin(x / 15.0) + 0.5 * std::sin(3.0 * x + y); };
  const HeightGrid dtm = network_dtm(rough, 2.0);
  const RoadPath path = network_path(1, {0, 10}, {120, 14});
  const auto result = estimate_profiles(network_of({path}), {dtm}, {.instead = by_reference});
  ASSERT_TRUE(result.solve.converged);
  std::vector<double> z, terrain;
  for (std::size_t n = 0; n < path.nodes.size(); ++n) {
    z.push_back(result.roads.paths[0].nodes[n].z_m);
    terrain.push_back(sample_cubic(dtm, path.nodes[n].p));
  }
  const double best = reference_cost(path, z, terrain);
  EXPECT_NEAR(best, result.solve.cost_after, 1e-9);
  for (std::size_t n = 0; n < z.size(); ++n)
    for (const double step : {-1e-3, 1e-3}) {
      std::vector<double> moved = z;
      moved[n] += step;
      EXPECT_GT(reference_cost(path, moved, terrain), best);
    }
}

TEST(ReferenceMethods, ways_do_not_share_heights) {
  const auto result = estimate_profiles(crossing_roads(), {network_dtm(ridge, 2.0)}, {.instead = by_reference});
  EXPECT_NE(result.roads.paths[0].nodes.back().z_m, result.roads.paths[2].nodes.back().z_m);
  EXPECT_EQ(result.roads.paths[0].nodes.front().sigma_z_m, 0.0);
}

// ---- the solver

TEST(RobustFit, bounds_hold_until_the_pull_is_stronger) {
  const auto solved = [](double weight) {
    RobustFit fit(1);
    const Term x{0, 1.0};
    fit.add_square({&x, 1}, 10.0, weight);             // pulls up with weight * (10 - x)
    fit.add_bounds({&x, 1}, -1.0, 2.0, 1000.0, 0.01);  // holds against a force of 10
    std::vector<double> result{0.0};
    EXPECT_TRUE(fit.solve(result, 100, 1e-9).converged);
    return result[0];
  };
  EXPECT_NEAR(solved(1.0), 2.008, 1e-3);              // force 8
  EXPECT_NEAR(solved(2.0), 10.0 - 10.0 / 2.0, 1e-6);  // 16 would be needed
}

TEST(RobustFit, bounds_that_newton_stalls_at_are_met_from_soft_to_hard) {
  // A chain that two outliers far off pull through many stiff bounds, each of which a Newton step sees only once
  // within.
  constexpr int n = 60;
  RobustFit fit(n);
  for (int i = 0; i < n; ++i) {
    const Term here{i, 1.0};
    fit.add_cauchy({&here, 1}, i % 7 == 0 ? 30.0 : 0.0, 25.0, 0.5);
    if (i > 1) fit.add_square(std::array{Term{i - 2, 1.0}, Term{i - 1, -2.0}, Term{i, 1.0}}, 0.0, 4.0);
    if (i > 0) fit.add_bounds(std::array{Term{i - 1, -1.0}, Term{i, 1.0}}, -0.05, 0.05, 4e6, 1e-3);
    if (i % 20 == 10) fit.add_bounds({&here, 1}, 4.72, INFINITY, 4e7, 1e-3);
  }
  std::vector<double> x(n, 0.0);
  EXPECT_TRUE(fit.solve(x, 50, 2e-4).converged);
  for (int i = 1; i < n; ++i) EXPECT_LE(std::abs(x[i] - x[i - 1]), 0.0511);
}

TEST(RobustFit, an_outlier_counts_little_and_repeated_unknowns_add_up) {
  RobustFit fit(2);
  const Term x{0, 1.0}, y_twice[] = {{1, 0.5}, {1, 0.5}};
  for (const double value : {1.0, 1.1, 0.9, 40.0}) fit.add_cauchy({&x, 1}, value, 1.0, 0.5);
  fit.add_square(y_twice, 7.0, 2.0);
  std::vector<double> result{1.0, 0.0};
  EXPECT_TRUE(fit.solve(result, 100, 1e-10).converged);
  EXPECT_NEAR(result[0], 1.0, 0.02);
  EXPECT_NEAR(result[1], 7.0, 1e-9);
}

}  // namespace
}  // namespace orthodrive

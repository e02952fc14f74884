// SPDX-License-Identifier: Apache-2.0
// Banking and crown: measured on terrain with a known bed, and by the rules of design.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/elevate/banking/design_banking.hpp"
#include "orthodrive/elevate/banking/estimate_banking.hpp"
#include "sanitized.hpp"

namespace orthodrive {
namespace {

using namespace elevate;

using Slope = std::function<double(double x, double y)>;
const Crs banked_crs{"EPSG:32633"};
constexpr double pi = std::numbers::pi;
constexpr double no_height = std::numeric_limits<double>::quiet_NaN();

/// Mean of the terrain over each pixel (4 x 4 points), with independent noise.
HeightGrid banked_dtm(const Slope& z, double gsd_m, double noise_m = 0.0, std::uint64_t seed = 1,
                      double size_m = 600.0) {
  const int n = static_cast<int>(size_m / gsd_m);
  HeightGrid grid{banked_crs, {-50.0, size_m - 50.0, gsd_m, n, n}, Raster<float>(n, n)};
  Random random(seed);
  for (int row = 0; row < n; ++row)
    for (int col = 0; col < n; ++col) {
      double sum = 0.0;
      for (int i = 0; i < 16; ++i) {
        const int across = i % 4, down = i / 4;
        const Vec2 p = grid.frame.world_from_pixel(col + 0.125 + 0.25 * across, row + 0.125 + 0.25 * down);
        sum += z(p.x, p.y) / 16.0;
      }
      grid.height_m.at(col, row) = static_cast<float>(sum + noise_m * random.normal());
    }
  return grid;
}

constexpr double half_m = 3.5;

/// Rise over the centre line at t: banking and crown on the carriageway, a shoulder that falls by 1 : 3 beyond it.
double bed(double t, double slope, double crown = 0.0) {
  const double inside = std::clamp(t, -half_m, half_m);
  return inside * slope - std::abs(inside) * crown - (std::abs(t) - std::abs(inside)) / 3.0;
}

/// Nodes every 2 m along a curve; heights and gradients as given along it.
RoadPath banked_path(std::int64_t osm_id, const Polyline& line, const Slope& z,
                     const std::string& highway = "residential", std::int64_t node_a = 0, std::int64_t node_b = 0) {
  RoadPath path;
  path.osm_id = osm_id, path.highway = highway;
  const std::vector<double> s = arc_lengths_m(line);
  for (std::size_t i = 0; i < line.size(); ++i)
    path.nodes.push_back({.p = line[i], .s_m = s[i], .width_m = 2.0 * half_m, .z_m = z(line[i].x, line[i].y)});
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::size_t a = i > 0 ? i - 1 : 0, b = std::min(i + 1, line.size() - 1);
    path.nodes[i].gradient = s[b] > s[a] ? (path.nodes[b].z_m - path.nodes[a].z_m) / (s[b] - s[a]) : 0.0;
  }
  path.nodes.front().osm_node = node_a, path.nodes.back().osm_node = node_b;
  return path;
}
Polyline straight(Vec2 a, Vec2 b) {
  Polyline line;
  const int steps = std::max(1, static_cast<int>(std::lround(distance(a, b) / 2.0)));
  for (int i = 0; i <= steps; ++i) line.push_back(a + (b - a) * (static_cast<double>(i) / steps));
  return line;
}
/// Counter-clockwise when to > from: a left bend.
Polyline arc(Vec2 centre, double radius_m, double from, double to) {
  Polyline line;
  const int steps = std::max(2, static_cast<int>(std::lround(std::abs(to - from) * radius_m / 2.0)));
  for (int i = 0; i <= steps; ++i) {
    const double a = from + (to - from) * i / steps;
    line.push_back(centre + Vec2{std::cos(a), std::sin(a)} * radius_m);
  }
  return line;
}
Polyline reversed(Polyline line) {
  std::reverse(line.begin(), line.end());
  return line;
}
RoadNetwork banked_network(std::vector<RoadPath> paths) { return {banked_crs, std::move(paths)}; }
EstimateBankingResult measure(std::vector<RoadPath> paths, const HeightGrid& dtm, const BankingOptions& options = {}) {
  return estimate_banking(banked_network(std::move(paths)), std::span(&dtm, 1), options);
}
EstimateBankingResult design(std::vector<RoadPath> paths, const BankingOptions& options = {}) {
  return estimate_banking(banked_network(std::move(paths)), {}, options);
}
std::vector<std::string> codes_in_order(const Findings& findings) {
  std::vector<std::string> result;
  for (const Finding& finding : findings) result.push_back(finding.code);
  return result;
}

struct Errors {
  double mean = 0.0, worst = 0.0;
};
Errors against(const RoadPath& path, const std::function<double(const RoadNode&)>& value, double expected) {
  Errors errors;
  for (const RoadNode& node : path.nodes) {
    const double error = std::abs(value(node) - expected);
    errors.mean += error / static_cast<double>(path.nodes.size()), errors.worst = std::max(errors.worst, error);
  }
  return errors;
}
double slope_of(const RoadNode& node) { return std::tan(node.banking); }
double crown_of(const RoadNode& node) { return std::tan(node.crown); }

const Slope flat = [](double, double) { return 20.0; };

/// A straight road across the rows of the grid (along them, a grid of 2 m has two rows of pixels on the road and shows
/// no crown).
const Vec2 slant_begin{0, 60}, slant_end{400, 190};
double slant_t(double x, double y) { return cross(normalized(slant_end - slant_begin), Vec2{x, y} - slant_begin); }

// ---- measured

TEST(Banking, bend_falls_to_the_inside_with_opendrives_sign) {
  const Vec2 centre{250, 250};
  const Slope z = [&](double x, double y) {
    return 30.0 + bed(100.0 - distance({x, y}, centre), -0.05);
  };  // t: left is the centre
  for (const double gsd_m : {1.0, 2.0}) {
    const HeightGrid dtm = banked_dtm(z, gsd_m, 0.03);
    const auto left = measure({banked_path(1, arc(centre, 100.0, 0.0, pi), z)}, dtm).roads.paths[0];
    EXPECT_LT(against(left, slope_of, -0.05).mean, 0.003) << gsd_m;  // a left bend: the right side is higher
    const auto right = measure({banked_path(1, arc(centre, 100.0, pi, 0.0), z)}, dtm).roads.paths[0];
    EXPECT_LT(against(right, slope_of, 0.05).mean, 0.003) << gsd_m;
    for (const RoadNode& node : left.nodes) {
      EXPECT_EQ(node.banking_source, BankingSource::dtm);
      EXPECT_GT(node.sigma_banking, 0.0005);
      EXPECT_LT(node.sigma_banking, 0.02);
    }
  }
}

TEST(Banking, slope_and_hills_of_the_profile_are_no_banking) {
  const Slope z = [](double x, double y) { return 30.0 + 0.08 * x + 2.0 * std::sin(x / 25.0) + bed(y - 100.0, 0.03); };
  const auto result = measure({banked_path(1, straight({0, 100}, {400, 100}), z)}, banked_dtm(z, 2.0, 0.02));
  EXPECT_LT(against(result.roads.paths[0], slope_of, 0.03).mean, 0.003);
}

TEST(Banking, sigmas_hold) {
  std::vector<double> ratios;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Slope z = [](double x, double y) { return 30.0 + bed(slant_t(x, y), 0.02); };
    const auto result = measure({banked_path(1, straight(slant_begin, slant_end), z)}, banked_dtm(z, 2.0, 0.05, seed));
    for (const RoadNode& node : result.roads.paths[0].nodes)
      ratios.push_back((slope_of(node) - 0.02) / node.sigma_banking);
  }
  double squares = 0.0;
  for (const double r : ratios) squares += r * r / static_cast<double>(ratios.size());
  EXPECT_GT(squares, 0.3);
  EXPECT_LT(squares, 1.8);
}

TEST(Banking, crown_is_found_in_noise) {
  for (const double gsd_m : {1.0, 2.0})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Slope z = [](double x, double y) { return 30.0 + bed(slant_t(x, y), 0.0, 0.025); };
      const auto result =
          measure({banked_path(1, straight(slant_begin, slant_end), z)}, banked_dtm(z, gsd_m, 0.05, seed));
      EXPECT_LT(against(result.roads.paths[0], crown_of, 0.025).mean, gsd_m < 1.5 ? 0.005 : 0.010)
          << gsd_m << " seed " << seed;
      EXPECT_LT(against(result.roads.paths[0], slope_of, 0.0).mean, 0.006) << gsd_m << " seed " << seed;
    }
}

TEST(Banking, noise_makes_no_crown) {
  for (const double gsd_m : {0.5, 1.0, 2.0})
    for (std::uint64_t seed = 1; seed <= (sanitized ? 1U : 8U); ++seed) {
      const Slope z = [](double x, double y) { return 30.0 + bed(slant_t(x, y), 0.025); };
      const auto result =
          measure({banked_path(1, straight(slant_begin, slant_end), z)}, banked_dtm(z, gsd_m, 0.05, seed));
      EXPECT_EQ(against(result.roads.paths[0], crown_of, 0.0).worst, 0.0) << gsd_m << " seed " << seed;
    }
}

TEST(Banking, roof_turns_into_a_plane) {
  // A crowned straight whose outer half turns up into a banked stretch.
  const Slope z = [](double x, double y) {
    const double f = std::clamp((x - 180.0) / 40.0, 0.0, 1.0);
    return 30.0 + bed(y - 100.0, 0.04 * f, 0.025 * (1.0 - f));
  };
  const auto nodes =
      measure({banked_path(1, straight({0, 100}, {400, 100}), z)}, banked_dtm(z, 1.0, 0.03)).roads.paths[0].nodes;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    EXPECT_NEAR(crown_of(nodes[i]), nodes[i].p.x < 200.0 ? 0.025 : 0.0,
                std::abs(nodes[i].p.x - 200.0) < 50.0 ? 0.025 : 0.008)
        << i;
    EXPECT_LT(i == 0 ? 0.0 : std::abs(crown_of(nodes[i]) - crown_of(nodes[i - 1])), 0.004)
        << "no jump of the crown " << i;
  }
}

TEST(Banking, kerbs_walls_and_heaps_do_not_tilt_the_road) {
  // A wall of 2 m for 30 m along one edge, reaching 1 m into the road; a heap of 1 m on the other half.
  const Slope z = [](double x, double y) {
    const double t = y - 100.0;
    if (t > 2.5 && x > 150 && x < 180) return 32.0;
    if (t < -0.5 && t > -3.0 && x > 250 && x < 254) return 31.0;
    return 30.0 + bed(t, 0.02);
  };
  const Slope road = [](double, double y) { return 30.0 + bed(y - 100.0, 0.02); };
  const auto result = measure({banked_path(1, straight({0, 100}, {400, 100}), road)}, banked_dtm(z, 1.0, 0.03));
  EXPECT_LT(against(result.roads.paths[0], slope_of, 0.02).worst, 0.012);
}

TEST(Banking, ways_in_a_row_are_one_road_and_against_it_the_sign_changes) {
  const Vec2 centre{250, 250};
  const Slope z = [&](double x, double y) { return 30.0 + bed(100.0 - distance({x, y}, centre), -0.04); };
  const auto paths = measure({banked_path(1, arc(centre, 100.0, 0.0, 1.0), z, "tertiary", 1, 2),
                              banked_path(2, reversed(arc(centre, 100.0, 1.0, 2.0)), z, "tertiary", 3, 2),
                              banked_path(3, arc(centre, 100.0, 2.0, 3.0), z, "tertiary", 3, 4)},
                             banked_dtm(z, 2.0, 0.03))
                         .roads.paths;
  EXPECT_EQ(paths[0].nodes.back().banking, -paths[1].nodes.back().banking);
  EXPECT_EQ(paths[1].nodes.front().banking, -paths[2].nodes.front().banking);
  EXPECT_EQ(paths[0].nodes.back().crown, paths[1].nodes.back().crown);
  EXPECT_LT(against(paths[0], slope_of, -0.04).mean, 0.004);
  EXPECT_LT(against(paths[1], slope_of, 0.04).mean, 0.004);
}

TEST(Banking, closed_way_has_no_seam) {
  const Vec2 centre{250, 250};
  const Slope z = [&](double x, double y) {
    const double angle = std::atan2(y - centre.y, x - centre.x);
    return 30.0 + bed(100.0 - distance({x, y}, centre), -0.04 + 0.02 * std::cos(angle));
  };
  const HeightGrid dtm = banked_dtm(z, 2.0, 0.03);
  const Polyline line = arc(centre, 100.0, 0.0, 2.0 * pi);
  const auto at_zero = measure({banked_path(1, line, z, "raceway", 5, 5)}, dtm).roads.paths[0].nodes;
  EXPECT_EQ(at_zero.front().banking, at_zero.back().banking);
  Polyline turned(line.begin() + 60, line.end());
  turned.insert(turned.end(), line.begin() + 1, line.begin() + 61);
  const auto at_sixty = measure({banked_path(1, turned, z, "raceway", 5, 5)}, dtm).roads.paths[0].nodes;
  EXPECT_EQ(at_sixty.front().banking, at_sixty.back().banking);
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    const std::size_t k = i >= 60 ? i - 60 : i - 60 + line.size() - 1;
    EXPECT_NEAR(at_zero[i].banking, at_sixty[k].banking, 2e-4) << i;  // gradients at the ends of a way are one-sided
    EXPECT_LT(std::abs(at_zero[i].banking - at_zero[i - 1].banking), 0.003) << i;
  }
}

TEST(Banking, bridges_go_on_over_what_lies_below) {
  // A ravine across; terrain on the deck's place slopes the wrong way.
  const Slope road = [](double, double y) { return 30.0 + bed(y - 100.0, 0.03); };
  const Slope z = [&](double x, double y) { return x > 176 && x < 224 ? 20.0 - 0.3 * (y - 100.0) : road(x, y); };
  RoadPath bridge = banked_path(2, straight({180, 100}, {220, 100}), road, "tertiary", 2, 3);
  bridge.bridge = true, bridge.layer = 1;
  const auto result = measure({banked_path(1, straight({0, 100}, {180, 100}), road, "tertiary", 1, 2), bridge,
                               banked_path(3, straight({220, 100}, {400, 100}), road, "tertiary", 3, 4)},
                              banked_dtm(z, 2.0, 0.02));
  for (const RoadPath& path : result.roads.paths) EXPECT_LT(against(path, slope_of, 0.03).worst, 0.012) << path.osm_id;
  EXPECT_EQ(result.roads.paths[1].nodes[10].banking_source, BankingSource::interpolated);
  EXPECT_GT(result.roads.paths[1].nodes[10].sigma_banking, 1.5 * result.roads.paths[0].nodes[40].sigma_banking);
}

TEST(Banking, roads_beside_and_above_do_not_count) {
  // A higher road runs beside, 1 m from edge to edge; a bridge passes over.
  const Slope z = [](double, double y) { return y > 103.9 ? 33.0 : 30.0 + bed(y - 100.0, 0.0); };
  RoadPath beside = banked_path(2, straight({0, 107.6}, {400, 107.6}), [](double, double) { return 33.0; });
  const auto result = measure({banked_path(1, straight({0, 100}, {400, 100}), flat), beside}, banked_dtm(z, 1.0, 0.02));
  EXPECT_LT(against(result.roads.paths[0], slope_of, 0.0).mean, 0.006);
}

TEST(Banking, side_road_runs_out_into_the_plane_of_the_main_road) {
  // The main road rises by 6 % to the east and falls by 4 % to the north: going north, the side road leans to its left
  // (west).
  const Slope z = [](double x, double y) { return 30.0 + 0.06 * x - 0.04 * std::clamp(y - 100.0, -half_m, half_m); };
  RoadPath main = banked_path(1, straight({0, 100}, {400, 100}), z, "secondary");
  main.nodes[100].osm_node = 7;
  const auto side = straight({200, 100}, {200, 250});
  const Slope level = [&](double, double y) { return z(200.0, y); };
  for (const bool fine : {true, false}) {
    const HeightGrid dtm =
        banked_dtm([&](double x, double y) { return y > 104.0 ? level(x, y) : z(x, y); }, fine ? 1.0 : 10.0, 0.02);
    const auto paths = measure({main, banked_path(2, side, level, "residential", 7)}, dtm).roads.paths;
    EXPECT_NEAR(slope_of(paths[1].nodes.front()), -0.06, 0.004) << fine;  // the left of north is west, which is lower
    EXPECT_NEAR(slope_of(paths[1].nodes[1]), -0.06, 0.012) << fine;
    EXPECT_NEAR(slope_of(paths[1].nodes[40]), 0.0, 0.01) << fine;
    EXPECT_NEAR(slope_of(paths[0].nodes[100]), fine ? -0.04 : 0.0, 0.005) << "the main road does not care, " << fine;
    for (std::size_t i = 1; i < paths[1].nodes.size(); ++i)
      EXPECT_LT(std::abs(paths[1].nodes[i].banking - paths[1].nodes[i - 1].banking), 0.015) << i;
  }
}

TEST(BankingDesign, side_roads_of_steep_roads_turn_back_without_a_jump) {
  // The main road rises by 19 %: after 20 m the side road still leans by 5 %.
  const Slope z = [](double x, double) { return 30.0 + 0.19 * x; };
  RoadPath main = banked_path(1, straight({0, 100}, {200, 100}), z, "secondary");
  main.nodes[50].osm_node = 7;
  const Slope level = [&](double, double y) { return z(100.0, y); };
  const auto paths =
      design({main, banked_path(2, straight({100, 100}, {100, 250}), level, "residential", 7)}).roads.paths;
  EXPECT_NEAR(slope_of(paths[1].nodes.front()), -0.19, 0.004);
  EXPECT_NEAR(slope_of(paths[1].nodes[40]), 0.0, 1e-3);
  for (std::size_t i = 1; i < paths[1].nodes.size(); ++i)
    EXPECT_LT(std::abs(slope_of(paths[1].nodes[i]) - slope_of(paths[1].nodes[i - 1])), 0.0145) << i;
}

TEST(BankingDesign, planes_beside_each_other_make_no_swing) {
  // Side roads meet a level road 2 m apart: its planes there fall by 0.2 % to the south and 3.1 % to the north.
  const double y0 = 100.0;
  RoadPath main = banked_path(1, straight({0, y0}, {400, y0}), flat, "secondary");
  main.nodes[100].osm_node = 7, main.nodes[101].osm_node = 8;
  const auto north = banked_path(
      2, straight({200, y0}, {200, 200}), [&](double, double y) { return 20.0 + 0.002 * (y - y0); }, "service", 7);
  const auto south = banked_path(
      3, straight({202, y0}, {202, 0}), [&](double, double y) { return 20.0 - 0.031 * (y - y0); }, "service", 8);
  const auto path = design({main, north, south}, {.in_junction_planes = true}).roads.paths[0];
  for (std::size_t i = 0; i < path.nodes.size(); ++i) {
    EXPECT_GT(slope_of(path.nodes[i]), -0.033) << i;
    EXPECT_LT(slope_of(path.nodes[i]), 0.005) << i;
  }
}

TEST(BankingDesign, roads_stay_in_the_plane_of_a_junction_while_they_lie_beside_each_other) {
  // A level side road leaves a bend of 12 m that the design banks by 6 %.
  RoadPath bend = banked_path(1, arc({100, 100}, 12.0, -pi, pi / 2), flat, "tertiary");
  RoadNode& node = bend.nodes[bend.nodes.size() / 2];
  node.osm_node = 7;
  const Vec2 out = normalized(node.p - Vec2{100, 100});
  const auto path = design({bend, banked_path(2, straight(node.p, node.p + out * 60.0), flat, "service", 7)},
                           {.in_junction_planes = true})
                        .roads.paths[0];
  for (const RoadNode& at : path.nodes) {
    const double away_m = std::abs(at.s_m - node.s_m);
    if (away_m > 2.0 * half_m) continue;
    EXPECT_LT(std::abs(slope_of(at)), 0.002 * away_m + 0.003) << away_m;
  }
  EXPECT_GT(std::abs(slope_of(path.nodes[2])), 0.03) << "and is banked further on";
}

TEST(Banking, more_than_roads_have_is_cut_and_reported) {
  const Slope z = [](double, double y) { return 30.0 + bed(y - 100.0, 0.14); };
  const HeightGrid dtm = banked_dtm(z, 1.0, 0.02);
  const auto street = measure({banked_path(1, straight({0, 100}, {300, 100}), z)}, dtm);
  EXPECT_THAT(codes_in_order(street.findings), testing::ElementsAre("elevate.banking_limit"));
  EXPECT_LT(against(street.roads.paths[0], slope_of, 0.08).worst, 1e-9);
  const auto oval = measure({banked_path(1, straight({0, 100}, {300, 100}), z, "raceway")}, dtm);
  EXPECT_TRUE(oval.findings.empty());
  EXPECT_LT(against(oval.roads.paths[0], slope_of, 0.14).mean, 0.004);
}

TEST(Banking, the_first_fine_terrain_with_pixels_counts) {
  const Slope z = [](double, double y) { return 30.0 + bed(y - 100.0, 0.03); };
  const Slope wrong = [](double, double y) { return 30.0 + bed(y - 100.0, -0.06); };
  const std::vector<HeightGrid> dtms{banked_dtm([&](double x, double y) { return x < 200 ? z(x, y) : no_height; }, 1.0),
                                     banked_dtm(wrong, 1.0)};
  const auto nodes =
      estimate_banking(banked_network({banked_path(1, straight({0, 100}, {400, 100}), z)}), dtms).roads.paths[0].nodes;
  EXPECT_NEAR(slope_of(nodes[40]), 0.03, 0.003);
  EXPECT_NEAR(slope_of(nodes[170]), -0.06, 0.003);
}

TEST(Banking, one_thread_equals_many_where_roads_wait_for_others) {
  const Slope z = [](double x, double y) { return 30.0 + 0.16 * (y - 100.0) + 0.05 * std::sin(0.03 * x); };
  const HeightGrid dtm = banked_dtm(z, 1.0, 0.02);
  // Side streets of side streets: each needs the plane of the one before it.
  std::vector<RoadPath> paths{banked_path(1, straight({0, 100}, {400, 100}), z, "primary", 1, 2)};
  const auto join = [&](std::size_t path, std::size_t at, std::int64_t id) { paths[path].nodes[at].osm_node = id; };
  for (int k = 0; k < 6; ++k) {
    join(0, static_cast<std::size_t>(20 + 30 * k), 10 + k);
    const double x = 40.0 + 60.0 * k;
    paths.push_back(banked_path(10 + k, straight({x, 100}, {x, 180}), z, "tertiary", 10 + k, 20 + k));
    join(paths.size() - 1, 20, 30 + k);
    paths.push_back(banked_path(20 + k, straight({x, 140}, {x + 40, 140}), z, "residential", 30 + k, 40 + k));
    join(paths.size() - 1, 10, 50 + k);
    paths.push_back(banked_path(30 + k, straight({x + 20, 140}, {x + 20, 170}), z, "service", 50 + k, 60 + k));
  }
  BankingOptions options{.threads = 1};
  const auto one = measure(paths, dtm, options);
  options.threads = 4;
  const auto four = measure(paths, dtm, options);
  EXPECT_GE(one.findings.size(), 2U);
  ASSERT_EQ(one.findings.size(), four.findings.size());
  for (std::size_t i = 0; i < one.findings.size(); ++i) EXPECT_EQ(one.findings[i].message, four.findings[i].message);
  for (std::size_t p = 0; p < paths.size(); ++p)
    for (std::size_t n = 0; n < paths[p].nodes.size(); ++n) {
      const RoadNode &a = one.roads.paths[p].nodes[n], &b = four.roads.paths[p].nodes[n];
      ASSERT_EQ(a.banking, b.banking) << p << " " << n;
      ASSERT_EQ(a.crown, b.crown) << p << " " << n;
      ASSERT_EQ(a.sigma_banking, b.sigma_banking) << p << " " << n;
    }
  // The service road begins in the plane of the street that it leaves, which waited for two others.
  const RoadNode &street = one.roads.paths[2].nodes[10], &lane = one.roads.paths[3].nodes[0];
  EXPECT_NEAR(std::tan(lane.banking), -street.gradient, 0.01);
}

TEST(Banking, holes_are_bridged_and_long_ones_follow_the_design) {
  const Slope z = [](double, double y) { return 30.0 + bed(y - 100.0, 0.03); };
  const HeightGrid dtm =
      banked_dtm([&](double x, double y) { return (x > 60 && x < 100) || x > 250 ? no_height : z(x, y); }, 1.0, 0.02);
  const auto nodes = measure({banked_path(1, straight({0, 100}, {500, 100}), z)}, dtm).roads.paths[0].nodes;
  EXPECT_EQ(nodes[40].banking_source, BankingSource::interpolated);
  EXPECT_NEAR(slope_of(nodes[40]), 0.03, 0.008);
  EXPECT_EQ(nodes[220].banking_source, BankingSource::design);
  EXPECT_NEAR(slope_of(nodes[220]), 0.0, 0.001);
  EXPECT_NEAR(crown_of(nodes[220]), 0.025, 0.001);
}

// ---- designed

TEST(BankingDesign, straights_have_a_crown_and_one_way_roads_fall_outwards) {
  RoadPath one_way = banked_path(2, straight({0, 200}, {200, 200}), flat, "secondary");
  one_way.oneway = Oneway::forward;
  const auto paths = design({banked_path(1, straight({0, 100}, {200, 100}), flat), one_way,
                             banked_path(3, straight({0, 300}, {200, 300}), flat, "raceway")})
                         .roads.paths;
  EXPECT_LT(against(paths[0], slope_of, 0.0).worst, 1e-6);
  EXPECT_LT(against(paths[0], crown_of, 0.025).worst, 1e-3);
  EXPECT_LT(against(paths[1], slope_of, 0.025).worst, 1e-4) << "the right edge is lower";
  EXPECT_LT(against(paths[1], crown_of, 0.0).worst, 1e-4);
  EXPECT_LT(against(paths[2], slope_of, 0.0).worst, 1e-9);
  EXPECT_LT(against(paths[2], crown_of, 0.0).worst, 1e-9);
  EXPECT_EQ(paths[0].nodes[30].banking_source, BankingSource::design);
  EXPECT_EQ(paths[2].nodes[30].banking_source, BankingSource::none);
  EXPECT_GT(paths[0].nodes[30].sigma_banking, 0.01);
  EXPECT_LT(against(design({one_way}, {.driving_side = DrivingSide::left}).roads.paths[0], slope_of, -0.025).worst,
            1e-4);
}

TEST(BankingDesign, coarse_terrain_does_not_count) {
  const Slope z = [](double, double y) { return 30.0 + bed(y - 100.0, 0.05); };
  const auto nodes =
      measure({banked_path(1, straight({0, 100}, {200, 100}), z)}, banked_dtm(z, 10.0)).roads.paths[0].nodes;
  EXPECT_EQ(nodes[50].banking_source, BankingSource::design);
  EXPECT_EQ(slope_of(nodes[50]), 0.0);
}

TEST(BankingDesign, bends_are_banked_to_the_inside_over_a_gentle_transition) {
  Polyline line = straight({0, 100}, {200, 100});
  const Polyline bend = arc({200, 300}, 200.0, -0.5 * pi, 0.0), out = straight({400, 300}, {400, 500});
  line.insert(line.end(), bend.begin() + 1, bend.end());
  line.insert(line.end(), out.begin() + 1, out.end());
  for (const bool turned : {false, true}) {
    const auto nodes = design({banked_path(1, turned ? reversed(line) : line, flat, "secondary")}).roads.paths[0].nodes;
    const RoadNode& apex = nodes[nodes.size() / 2];
    const double e = curve_banking(curve_rule("secondary"), 1.0 / 200.0);
    EXPECT_GT(e, 0.05);
    EXPECT_NEAR(slope_of(apex), turned ? e : -e, 1e-3);  // left bend: right side higher
    EXPECT_NEAR(crown_of(apex), 0.0, 1e-3);
    EXPECT_NEAR(slope_of(nodes[10]), 0.0, 1e-3);
    EXPECT_NEAR(crown_of(nodes[10]), 0.025, 1e-3);
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      const double run = nodes[i].s_m - nodes[i - 1].s_m;
      EXPECT_LT(std::abs(slope_of(nodes[i]) - slope_of(nodes[i - 1])) / run, 1.3 * 0.0055 / half_m)
          << i;  // Green Book, 70 km/h
      EXPECT_GT(std::abs(slope_of(nodes[i])) + crown_of(nodes[i]), 0.02) << "water runs off, " << i;
    }
  }
}

TEST(BankingDesign, roundabouts_fall_outwards) {
  RoadPath ring = banked_path(1, arc({100, 100}, 15.0, 0.0, 2.0 * pi), flat, "tertiary", 5, 5);
  ring.oneway = Oneway::forward, ring.roundabout = true;
  EXPECT_LT(against(design({ring}).roads.paths[0], slope_of, 0.025).worst, 1e-3);  // left is the island: higher
}

TEST(BankingDesign, curve_banking_agrees_with_the_green_books_tables) {
  // Green Book 2004, exhibit 3-25 and following (e_max 12 %): e in %, radius in feet at 30 and 45 mph.
  const auto e = [](double mph, double feet) {
    return 100.0 * curve_banking({.design_speed_kmh = 1.609344 * mph, .largest = 0.12}, 1.0 / (0.3048 * feet));
  };
  EXPECT_NEAR(e(45, 1035), 8.2, 0.35);
  EXPECT_NEAR(e(45, 806), 10.0, 0.35);
  EXPECT_NEAR(e(45, 682), 11.0, 0.35);
  EXPECT_NEAR(e(30, 470), 8.2, 0.35);
  EXPECT_NEAR(e(30, 333), 10.0, 0.35);
}

TEST(BankingDesign, curve_banking_grows_with_curvature_and_with_friction_balances_the_demand) {
  for (const char* highway : {"motorway", "primary", "tertiary", "residential"}) {
    const CurveRule rule = curve_rule(highway);
    double before = 0.0;
    for (double k = 0.0; k < 0.1; k += 1e-4) {
      const double e = curve_banking(rule, -k);
      EXPECT_GE(e, before - 1e-12) << highway << " " << k;
      EXPECT_LE(e, rule.largest);
      before = e;
    }
    EXPECT_EQ(before, rule.largest);
    EXPECT_EQ(curve_banking(rule, 0.0), 0.0);
  }
  EXPECT_EQ(curve_banking(curve_rule("residential"), 1.0 / 80.0), 0.0) << "side friction does it at 40 km/h";
  EXPECT_EQ(curve_banking(curve_rule("raceway"), 0.02), 0.0);
}

// ---- what must always hold

TEST(Banking, degenerate_ways) {
  RoadPath dot = banked_path(1, {{10, 10}, {10, 10}}, flat),
           loop = banked_path(2, {{50, 50}, {52, 50}}, flat, "service", 8, 8);
  RoadPath pair = banked_path(3, {{90, 90}, {120, 90}}, flat),
           tunnel = banked_path(4, straight({150, 150}, {190, 150}), flat);
  tunnel.tunnel = true;
  RoadPath unknown = banked_path(5, straight({0, 200}, {100, 200}), [](double, double) { return no_height; });
  RoadPath triangle = banked_path(6, {{200, 200}, {230, 200}, {215, 220}, {200, 200}}, flat, "service", 9, 9);
  for (const auto& result : {design({dot, loop, pair, tunnel, unknown, triangle}),
                             measure({dot, loop, pair, tunnel, unknown, triangle}, banked_dtm(flat, 1.0))})
    for (const RoadPath& path : result.roads.paths)
      for (const RoadNode& node : path.nodes) {
        EXPECT_TRUE(std::isfinite(node.banking) && std::isfinite(node.sigma_banking)) << path.osm_id;
        EXPECT_LT(std::abs(node.banking), 0.03) << path.osm_id;
        EXPECT_GE(node.crown, 0.0) << path.osm_id;
      }
}

TEST(Banking, wrong_input_is_refused) {
  HeightGrid other = banked_dtm(flat, 2.0);
  other.crs = {"EPSG:32634"};
  EXPECT_THROW((void)measure({banked_path(1, straight({0, 0}, {50, 0}), flat)}, other), OptionError);
  EXPECT_THROW((void)design({banked_path(1, straight({0, 0}, {50, 0}), flat)}, {.largest_slope = 0.0}), OptionError);
  RoadPath lonely = banked_path(1, straight({0, 0}, {50, 0}), flat);
  lonely.nodes.resize(1);
  EXPECT_THROW((void)design({lonely}), OptionError);
  EXPECT_TRUE(design({}).roads.paths.empty());
}

}  // namespace
}  // namespace orthodrive

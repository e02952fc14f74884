// SPDX-License-Identifier: Apache-2.0
// Heights that somebody knows: they hold where they are, the roads stay smooth, what is far away stays as it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "elevate/test_roads.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/elevate/profiles/estimate_profiles.hpp"

namespace orthodrive {
namespace {

using test::straight_road;
using test::terrain_grid;
using testing::Contains;
using testing::IsEmpty;
using testing::Not;

RoadNetwork roads_of(std::vector<RoadPath> paths) { return {test::road_crs, std::move(paths)}; }

EstimateProfilesResult elevated(const RoadNetwork& roads, const HeightGrid& dtm,
                                std::vector<HeightControlPoint> points) {
  ElevateOptions options;
  options.control_points = std::move(points);
  return estimate_profiles(roads, {dtm}, options);
}

std::vector<std::string> control_codes(const Findings& findings) {
  std::vector<std::string> codes;
  for (const Finding& finding : findings)
    if (finding.code.find("control_point") != std::string::npos) codes.push_back(finding.code);
  return codes;
}

double true_slope(double x) { return 100.0 + 0.02 * x; }

/// The terrain is 1.5 m too low about x = 150, over a length that roads could follow.
double with_a_hollow(double x) {
  const double u = (x - 150.0) / 50.0;
  return true_slope(x) - (std::abs(u) < 1.0 ? 0.75 * (1.0 + std::cos(std::numbers::pi * u)) : 0.0);
}

struct Hollow : testing::Test {
  RoadNetwork roads = roads_of({straight_road(1, {0, 0}, {300, 0})});
  HeightGrid dtm = terrain_grid([](double x, double) { return with_a_hollow(x); }, 2.0);
  static constexpr std::size_t middle = 75;  // x = 150
};

TEST_F(Hollow, one_point_brings_the_height_back_and_leaves_what_is_far_away) {
  const auto before = elevated(roads, dtm, {}), after = elevated(roads, dtm, {{.p = {150, 1}, .z_m = true_slope(150)}});
  const auto &was = before.roads.paths[0].nodes, &is = after.roads.paths[0].nodes;
  EXPECT_LT(was[middle].z_m, true_slope(150) - 1.0) << "the road follows the terrain";
  EXPECT_NEAR(is[middle].z_m, true_slope(150), 0.051);
  EXPECT_LE(is[middle].sigma_z_m, 0.0501);
  EXPECT_TRUE(after.solve.converged);
  double step = 0.0;
  for (std::size_t n = 0; n < is.size(); ++n) {
    if (std::abs(is[n].p.x - 150.0) > 100.0) {
      EXPECT_NEAR(is[n].z_m, was[n].z_m, 0.01) << n;
      EXPECT_NEAR(is[n].sigma_z_m, was[n].sigma_z_m, 1e-3) << n;
    }
    if (n > 0)
      step = std::max(step, std::abs((is[n].z_m - is[n - 1].z_m) / 2.0 - 0.5 * (is[n].gradient + is[n - 1].gradient)));
  }
  EXPECT_LT(step, 0.01) << "no kink at the point";
  EXPECT_THAT(control_codes(after.findings), Contains("elevate.control_point_off_terrain"));
}

TEST_F(Hollow, sigmas_shrink_about_a_point_and_grow_with_its_own) {
  RoadPath bridge = straight_road(2, {100, 0}, {200, 0}, 2, 3);
  bridge.bridge = true, bridge.layer = 1;
  const RoadNetwork bridged =
      roads_of({straight_road(1, {0, 0}, {100, 0}, 1, 2), bridge, straight_road(3, {200, 0}, {300, 0}, 3, 4)});
  constexpr std::size_t mid_deck = 25;
  const auto at = [&](double sigma_m) {
    return elevated(bridged, dtm, {{.p = {150, 0}, .z_m = true_slope(150), .sigma_m = sigma_m}}).roads.paths[1].nodes;
  };
  const auto unknown = elevated(bridged, dtm, {}).roads.paths[1].nodes, good = at(0.02), poor = at(0.2);
  EXPECT_NEAR(good[mid_deck].sigma_z_m, 0.02, 0.001);
  EXPECT_GT(poor[mid_deck].sigma_z_m, 2.0 * good[mid_deck].sigma_z_m);
  EXPECT_LT(poor[mid_deck].sigma_z_m, unknown[mid_deck].sigma_z_m);
  for (std::size_t n = 5; n <= 45; ++n) EXPECT_LT(good[n].sigma_z_m, unknown[n].sigma_z_m) << n;
}

TEST_F(Hollow, points_that_agree_with_the_terrain_say_nothing) {
  const auto result = elevated(roads, dtm, {{.p = {40, -2}, .z_m = true_slope(40)}});
  EXPECT_THAT(control_codes(result.findings), IsEmpty());
}

TEST_F(Hollow, points_that_contradict_each_other_are_told) {
  const auto result =
      elevated(roads, dtm, {{.p = {40, 0}, .z_m = true_slope(40)}, {.p = {41, 0}, .z_m = true_slope(40) + 2.0}});
  EXPECT_THAT(control_codes(result.findings), Contains("elevate.control_point_missed"));
}

TEST_F(Hollow, a_point_beside_the_road_is_left_out) {
  for (const HeightControlPoint& point :
       {HeightControlPoint{.p = {150, 9}, .z_m = 103.0}, HeightControlPoint{.p = {150, 0}, .z_m = 103.0, .osm_id = 77},
        HeightControlPoint{.p = {150, 0}, .z_m = 103.0, .layer = 1}}) {
    const auto result = elevated(roads, dtm, {point});
    EXPECT_THAT(control_codes(result.findings), testing::ElementsAre("elevate.control_point_off_road"));
    EXPECT_EQ(result.roads.paths[0].nodes[middle].z_m, elevated(roads, dtm, {}).roads.paths[0].nodes[middle].z_m);
  }
}

TEST_F(Hollow, other_methods_refuse_control_points) {
  ElevateOptions options{.instead = [](const RoadNetwork&, const NodeHeights& z_m) { return SolvedHeights{z_m}; }};
  options.control_points = {{.p = {150, 0}, .z_m = 103.0}};
  EXPECT_THROW((void)estimate_profiles(roads, {dtm}, options), OptionError);
}

/// A road on a dam, a bridge of way 2 over a valley of 8 m, and way 4 in the valley.
struct Deck : testing::Test {
  Deck() {
    RoadPath bridge = straight_road(2, {130, 0}, {170, 0}, 2, 3);
    bridge.bridge = true, bridge.layer = 1;
    roads = roads_of({straight_road(1, {0, 0}, {130, 0}, 1, 2), bridge, straight_road(3, {170, 0}, {300, 0}, 3, 4),
                      straight_road(4, {150, -40}, {150, 200})});
  }
  [[nodiscard]] static double deck_m(const EstimateProfilesResult& result) {
    return result.roads.paths[1].nodes[10].z_m;
  }
  [[nodiscard]] static double below_m(const EstimateProfilesResult& result) {
    return result.roads.paths[3].nodes[20].z_m;
  }

  RoadNetwork roads;
  HeightGrid dtm = terrain_grid([](double x, double) { return x > 128 && x < 172 ? 22.0 : 30.0; }, 2.0);
};

TEST_F(Deck, its_height_is_corrected_by_the_way_or_the_layer) {
  const auto before = elevated(roads, dtm, {});
  ASSERT_NEAR(deck_m(before), 30.0, 0.2);
  for (const HeightControlPoint& point : {HeightControlPoint{.p = {150, 0}, .z_m = 30.8, .osm_id = 2},
                                          HeightControlPoint{.p = {150, 0}, .z_m = 30.8, .layer = 1}}) {
    const auto after = elevated(roads, dtm, {point});
    EXPECT_NEAR(deck_m(after), 30.8, 0.051);
    EXPECT_NEAR(below_m(after), below_m(before), 0.01) << "the road below stays";
    EXPECT_NEAR(after.roads.paths[0].nodes[10].z_m, before.roads.paths[0].nodes[10].z_m, 0.01) << "x = 20 stays";
    EXPECT_THAT(control_codes(after.findings), IsEmpty());
  }
}

TEST_F(Deck, a_point_of_a_deck_or_the_road_below_is_ambiguous) {
  const auto after = elevated(roads, dtm, {{.p = {150, 0}, .z_m = 30.8}});
  EXPECT_THAT(control_codes(after.findings), testing::ElementsAre("elevate.control_point_ambiguous"));
  EXPECT_EQ(deck_m(after), deck_m(elevated(roads, dtm, {})));
}

TEST_F(Deck, a_point_where_the_deck_ends_on_its_approach_is_not) {
  const auto after = elevated(roads, dtm, {{.p = {130, 0}, .z_m = 30.3}});
  EXPECT_THAT(control_codes(after.findings), Not(Contains("elevate.control_point_ambiguous")));
  EXPECT_NEAR(after.roads.paths[1].nodes.front().z_m, 30.3, 0.06);
}

TEST_F(Deck, a_clearance_lifts_the_deck_and_not_the_road_below) {
  const auto before = elevated(roads, dtm, {}), after = elevated(roads, dtm, {{.p = {150, 0}, .clearance_m = 8.7}});
  EXPECT_NEAR(deck_m(after) - below_m(after), 8.7, 0.051);
  EXPECT_NEAR(below_m(after), below_m(before), 0.1);
  EXPECT_THAT(control_codes(after.findings), IsEmpty());
}

TEST_F(Deck, a_low_clearance_that_was_measured_is_kept_and_told) {
  dtm = terrain_grid([](double x, double) { return x > 128 && x < 172 ? 26.2 : 30.0; }, 2.0);
  EXPECT_GT(deck_m(elevated(roads, dtm, {})) - below_m(elevated(roads, dtm, {})), 4.6) << "raised to 4.7 m";
  const auto measured = elevated(roads, dtm, {{.p = {150, 0}, .clearance_m = 3.9}});
  EXPECT_NEAR(deck_m(measured) - below_m(measured), 3.9, 0.051);
  EXPECT_NEAR(deck_m(elevated(roads, dtm, {{.p = {150, 0}, .z_m = 30.1, .osm_id = 2}})), 30.1, 0.051);
  EXPECT_TRUE(std::any_of(measured.findings.begin(), measured.findings.end(),
                          [](const Finding& f) { return f.code == "elevate.low_clearance"; }));
}

TEST_F(Deck, a_clearance_without_a_crossing_is_left_out) {
  const auto result = elevated(roads, dtm, {{.p = {60, 0}, .clearance_m = 5.0}});
  EXPECT_THAT(control_codes(result.findings), testing::ElementsAre("elevate.control_point_no_crossing"));
}

}  // namespace
}  // namespace orthodrive

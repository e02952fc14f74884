// SPDX-License-Identifier: Apache-2.0
// Roads that part share a cross section as long as they share pavement.
#include "orthodrive/elevate/profiles/parting_roads.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/elevate/profiles/estimate_profiles.hpp"
#include "test_roads.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double parting_slope = 0.05;  // across, per metre along

/// A main road eastwards through a fork at x = 100, and a slip road that leaves it there to one side.
RoadNetwork parting_fork(double side) {
  RoadNetwork roads{test::road_crs, {}};
  roads.paths.push_back(test::straight_road(1, {0.0, 0.0}, {100.0, 0.0}, 10, 20));
  roads.paths.push_back(test::straight_road(1, {100.0, 0.0}, {300.0, 0.0}, 20, 30));
  roads.paths.push_back(test::straight_road(2, {100.0, 0.0}, {300.0, side * 200.0 * parting_slope}, 20, 40));
  for (std::size_t k : {0U, 1U}) roads.paths[k].highway = "primary";
  return roads;
}

std::vector<SharedPavement> shared_of(const RoadNetwork& roads) {
  const PathLinks links = link_path_ends(roads);
  return find_shared_pavement(roads, make_profile_chains(roads, links), find_junctions(roads, links));
}

TEST(PartingRoads, ShareUntilThreeMetresLieBetweenThem) {
  for (const double side : {1.0, -1.0}) {
    const std::vector<SharedPavement> shared = shared_of(parting_fork(side));
    // Half widths of 3 m and a gap of 3 m: 9 m across are reached 180 m after the fork.
    ASSERT_EQ(shared.size(), 36U);
    for (std::size_t i = 0; i < shared.size(); ++i) {
      const double along_m = 5.0 * (static_cast<double>(i) + 1.0);
      EXPECT_NEAR(shared[i].main_s_m, 100.0 + along_m, 1e-9);
      EXPECT_NEAR(shared[i].other_s_m, along_m / std::hypot(1.0, parting_slope), 0.2);
      EXPECT_NEAR(shared[i].left_m, side * along_m * parting_slope, 0.02);
      EXPECT_EQ(shared[i].main_path, 1U);
    }
  }
}

TEST(PartingRoads, TellTheSideInTheDirectionOfTheMainPath) {
  RoadNetwork roads = parting_fork(1.0);
  auto& nodes = roads.paths[1].nodes;
  std::reverse(nodes.begin(), nodes.end());
  for (RoadNode& node : nodes) node.s_m = 200.0 - node.s_m;
  for (const SharedPavement& place : shared_of(roads)) EXPECT_LT(place.left_m, 0.0);
}

TEST(PartingRoads, ShareNothingOfAnotherLevelNorSideways) {
  RoadNetwork roads = parting_fork(1.0);
  roads.paths.push_back(test::straight_road(2, roads.paths[2].nodes[20].p, roads.paths[2].nodes.back().p, 41, 40));
  roads.paths[2].nodes.resize(21);
  roads.paths[2].nodes.back().osm_node = 41;
  roads.paths[3].layer = 1;
  EXPECT_NEAR(static_cast<double>(shared_of(roads).size()), 8.0, 1.0);  // 40 m of the slip road are left

  roads = parting_fork(1.0);
  roads.paths[2] = test::straight_road(2, {100.0, 0.0}, {100.0, 200.0}, 20, 40);
  EXPECT_TRUE(shared_of(roads).empty());
}

/// Two decks over a valley: the main road goes on level, the slip road comes down by 8 m. The terrain tells of both
/// ends alone.
TEST(PartingRoads, LieInOneCrossSectionWhereTheTerrainIsSilent) {
  RoadNetwork roads = parting_fork(1.0);
  for (std::size_t k : {1U, 2U}) {
    RoadPath& path = roads.paths[k];
    path.bridge = true, path.layer = 1;
    path.highway = k == 1 ? "primary" : "primary_link";
  }
  const HeightGrid terrain = test::terrain_grid(
      [](double x, double y) { return x < 100.0   ? 20.0
                                      : x < 290.0 ? 0.0
                                      : y < 5.0   ? 20.0
                                                  : 12.0; }, 1.0);
  roads.paths.push_back(test::straight_road(1, {300.0, 0.0}, {340.0, 0.0}, 30, 50));
  roads.paths.push_back(test::straight_road(2, {300.0, 10.0}, {340.0, 12.0}, 40, 60));
  const EstimateProfilesResult result = estimate_profiles(roads, {terrain}, {}, nullptr);
  const auto& main = result.roads.paths[1].nodes;
  const auto& slip = result.roads.paths[2].nodes;
  double worst = 0.0;
  for (std::size_t n = 0; n < slip.size(); ++n) {
    const double across_m = slip[n].p.y;
    if (across_m < 6.0) worst = std::max(worst, std::abs(slip[n].z_m - main[n].z_m) / (across_m + 0.5));
  }
  EXPECT_LT(worst, 0.1) << "slope across the pavement";
  EXPECT_LT(slip.back().z_m, 14.0);
}

}  // namespace
}  // namespace orthodrive::elevate

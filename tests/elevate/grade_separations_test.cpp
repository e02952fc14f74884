// SPDX-License-Identifier: Apache-2.0
// Which road passes over the other, and where the terrain is the road.

#include "orthodrive/elevate/terrain/grade_separations.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "test_roads.hpp"

namespace orthodrive::elevate {
namespace {

using test::straight_road;

/// Two roads of 200 m that cross at (100, 100): path 0 to the east, path 1 to the north.
RoadNetwork crossing() {
  return {test::road_crs, {straight_road(1, {0, 100}, {200, 100}), straight_road(2, {100, 0}, {100, 200})}};
}

struct Found {
  std::vector<GradeSeparation> levels;
  Findings findings;
  std::vector<Span> spans;
};

Found find(
    const RoadNetwork& roads, const std::function<double(double, double)>& z = [](double, double) { return 50.0; }) {
  Found found;
  const TerrainSamples terrain = sample_terrain(roads, {test::terrain_grid(z, 2.0)}, HeightSampling::cubic, 1);
  found.levels = find_grade_separations(roads, terrain, found.findings);
  found.spans = untagged_spans(roads, found.levels);
  return found;
}

MATCHER_P(HasCode, code, "") { return arg.code == code; }

TEST(GradeSeparations, layer_then_bridge_then_tunnel_decide) {
  RoadNetwork roads = crossing();
  roads.paths[0].layer = 1, roads.paths[1].bridge = true;
  Found found = find(roads);
  ASSERT_EQ(found.levels.size(), 1U);
  EXPECT_EQ(found.levels[0].upper(), 0U) << "the layer counts more than the tag";
  roads = crossing();
  roads.paths[1].bridge = true;
  found = find(roads);
  EXPECT_EQ(found.levels[0].upper(), 1U);
  EXPECT_TRUE(found.levels[0].raise && !found.levels[0].untagged);
  EXPECT_THAT(found.spans, testing::IsEmpty());
  EXPECT_THAT(found.findings, testing::IsEmpty());
  roads = crossing();
  roads.paths[1].tunnel = true;
  found = find(roads);
  EXPECT_EQ(found.levels[0].upper(), 0U);
  EXPECT_FALSE(found.levels[0].raise) << "the tunnel gives way";
}

TEST(GradeSeparations, the_terrain_dips_below_the_upper_road) {
  // Path 0 runs in a cutting of 3 m below y = 90 .. 110: bare earth below the deck of path 1.
  const Found found = find(crossing(), [](double, double y) { return std::abs(y - 100.0) < 8.0 ? 47.0 : 50.0; });
  ASSERT_EQ(found.levels.size(), 1U);
  EXPECT_EQ(found.levels[0].upper(), 1U);
  EXPECT_TRUE(found.levels[0].untagged);
  EXPECT_THAT(found.findings, testing::ElementsAre(HasCode("elevate.assumed_bridge")));
  ASSERT_EQ(found.spans.size(), 1U);
  EXPECT_EQ(found.spans[0].path, 1U);
  EXPECT_NEAR(found.spans[0].s_m, 100.0, 1e-6);
  EXPECT_NEAR(found.spans[0].half_length_m, 3.0 + 1.5, 1e-6) << "half of the lower road and a quarter of the upper";
}

TEST(GradeSeparations, without_any_hint_it_is_a_missing_junction_but_never_on_a_motorway) {
  Found found = find(crossing());
  EXPECT_THAT(found.levels, testing::IsEmpty());
  EXPECT_THAT(found.findings, testing::ElementsAre(HasCode("elevate.missing_junction")));
  RoadNetwork roads = crossing();
  roads.paths[0].highway = "motorway";
  found = find(roads);
  ASSERT_EQ(found.levels.size(), 1U);
  EXPECT_EQ(found.levels[0].upper(), 1U) << "the less important road passes over";
}

TEST(GradeSeparations, an_end_that_reaches_over_a_road_is_a_missing_junction) {
  RoadNetwork roads = crossing();
  roads.paths[1] = straight_road(2, {100, 0}, {100, 106});  // half width 3 m and 5 m beyond
  const auto cutting = [](double, double y) { return std::abs(y - 100.0) < 8.0 ? 47.0 : 50.0; };
  EXPECT_THAT(find(roads, cutting).levels, testing::IsEmpty());
  roads.paths[1] = straight_road(2, {100, 0}, {100, 112});
  EXPECT_THAT(find(roads, cutting).levels, testing::SizeIs(1));
}

TEST(GradeSeparations, roads_that_meet_within_50_m_along_the_network_overlap_only) {
  // Path 1 leaves path 0 at x = 70 and its line crosses back over it 30 m on.
  RoadNetwork roads{test::road_crs,
                    {straight_road(1, {0, 100}, {200, 100}), straight_road(2, {70, 100}, {80, 103}, 9)}};
  roads.paths[0].nodes[35].osm_node = 9;
  RoadPath back = straight_road(2, {80, 103}, {130, 90});
  for (std::size_t i = 1; i < back.nodes.size(); ++i) roads.paths[1].nodes.push_back(back.nodes[i]);
  EXPECT_THAT(find(roads).levels, testing::IsEmpty());
  EXPECT_THAT(find(roads).findings, testing::IsEmpty());
  roads.paths[1].bridge = true;
  const Found tagged = find(roads);
  ASSERT_EQ(tagged.levels.size(), 1U);
  EXPECT_FALSE(tagged.levels[0].has_room) << "tagged, but no ramp gains the clearance on so little";
}

TEST(GradeSeparations, decks_above_each_other_are_found_along_their_length) {
  RoadNetwork roads{test::road_crs,
                    {straight_road(1, {0, 100}, {200, 100}, 1, 2), straight_road(2, {0, 103}, {200, 103}, 3, 4)}};
  EXPECT_THAT(find(roads).levels, testing::IsEmpty()) << "one level";
  roads.paths[0].bridge = roads.paths[1].bridge = true;
  roads.paths[0].layer = 1, roads.paths[1].layer = 2;
  const Found decks = find(roads);
  ASSERT_EQ(decks.levels.size(), 21U) << "every 10 m";
  for (const GradeSeparation& level : decks.levels) {
    EXPECT_TRUE(level.is_along && level.has_room && level.raise && !level.untagged);
    EXPECT_EQ(level.upper(), 1U);
  }
  roads.paths[1] = straight_road(2, {0, 106.5}, {200, 106.5}, 3, 4);
  roads.paths[1].layer = 2;
  EXPECT_THAT(find(roads).levels, testing::IsEmpty()) << "beside each other";
}

TEST(GradeSeparations, a_tunnel_under_a_street_gives_way_and_roads_that_part_do_not) {
  RoadNetwork roads{test::road_crs,
                    {straight_road(1, {0, 100}, {200, 100}, 1, 2), straight_road(2, {0, 102}, {200, 102}, 3, 4)}};
  roads.paths[1].tunnel = true, roads.paths[1].layer = -1;
  const Found street = find(roads);
  ASSERT_EQ(street.levels.size(), 21U);
  EXPECT_FALSE(street.levels[0].raise);
  EXPECT_EQ(street.levels[0].upper(), 0U);
  // A slip road leaves a bridge at 4 degrees: the carriageways overlap for 70 m.
  roads.paths = {straight_road(1, {0, 100}, {200, 100}, 1, 2), straight_road(2, {0, 100}, {199.5, 114}, 1, 4)};
  roads.paths[0].bridge = true, roads.paths[0].layer = 1;
  EXPECT_THAT(find(roads).levels, testing::IsEmpty());
}

TEST(TerrainSamples, the_first_model_with_a_height_counts) {
  const RoadNetwork roads{test::road_crs, {straight_road(1, {0, 100}, {200, 100})}};
  HeightGrid fine = test::terrain_grid([](double, double) { return 10.0; }, 2.0);
  for (int row = 0; row < fine.frame.height; ++row)
    for (int col = fine.frame.width / 2; col < fine.frame.width; ++col) fine.height_m.at(col, row) = NAN;
  const HeightGrid coarse = test::terrain_grid([](double x, double) { return 20.0 + 0.1 * x; }, 10.0);
  const TerrainSamples terrain = sample_terrain(roads, {fine, coarse}, HeightSampling::cubic, 1);
  EXPECT_EQ(terrain.of_node[0][10].source, 0);
  EXPECT_NEAR(terrain.of_node[0][10].z_m, 10.0, 1e-6);
  EXPECT_EQ(terrain.of_node[0][95].source, 1);
  EXPECT_NEAR(terrain.of_node[0][95].z_m, 39.0, 1e-4);
  EXPECT_EQ(terrain.coarsest_gsd_m, 10.0);
  const RoadNetwork far{test::road_crs, {straight_road(1, {9000, 100}, {9200, 100})}};
  EXPECT_THROW((void)sample_terrain(far, {fine, coarse}, HeightSampling::cubic, 1), OptionError);
}

TEST(TerrainSamples, structures_and_the_terrain_beside_them_are_left_out_and_bridged_by_a_line) {
  RoadNetwork roads{test::road_crs,
                    {straight_road(1, {0, 100}, {80, 100}, 1, 2), straight_road(2, {80, 100}, {120, 100}, 2, 3),
                     straight_road(3, {120, 100}, {200, 100}, 3, 4)}};
  roads.paths[1].bridge = true;
  TerrainSamples terrain = sample_terrain(
      roads,
      {test::terrain_grid([](double x, double) { return 50.0 + 0.02 * x - (x > 84 && x < 116 ? 8.0 : 0.0); }, 2.0)},
      HeightSampling::bilinear, 1);
  leave_out_structures(roads, {{.path = 2, .s_m = 50.0, .half_length_m = 4.0}}, terrain);
  for (const TerrainSample& sample : terrain.of_node[1]) EXPECT_FALSE(sample.is_road);
  for (std::size_t n = 0; n < roads.paths[0].nodes.size(); ++n)
    EXPECT_EQ(terrain.of_node[0][n].is_road, roads.paths[0].nodes[n].s_m < 75.0) << "5 m before the bridge";
  for (std::size_t n = 0; n < roads.paths[2].nodes.size(); ++n) {
    const double s = roads.paths[2].nodes[n].s_m;
    EXPECT_EQ(terrain.of_node[2][n].is_road, s > 5.0 && std::abs(s - 50.0) > 9.0) << s;
  }
  const auto start = start_heights(roads, terrain);
  EXPECT_NEAR(start[0][20], 50.8, 1e-3);
  EXPECT_NEAR(start[2][25], 50.0 + 0.02 * 170.0, 0.01) << "linear across the span";
}

}  // namespace
}  // namespace orthodrive::elevate

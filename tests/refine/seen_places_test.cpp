// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/seen_places.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive {
namespace {

/// A way from west to east, `length` long.
RoadNetwork straight_roads(double length) {
  RoadPath path;
  path.osm_id = 1;
  path.highway = "residential";
  for (double x = 0.0; x <= length; x += 10.0) path.nodes.push_back({.p = {x, 0.0}, .s_m = x, .width_m = 6.0});
  path.nodes.front().osm_node = 11, path.nodes.back().osm_node = 12;
  RoadNetwork roads;
  roads.crs = {"EPSG:32633"};
  roads.paths.push_back(path);
  return roads;
}

RoadAlignment told(double length, Vec2 displacement, double sigma, double half_width) {
  RoadAlignment alignment(1);
  for (const double s : places_along(length)) alignment[0].push_back({s, {displacement, sigma, half_width, sigma}});
  return alignment;
}

TEST(SeenPlaces, LieAcrossTheChainWhicheverWayItRuns) {
  const RoadNetwork roads = straight_roads(100.0);
  RoadChain chain = build_chains(roads, {}).front();
  const RoadAlignment alignment = told(100.0, {0.7, 1.5}, 0.4, 3.5);
  for (const bool turned : {false, true}) {
    if (turned) {
      std::reverse(chain.nodes.begin(), chain.nodes.end());
      for (ChainNode& node : chain.nodes) node.s_m = 100.0 - node.s_m, node.normal = node.normal * -1.0;
      chain.pieces.front().reversed = !chain.pieces.front().reversed;
    }
    const auto seen = refine::seen_on_chain(chain, alignment);
    ASSERT_EQ(seen.size(), chain.nodes.size());
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_NEAR(seen[i].offset_m, 1.5 * chain.nodes[i].normal.y, 1e-9);
      EXPECT_NEAR(seen[i].width_m, 7.0, 1e-9);
      EXPECT_NEAR(seen[i].sigma_width_m, 0.8, 1e-9);
    }
  }
}

TEST(SeenPlaces, TakeTheNearestPlaceAndNoneFarAway) {
  const RoadChain chain = build_chains(straight_roads(100.0), {}).front();
  RoadAlignment alignment(1);
  for (double s = 0.0; s <= 50.0; s += 2.0) alignment[0].push_back({s, {{0.0, s}, 0.5, 3.0, 0.5}});
  const auto seen = refine::seen_on_chain(chain, alignment);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (chain.nodes[i].s_m < 50.0)
      EXPECT_NEAR(std::abs(seen[i].offset_m), chain.nodes[i].s_m, 1.01);
    else if (chain.nodes[i].s_m > 53.5)
      EXPECT_EQ(seen[i].sigma_m, 0.0);
  }
  EXPECT_TRUE(refine::seen_on_chain(chain, {}).empty());
  EXPECT_TRUE(refine::seen_on_chain(chain, RoadAlignment(1)).empty());
}

TEST(SeenPlaces, MoveARoadThatNoLabelShows) {
  const RoadNetwork roads = straight_roads(200.0);
  RoadEvidence nothing{roads.crs, {-50.0, 50.0, 0.5, 600, 200}, {}, {}};
  nothing.outside = nothing.inside = Raster<std::uint8_t>(600, 200);
  const auto refined = [&](const RoadAlignment& alignment) {
    return refine_roads(roads, nothing, {}, nullptr, {}, alignment).roads.paths.front();
  };
  const RoadPath kept = refined({}), moved = refined(told(200.0, {0.0, 2.0}, 0.3, 4.0)),
                 doubted = refined(told(200.0, {0.0, 2.0}, 30.0, 4.0));
  for (std::size_t i = 5; i + 5 < kept.nodes.size(); ++i) {
    EXPECT_NEAR(kept.nodes[i].offset_m, 0.0, 0.05);
    EXPECT_NEAR(moved.nodes[i].offset_m, 2.0, 0.2);
    EXPECT_LT(std::abs(doubted.nodes[i].offset_m), 0.5);
    EXPECT_GT(moved.nodes[i].width_m, kept.nodes[i].width_m + 0.5);
    EXPECT_LT(moved.nodes[i].sigma_offset_m, kept.nodes[i].sigma_offset_m);
  }
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/parallel_roads.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace orthodrive::refine {
namespace {

constexpr std::size_t nodes = 11, middle = 5;

/// Two roads that run east, the second one 6 m north of the first, both 5 m wide on the map.
struct TwoRoads {
  std::vector<RoadChain> chains{road(0.0), road(6.0)};
  std::vector<ChainShape> shapes{shape(5.0), shape(5.0)};
  std::vector<std::vector<Neighbour>> neighbours = find_neighbours(chains, network());

  static RoadChain road(double y) {
    RoadChain chain;
    for (std::size_t i = 0; i < nodes; ++i) {
      const double s = 2.0 * static_cast<double>(i);
      chain.nodes.push_back({.base = {s, y}, .normal = {0.0, 1.0}, .s_m = s, .input_width_m = 5.0});
    }
    chain.pieces.push_back({.path = y > 0.0 ? 1u : 0u, .first = 0, .last = nodes - 1});
    return chain;
  }
  static ChainShape shape(double width_m) {
    return {.offset_m = std::vector<double>(nodes, 0.0), .width_m = std::vector<double>(nodes, width_m)};
  }
  static RoadNetwork network() {
    RoadNetwork osm;
    osm.paths.resize(2);
    return osm;
  }
  [[nodiscard]] Occupied of(std::size_t chain) const {
    for (const Occupied& o : occupied_by_neighbours(chain, chains, neighbours, shapes))
      if (o.node == middle) return o;
    ADD_FAILURE() << "no neighbour of road " << chain;
    return {};
  }
};

TEST(ParallelRoads, border_lies_half_way_where_both_edges_stray_alike) {
  TwoRoads roads;
  roads.shapes = {TwoRoads::shape(8.0), TwoRoads::shape(8.0)};
  EXPECT_NEAR(roads.of(0).overlap_m, 2.0, 1e-9);
  EXPECT_NEAR(roads.of(0).share, 0.5, 1e-9);
  EXPECT_NEAR(borders_of_fit({roads.of(0)})[0].edge_m, 3.0, 1e-9);
  EXPECT_NEAR(limits_of({roads.of(0)})[0].edge_m, 3.0, 1e-9);
}

/// A carriageway whose labels hold the hatched area beside it, too, must not push its slip road off its surface.
TEST(ParallelRoads, who_grew_over_the_other_road_gives_the_overlap_up) {
  TwoRoads roads;
  roads.shapes[0] = TwoRoads::shape(11.0);  // its left edge at 5.5, 2 m in the other road, which begins at 3.5
  const Occupied grown = roads.of(0), other = roads.of(1);
  EXPECT_NEAR(grown.overlap_m, 2.0, 1e-9);
  EXPECT_GT(grown.share, 0.95);
  EXPECT_LT(other.share, 0.05);
  EXPECT_NEAR(borders_of_fit({grown})[0].edge_m, 3.5, 0.1);
  // both see one border: that of the other road is told along its own normal, from 6 m further north
  EXPECT_NEAR(6.0 + borders_of_fit({other})[0].edge_m, borders_of_fit({grown})[0].edge_m, 1e-9);
}

/// Only what leads to the other road counts: a road that has moved away from it has not strayed into it.
TEST(ParallelRoads, moving_away_from_the_other_road_is_no_straying_into_it) {
  TwoRoads roads;
  roads.shapes[0] = TwoRoads::shape(11.0);
  roads.shapes[1].offset_m[middle] = 0.5;  // north, away from the first
  EXPECT_GT(roads.of(0).share, 0.95);
  roads.shapes[1].offset_m[middle] = -0.5;
  EXPECT_NEAR(roads.of(0).share, 3.1 / (3.1 + 0.6), 1e-9);
}

TEST(ParallelRoads, roads_apart_are_held_half_way_between_their_edges) {
  TwoRoads roads;
  roads.shapes[0] = TwoRoads::shape(6.4);  // edges at 3.2 and 3.5
  EXPECT_NEAR(limits_of({roads.of(0)})[0].edge_m, 3.35, 1e-9);
  EXPECT_NEAR(borders_of_fit({roads.of(0)})[0].edge_m, 3.5, 1e-9);
}

}  // namespace
}  // namespace orthodrive::refine

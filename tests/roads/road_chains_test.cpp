// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/road_chains.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "orthodrive/roads/ring_paths.hpp"

namespace orthodrive {
namespace {

using Nodes = std::vector<std::pair<Vec2, std::int64_t>>;

RoadPath way(const Nodes& nodes, double width_m = 6.0) {
  RoadPath path;
  path.highway = "residential";
  for (const auto& [p, id] : nodes) path.nodes.push_back({.p = p, .osm_node = id, .width_m = width_m});
  return path;
}

std::vector<RoadChain> masked_chains(const RoadNetwork& roads) {
  std::vector<RoadChain> chains = build_chains(roads, {});
  mask_evidence(chains, roads);
  return chains;
}

/// The evidence of the first chain near a distance along it.
EdgeEvidence evidence_at(const std::vector<RoadChain>& chains, double s_m) {
  const RoadChain& chain = chains.front();
  std::size_t i = 0;
  while (i + 2 < chain.nodes.size() && chain.nodes[i + 1].s_m <= s_m) ++i;
  return chain.nodes[i].evidence;
}

/// A street of 200 m to the east with a node of its own at 100 m, and what joins it there.
RoadNetwork street_with(std::vector<RoadPath> others) {
  RoadNetwork roads;
  roads.paths.push_back(way({{{0, 0}, 1}, {{100, 0}, 2}, {{200, 0}, 3}}));
  for (RoadPath& other : others) roads.paths.push_back(std::move(other));
  return roads;
}

TEST(MaskEvidence, the_edge_across_from_a_mouth_counts) {
  const auto chains = masked_chains(street_with({way({{{100, 0}, 2}, {{100, 80}, 4}})}));
  ASSERT_EQ(chains.size(), 2U);
  for (const double s_m : {95.0, 100.0, 105.0}) {
    EXPECT_EQ(evidence_at(chains, s_m).left, 0.0) << s_m;
    EXPECT_EQ(evidence_at(chains, s_m).right, 1.0) << s_m;
    EXPECT_EQ(evidence_at(chains, s_m).both(), 0.0) << s_m;
  }
  for (const double s_m : {85.0, 115.0}) EXPECT_EQ(evidence_at(chains, s_m).both(), 1.0) << s_m;
  EXPECT_EQ(chains[1].nodes.front().evidence.left, 0.0) << "the mouth opens to both sides";
  EXPECT_EQ(chains[1].nodes.front().evidence.right, 0.0);
  const auto from_below = masked_chains(street_with({way({{{100, -80}, 4}, {{100, 0}, 2}})}));
  EXPECT_EQ(evidence_at(from_below, 100.0).left, 1.0);
  EXPECT_EQ(evidence_at(from_below, 100.0).right, 0.0);
}

TEST(MaskEvidence, neither_edge_counts_where_a_road_passes_or_leaves_along_the_street) {
  const auto passed = masked_chains(street_with({way({{{100, -80}, 4}, {{100, 0}, 2}, {{100, 80}, 5}})}));
  const auto along = masked_chains(street_with({way({{{100, 0}, 2}, {{180, 14}, 4}})}));
  const auto bridge = masked_chains(street_with({way({{{100, -80}, 4}, {{100, 80}, 5}})}));  // no node in common
  for (const auto* chains : {&passed, &along, &bridge}) {
    EXPECT_EQ(evidence_at(*chains, 100.0).left, 0.0);
    EXPECT_EQ(evidence_at(*chains, 100.0).right, 0.0);
  }
}

/// Driven round to the left: its island is to the left. Arms leave it straight on from where they came.
RoadNetwork roundabout(double radius_m, int arms) {
  RoadNetwork roads;
  const auto corner = [&](double turn) {
    return Vec2{radius_m * std::cos(2.0 * std::numbers::pi * turn), radius_m * std::sin(2.0 * std::numbers::pi * turn)};
  };
  constexpr int corners = 6;  // of a part
  for (int arm = 0; arm < arms; ++arm) {
    Nodes nodes;
    for (int k = 0; k <= corners; ++k)
      nodes.emplace_back(corner((arm + static_cast<double>(k) / corners) / arms), k == 0         ? 1 + arm
                                                                                  : k == corners ? 1 + (arm + 1) % arms
                                                                                                 : 0);
    roads.paths.push_back(way(nodes, 4.25));
    roads.paths.back().oneway = Oneway::forward;
    roads.paths.back().roundabout = true;
    roads.paths.back().width_source = WidthSource::lanes;
  }
  for (int arm = 0; arm < arms; ++arm) {
    const double turn = static_cast<double>(arm) / arms;
    const Vec2 at = corner(turn), along = left_normal(normalized(at));
    roads.paths.push_back(way({{at, 1 + arm}, {at + normalized(at) * 20.0 - along * 40.0, 100 + arm}}, 4.0));
  }
  return roads;
}

TEST(RoadChains, a_ring_is_one_closed_road_though_its_arms_run_straighter) {
  const RoadNetwork roads = roundabout(12.0, 4);
  const auto chains = masked_chains(roads);
  ASSERT_EQ(chains.size(), 5U);
  ASSERT_TRUE(chains.front().closed);
  EXPECT_EQ(chains.front().pieces.size(), 4U);
  int outer = 0;
  for (const ChainNode& node : chains.front().nodes) {
    EXPECT_EQ(node.evidence.left, 1.0) << "nothing joins from the island";
    outer += node.evidence.right > 0.0;
    EXPECT_NEAR(node.input_width_m, usual_ring_width_m(2.0 * std::numbers::pi * 12.0), 0.02) << "lanes say nothing";
  }
  EXPECT_GT(outer, 4);
  EXPECT_LT(outer, static_cast<int>(chains.front().nodes.size()) - 8);
}

TEST(RingPaths, widths_follow_the_outer_diameter) {
  const auto of_diameter = [](double outer_m, double width_m) {
    return usual_ring_width_m(std::numbers::pi * (outer_m - width_m));
  };
  EXPECT_NEAR(of_diameter(30.0, 6.0), 6.0, 1e-9);
  EXPECT_NEAR(of_diameter(35.0, 5.25), 5.25, 1e-9);
  EXPECT_GT(of_diameter(26.0, 6.75), of_diameter(18.0, 5.0));
  EXPECT_EQ(usual_ring_width_m(1.0), 4.0);
  EXPECT_EQ(usual_ring_width_m(1000.0), 4.875);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// Ways cut into pieces, pieces joined to chains: small networks drawn by hand.

#include "orthodrive/network/topology/topology.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "network_support.hpp"

namespace orthodrive::network {
namespace {

using orthodrive::network_test::circle_points;
using orthodrive::network_test::make_path;
using orthodrive::network_test::network_of;
using orthodrive::network_test::site_origin;

struct Built {
  Topology topology;
  Findings findings;
};
Built build(std::vector<RoadPath> paths, DrivingSide driving_side = DrivingSide::right) {
  Built built;
  built.topology = build_topology(network_of(std::move(paths)), driving_side, built.findings);
  return built;
}

/// Chains as text: pieces in order, "-" where they are passed against their way, "o" for closed ones.
std::string told(const Topology& topology) {
  std::string text;
  for (const Chain& chain : topology.chains) {
    for (const DirectedPiece part : chain.pieces)
      text += (part.reversed ? "-" : "") + std::to_string(part.piece.value()) + " ";
    text += chain.closed ? "o " : "| ";
  }
  return text;
}

const Vertex& vertex_of(const Topology& topology, std::int64_t osm_node) {
  return *std::find_if(topology.vertices.begin(), topology.vertices.end(),
                       [&](const Vertex& v) { return v.osm_node == osm_node; });
}

void expect_every_piece_once(const Topology& topology) {
  Table<PieceIndex, int> seen(topology.pieces.size(), 0);
  for (const Chain& chain : topology.chains) {
    for (const DirectedPiece part : chain.pieces) ++seen[part.piece];
    for (std::size_t k = 0; k + 1 < chain.pieces.size(); ++k)
      EXPECT_EQ(end_vertex(topology, chain.pieces[k]), start_vertex(topology, chain.pieces[k + 1]));
    if (chain.closed) {
      EXPECT_EQ(end_vertex(topology, chain.pieces.back()), start_vertex(topology, chain.pieces.front()));
    }
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
}

TEST(Topology, a_passing_way_is_cut_and_runs_on) {
  const auto [topology, findings] =
      build({make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3}), make_path({{0, 0}, {5, 60}}, {2, 4}, {.osm_id = 2})});
  ASSERT_EQ(topology.pieces.size(), 3u);
  EXPECT_EQ(told(topology), "0 1 | 2 | ");
  const PathPiece& second = topology.pieces[PieceIndex(1)];
  EXPECT_EQ(second.path, 0u);
  EXPECT_EQ(second.first, 30u);
  EXPECT_EQ(second.last, 60u);
  const Vertex& middle = vertex_of(topology, 2);
  EXPECT_TRUE(middle.is_junction());
  ASSERT_EQ(middle.ends.size(), 3u);
  EXPECT_EQ(middle.ends[0], (PieceEnd{PieceIndex(0), true}));
  EXPECT_EQ(middle.ends[1], (PieceEnd{PieceIndex(1), false}));
  EXPECT_LT(distance(middle.p, site_origin), 1e-9);
  EXPECT_FALSE(vertex_of(topology, 1).is_junction());
  expect_every_piece_once(topology);
  EXPECT_TRUE(findings.empty());
}

TEST(Topology, pieces_without_a_length_end_the_walk_round_a_ring) {
  // One-way pieces between nodes of one place lead round and round beside the beginning; each loop is as short as none.
  std::vector<RoadPath> paths{make_path({{-60, 0}, {0, 0}}, {1, 2}, {.osm_id = 1, .oneway = Oneway::forward})};
  for (const auto& [from, to] : {std::pair{2, 3}, std::pair{3, 4}, std::pair{4, 3}, std::pair{4, 2}}) {
    RoadPath path = make_path({{0, 0}, {1, 0}}, {from, to}, {.osm_id = 10 * from + to, .oneway = Oneway::forward});
    for (RoadNode& node : path.nodes) node.p = site_origin, node.s_m = 0.0;
    paths.push_back(path);
  }
  const auto [topology, findings] = build(paths);
  for (const int ring : topology.ring_of_piece) EXPECT_EQ(ring, -1);
}

TEST(Topology, a_way_goes_before_a_straighter_other_one) {
  // The way bends by 30 degrees at the junction; another way would go straight on.
  const auto built =
      build({make_path({{-60, 0}, {0, 0}, {52, 30}}, {1, 2, 3}), make_path({{0, 0}, {60, 0}}, {2, 4}, {.osm_id = 2})});
  EXPECT_EQ(told(built.topology), "0 1 | 2 | ");
  // Bending by 45 degrees it does not run on: the other way takes its place.
  const auto sharp =
      build({make_path({{-60, 0}, {0, 0}, {42, 42}}, {1, 2, 3}), make_path({{0, 0}, {60, 0}}, {2, 4}, {.osm_id = 2})});
  EXPECT_EQ(told(sharp.topology), "0 2 | 1 | ");
}

TEST(Topology, two_ends_alone_run_on_but_where_the_road_turns_back) {
  const auto two_ways = [](Vec2 from, Oneway oneway, bool into) {
    std::vector<Vec2> corners{from, {60, 0}};
    std::vector<std::int64_t> ids{3, 2};
    if (!into) std::ranges::reverse(corners), std::ranges::reverse(ids);
    return build({make_path({{0, 0}, {60, 0}}, {1, 2}, {.oneway = oneway}),
                  make_path(corners, ids, {.osm_id = 2, .oneway = oneway})});
  };
  const auto bends = two_ways({20, 30}, Oneway::no, true);
  EXPECT_EQ(told(bends.topology), "0 -1 | ");
  EXPECT_FALSE(vertex_of(bends.topology, 2).is_junction());
  const auto turns = two_ways({0, 5}, Oneway::forward, false);
  EXPECT_EQ(told(turns.topology), "0 | 1 | ");
  EXPECT_TRUE(vertex_of(turns.topology, 2).is_junction()) << "its connecting road turns";
  const auto ends = two_ways({0, 5}, Oneway::forward, true);
  EXPECT_EQ(told(ends.topology), "0 | 1 | ");
  EXPECT_FALSE(vertex_of(ends.topology, 2).is_junction()) << "two one-way roads that end there";
}

TEST(Topology, lanes_that_shift_make_a_junction_of_two_ends) {
  const auto built = build({make_path({{-60, 0}, {0, 0}}, {1, 2}),
                            make_path({{0, 0}, {60, 0}}, {2, 3}, {.osm_id = 2, .oneway = Oneway::forward})});
  EXPECT_TRUE(vertex_of(built.topology, 2).is_junction());
  EXPECT_EQ(told(built.topology), "0 1 | ") << "the chain runs on all the same";
}

TEST(Topology, a_closed_chain_begins_at_its_junction) {
  // A block drawn from corner 1; the road into it arrives in the middle of a side, at node 5.
  const std::vector<RoadPath> block{
      make_path({{0, 0}, {30, -8}, {60, 0}, {68, 30}, {60, 60}, {30, 68}, {0, 60}, {-8, 30}, {0, 0}},
                {1, 0, 0, 5, 0, 0, 0, 0, 1}),
      make_path({{68, 30}, {150, 30}}, {5, 6}, {.osm_id = 2})};
  const auto [topology, findings] = build(block);
  // Piece 0 is the way from node 1 to 5, piece 1 from 5 back to 1: open chains first, then the round from node 5.
  EXPECT_EQ(told(topology), "2 | -0 -1 o ");
  EXPECT_EQ(start_vertex(topology, topology.chains[ChainIndex(1)].pieces[0]),
            topology.pieces[PieceIndex(0)].last_vertex);
  expect_every_piece_once(topology);
  // Without the road into it there is no junction: it begins where it is drawn.
  EXPECT_EQ(told(build({block[0]}).topology), "0 o ");
}

TEST(Topology, a_loop_of_one_way_runs_on_into_itself_where_nothing_else_arrives) {
  std::vector<Vec2> round = circle_points({0, 0}, 40.0, 0.0, 2.0 * M_PI);
  round.back() = round.front();
  std::vector<std::int64_t> ids(round.size(), 0);
  ids.front() = ids.back() = 1;
  const auto with_id = build({make_path(round, ids)});
  EXPECT_EQ(told(with_id.topology), "0 o ");
  EXPECT_EQ(with_id.topology.vertices.size(), 1u);
  // Ends at one place without an OSM node are one place, too.
  EXPECT_EQ(told(build({make_path(round, {})}).topology), "0 o ");
}

TEST(Topology, a_way_that_crosses_itself_is_cut_there) {
  // An eight: node 2 is passed twice, straight through each time.
  const auto [topology, findings] =
      build({make_path({{-60, -30}, {0, 0}, {60, 30}, {90, 0}, {60, -30}, {0, 0}, {-60, 30}}, {1, 2, 0, 0, 0, 2, 3})});
  EXPECT_EQ(topology.pieces.size(), 3u);
  EXPECT_EQ(vertex_of(topology, 2).ends.size(), 4u);
  EXPECT_EQ(told(topology), "0 1 2 | ");
}

TEST(Topology, a_node_written_twice_in_a_row_is_cut_once) {
  RoadPath path = make_path({{0, 0}, {30, 0}, {60, 0}}, {1, 2, 3});
  path.nodes.insert(path.nodes.begin() + 15, path.nodes[15]);
  EXPECT_EQ(build({path}).topology.pieces.size(), 1u);
  const auto built = build({path, make_path({{30, 0}, {30, 60}}, {2, 4}, {.osm_id = 2})});
  EXPECT_EQ(told(built.topology), "0 1 | 2 | ") << "no piece of no length between the two";
}

TEST(Topology, dead_ends_below_two_metres_are_left_out_at_junctions_only) {
  const RoadPath main = make_path({{-60, 0}, {0, 0}, {60, 0}}, {1, 2, 3});
  const auto with_stub = [&](double length_m) {
    return build({main, make_path({{0, 0}, {0, length_m}}, {2, 4}, {.osm_id = 2})});
  };
  const auto stub = with_stub(1.9);
  EXPECT_EQ(stub.topology.pieces.size(), 2u);
  EXPECT_FALSE(vertex_of(stub.topology, 2).is_junction());
  ASSERT_EQ(stub.findings.size(), 1u);
  EXPECT_EQ(stub.findings[0].code, "network.stub_dropped");
  EXPECT_EQ(with_stub(2.1).topology.pieces.size(), 3u);
  EXPECT_EQ(build({make_path({{0, 0}, {0, 1.0}}, {2, 4})}).topology.pieces.size(), 1u) << "a road of its own";
}

TEST(Topology, vertices_lie_in_the_middle_of_ends_that_disagree) {
  const auto built = build({make_path({{-60, 0}, {0, 0.3}}, {1, 2}), make_path({{0, -0.1}, {60, 0}}, {2, 3})});
  EXPECT_LT(distance(vertex_of(built.topology, 2).p, site_origin + Vec2{0, 0.1}), 1e-9);
}

/// A one-way ring of `radius_m`, driven to the left, of four ways with four arms that leave it along its tangent: every
/// arm would run straight on from a piece of the ring.
std::vector<RoadPath> ring_with_tangents(double radius_m, bool tagged) {
  std::vector<RoadPath> paths;
  for (int i = 0; i < 4; ++i) {
    const double from = i * M_PI / 2.0;
    const std::vector<Vec2> points = circle_points({0, 0}, radius_m, from, M_PI / 2.0);
    std::vector<std::int64_t> ids(points.size(), 0);
    ids.front() = i + 1, ids.back() = (i + 1) % 4 + 1;
    paths.push_back(
        make_path(points, ids, {.osm_id = 10 + i, .oneway = Oneway::forward, .lanes = 1, .roundabout = tagged}));
    const Vec2 at = Vec2{std::cos(from), std::sin(from)} * radius_m, along{-std::sin(from), std::cos(from)};
    paths.push_back(make_path({at, at + along * 60.0}, {i + 1, i + 50}, {.osm_id = 20 + i}));
  }
  return paths;
}

TEST(Topology, a_ring_is_one_closed_chain_whatever_leaves_it_straight) {
  for (const bool tagged : {true, false}) {
    const auto [topology, findings] = build(ring_with_tangents(12.0, tagged));
    int in_ring = 0;
    for (const int ring : topology.ring_of_piece) in_ring += ring == 0 ? 1 : 0;
    EXPECT_EQ(in_ring, 4);
    EXPECT_EQ(topology.chains.size(), 5u);
    const auto closed = std::count_if(topology.chains.begin(), topology.chains.end(),
                                      [](const Chain& chain) { return chain.closed && chain.pieces.size() == 4; });
    EXPECT_EQ(closed, 1);
    expect_every_piece_once(topology);
  }
  // Driven the wrong way round it is no roundabout, and the ways that run straight on go on into each other.
  const auto wrong = build(ring_with_tangents(12.0, false), DrivingSide::left);
  for (const int ring : wrong.topology.ring_of_piece) EXPECT_EQ(ring, -1);
  for (const Chain& chain : wrong.topology.chains) EXPECT_FALSE(chain.closed);
}

TEST(Topology, of_no_roads_is_empty) {
  const auto built = build({});
  EXPECT_EQ(built.topology.pieces.size(), 0u);
  EXPECT_EQ(built.topology.chains.size(), 0u);
}

}  // namespace
}  // namespace orthodrive::network

// SPDX-License-Identifier: Apache-2.0
// One rule says which road runs on into which, one walker makes chains of it.

#include "orthodrive/roads/continuation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/roads/log_chains.hpp"
#include "orthodrive/roads/path_links.hpp"

namespace orthodrive {
namespace {

constexpr double deg = continuation_degree;

Vec2 towards(double angle_deg) { return {std::cos(angle_deg * deg), std::sin(angle_deg * deg)}; }

RoadPath named(const std::string& highway, const std::string& name) {
  RoadPath path;
  path.highway = highway, path.name = name;
  return path;
}

using Partners = std::vector<std::optional<std::size_t>>;
constexpr std::nullopt_t no = std::nullopt;

TEST(Continuation, bends_up_to_the_bound_run_on) {
  const RoadPath a = named("primary", "A"), b = named("primary", "A"), c = named("primary", "A");
  const auto runs_on = [&](double bend_deg, bool alone, const ContinuationRule& rule) {
    std::vector<MeetingEnd> ends{{towards(180.0), &a}, {towards(bend_deg), &b}};
    if (!alone) ends.push_back({towards(bend_deg > 0.0 ? 90.0 : -90.0), &c});  // far from straight for both
    return pair_ends(ends, alone, rule)[0].has_value();
  };
  EXPECT_TRUE(runs_on(49.9, false, way_continuation));
  EXPECT_FALSE(runs_on(50.1, false, way_continuation));
  EXPECT_TRUE(runs_on(-49.9, false, way_continuation));
  EXPECT_TRUE(runs_on(99.9, true, way_continuation));
  EXPECT_FALSE(runs_on(100.1, true, way_continuation));
  EXPECT_TRUE(runs_on(39.9, false, piece_continuation));
  EXPECT_FALSE(runs_on(40.1, false, piece_continuation));
  EXPECT_TRUE(runs_on(149.9, true, piece_continuation));
  EXPECT_FALSE(runs_on(150.1, true, piece_continuation)) << "it turns back in a junction";
}

TEST(Continuation, one_way_roads_that_both_leave_a_place_run_on_where_they_go_straight_on) {
  RoadPath one_way;
  one_way.oneway = Oneway::forward;
  const RoadPath two_way;
  const auto runs_on = [&](double bend_deg, const RoadPath& b, bool a_at_last, bool b_at_last) {
    const std::vector<MeetingEnd> ends{{towards(180.0), &one_way, -1, a_at_last},
                                       {towards(bend_deg), &b, -1, b_at_last}};
    return pair_ends(ends, true, piece_continuation)[0].has_value();
  };
  for (const bool arrives : {false, true}) {
    EXPECT_FALSE(runs_on(140.0, one_way, arrives, arrives)) << "two slip roads whose road is not on the map";
    EXPECT_TRUE(runs_on(39.9, one_way, arrives, arrives)) << "one of them is drawn the wrong way";
    EXPECT_TRUE(runs_on(140.0, one_way, arrives, !arrives));
    EXPECT_TRUE(runs_on(140.0, two_way, arrives, arrives));
  }
}

TEST(Continuation, of_several_the_straightest_pair_is_taken_first) {
  const RoadPath path;
  const RoadPath others[3];
  // 0 -> 1 bends 20, 0 -> 2 bends 10; 1 and 2 turn back into each other.
  const std::vector<MeetingEnd> fork{
      {towards(180.0), &path}, {towards(20.0), &others[0]}, {towards(-10.0), &others[1]}};
  EXPECT_EQ(pair_ends(fork, false, way_continuation), (Partners{2, no, 0}));
  EXPECT_EQ(pair_ends(fork, false, piece_continuation), (Partners{2, no, 0}));
}

TEST(Continuation, ties_go_to_the_lower_indices) {
  const RoadPath paths[6];
  // Two ends side by side in the same direction, one against them.
  const std::vector<MeetingEnd> ends{{towards(0.0), &paths[0]}, {towards(0.0), &paths[1]}, {towards(180.0), &paths[2]}};
  EXPECT_EQ(pair_ends(ends, false, way_continuation), (Partners{2, no, 0}));
  // Six ends that are three straight roads, given so that none stands beside its partner.
  std::vector<MeetingEnd> star;
  for (const double angle : {0.0, 60.0, 120.0, 180.0, 240.0, 300.0})
    star.push_back({towards(angle), &paths[star.size()]});
  EXPECT_EQ(pair_ends(star, false, piece_continuation), (Partners{3, 4, 5, 0, 1, 2}));
}

TEST(Continuation, class_and_name_count_as_bends_of_whole_ways_only) {
  const RoadPath main = named("primary", "Main"), on = named("primary", "Main"), lane = named("service", "Yard"),
                 renamed = named("primary", "Other");
  const auto partner_of_main = [&](const RoadPath& straight, double bend_deg, const ContinuationRule& rule) {
    return pair_ends(
        std::vector<MeetingEnd>{{towards(180.0), &main}, {towards(0.0), &straight}, {towards(bend_deg), &on}}, false,
        rule)[0];
  };
  EXPECT_EQ(partner_of_main(lane, 44.0, way_continuation), 2u);  // 44 against 0 + 30 + 15
  EXPECT_EQ(partner_of_main(lane, 46.0, way_continuation), 1u);
  EXPECT_EQ(partner_of_main(renamed, 14.0, way_continuation), 2u);  // against 15
  EXPECT_EQ(partner_of_main(renamed, 16.0, way_continuation), 1u);
  EXPECT_EQ(partner_of_main(lane, 14.0, piece_continuation), 1u);
}

TEST(Continuation, pieces_of_a_ring_go_first_and_then_those_of_one_way) {
  const RoadPath ring, arm, way;
  // A small ring that bends by 80 degrees, an arm that would go straight on from one of its pieces.
  const std::vector<MeetingEnd> roundabout{
      {towards(180.0), &ring, 0}, {towards(80.0), &ring, 0}, {towards(0.0), &arm, -1}};
  EXPECT_EQ(pair_ends(roundabout, false, piece_continuation), (Partners{1, 0, no}));
  EXPECT_EQ(pair_ends(roundabout, false, way_continuation), (Partners{1, 0, no}));
  const std::vector<MeetingEnd> two_rings{
      {towards(180.0), &ring, 0}, {towards(80.0), &way, 1}, {towards(100.0), &arm, -1}};
  EXPECT_EQ(pair_ends(two_rings, false, piece_continuation), (Partners{no, no, no}));
  const std::vector<MeetingEnd> way_bends{{towards(180.0), &way}, {towards(35.0), &way}, {towards(1.0), &arm}};
  EXPECT_EQ(pair_ends(way_bends, false, piece_continuation), (Partners{1, 0, no}));
  EXPECT_EQ(pair_ends(way_bends, false, way_continuation), (Partners{2, no, 0}));
}

TEST(Continuation, the_direction_is_that_of_the_first_metres) {
  const Polyline line{{0, 0}, {0, 6}, {100, 6}};  // 6 m to the north, then east
  const Vec2 way = direction_into(line, way_continuation), piece = direction_into(line, piece_continuation);
  EXPECT_NEAR(std::atan2(way.y, way.x), std::atan2(6.0, 4.0), 1e-12);      // 10 m on
  EXPECT_NEAR(std::atan2(piece.y, piece.x), std::atan2(6.0, 2.0), 1e-12);  // 8 m on
  const Polyline short_line{{0, 0}, {0, 2}, {2, 2}};
  EXPECT_NEAR(direction_into(short_line, way_continuation).x, std::sqrt(0.5), 1e-12) << "its far end";
  EXPECT_NEAR(direction_into(short_line, piece_continuation).x, 0.0, 1e-12) << "its middle";
}

RoadPath path_of(const std::vector<std::pair<Vec2, std::int64_t>>& nodes) {
  RoadPath path;
  double s_m = 0.0;
  for (const auto& [p, id] : nodes) {
    if (!path.nodes.empty()) s_m += distance(path.nodes.back().p, p);
    path.nodes.push_back({.p = p, .osm_node = id, .s_m = s_m});
  }
  return path;
}

/// "0 -1 |" is path 0, then path 1 backwards, open; "o" closes.
std::string told(const std::vector<PathChain>& chains) {
  std::string text;
  for (const PathChain& chain : chains) {
    for (const ChainPath& member : chain.paths)
      text += (member.reversed ? "-" : "") + std::to_string(member.path) + " ";
    text += chain.closed ? "o " : "| ";
  }
  return text;
}
std::string chains_of(const RoadNetwork& roads, ChainOrder order) {
  return told(chain_paths(roads, link_path_ends(roads), order));
}

TEST(ChainWalk, a_road_that_ends_at_a_passing_one_goes_on_nowhere) {
  // The passing way is not cut: at node 2 one end meets a road, and there are three directions, not two.
  const RoadNetwork t{{},
                      {path_of({{{0, 0}, 1}, {{50, 0}, 2}, {{100, 0}, 3}}), path_of({{{50, 0}, 2}, {{60, 50}, 4}})}};
  EXPECT_TRUE(link_path_ends(t).empty());
  EXPECT_EQ(chains_of(t, ChainOrder::by_lowest_path), "0 | 1 | ");
  // Two ways that end there on both sides are no pair alone either: 80 degrees are too many with a road passing.
  const RoadNetwork cross{{},
                          {path_of({{{0, 0}, 1}, {{50, 0}, 2}, {{100, 0}, 3}}), path_of({{{50, 0}, 2}, {{50, 50}, 4}}),
                           path_of({{{50, 0}, 2}, {{50 + 50 * std::sin(80 * deg), -50 * std::cos(80 * deg)}, 5}})}};
  EXPECT_TRUE(link_path_ends(cross).empty());
}

TEST(ChainWalk, orders_differ_in_where_open_chains_begin) {
  // 2 -> 0 -> 1 in a row, 0 drawn from its far end; a closed pair 3, 4; a lone way 5.
  const RoadNetwork roads{
      {},
      {path_of({{{100, 0}, 3}, {{50, 0}, 2}}), path_of({{{100, 0}, 3}, {{150, 0}, 4}}),
       path_of({{{0, 0}, 1}, {{50, 0}, 2}}), path_of({{{0, 200}, 11}, {{30, 200}, 0}, {{30, 230}, 12}}),
       path_of({{{0, 200}, 11}, {{0, 230}, 0}, {{30, 230}, 12}}), path_of({{{0, 400}, 0}, {{9, 400}, 0}})}};
  EXPECT_EQ(chains_of(roads, ChainOrder::by_lowest_path), "-1 0 -2 | 3 -4 o 5 | ");
  EXPECT_EQ(chains_of(roads, ChainOrder::open_chains_first), "-1 0 -2 | 5 | 3 -4 o ");
}

TEST(ChainWalk, open_chains_begin_at_their_lower_outer_path) {
  // In a row 1, 0, 2, all in one direction: along 0 the chain begins with 1 either way. Reversing 1 and 2 alone moves
  // nothing but the signs.
  const Vec2 a{0, 0}, b{50, 0}, c{100, 0}, d{150, 0};
  const RoadNetwork with{{}, {path_of({{b, 2}, {c, 3}}), path_of({{a, 1}, {b, 2}}), path_of({{c, 3}, {d, 4}})}};
  EXPECT_EQ(chains_of(with, ChainOrder::by_lowest_path), "1 0 2 | ");
  EXPECT_EQ(chains_of(with, ChainOrder::open_chains_first), "1 0 2 | ");
  const RoadNetwork against{{}, {path_of({{c, 3}, {b, 2}}), path_of({{a, 1}, {b, 2}}), path_of({{c, 3}, {d, 4}})}};
  EXPECT_EQ(chains_of(against, ChainOrder::by_lowest_path), "-2 0 -1 | ") << "with the lowest path";
  EXPECT_EQ(chains_of(against, ChainOrder::open_chains_first), "1 -0 2 | ") << "from the lower outer path";
}

TEST(ChainWalk, a_way_may_run_on_into_itself) {
  const RoadNetwork loop{
      {},
      {path_of({{{0, 0}, 1}, {{40, 0}, 0}, {{80, 20}, 0}, {{40, 40}, 0}, {{0, 40}, 0}, {{-20, 20}, 0}, {{0, 0}, 1}})}};
  for (const ChainOrder order : {ChainOrder::by_lowest_path, ChainOrder::open_chains_first})
    EXPECT_EQ(chains_of(loop, order), "0 o ");
  // A drop: its ends meet at an angle of 10 degrees, which is no road going on.
  const RoadNetwork drop{{}, {path_of({{{0, 0}, 1}, {{100, 10}, 0}, {{100, -10}, 0}, {{0, 0}, 1}})}};
  EXPECT_EQ(chains_of(drop, ChainOrder::by_lowest_path), "0 | ");
}

TEST(ChainWalk, no_roads_give_no_chains) {
  EXPECT_EQ(chains_of({}, ChainOrder::by_lowest_path), "");
  EXPECT_EQ(chains_of({}, ChainOrder::open_chains_first), "");
}

/// Ends of lines that are numbers, as the walker sees them.
struct LineEnd {
  std::size_t line = 0;
  bool at_last = false;
  friend auto operator<=>(const LineEnd&, const LineEnd&) = default;
};

TEST(ChainWalk, closed_chains_begin_where_they_may) {
  // Three lines round: 0, 1, 2, all in one direction. Only the last end of line 1 may be a beginning.
  EndLinks<LineEnd> links;
  for (std::size_t line = 0; line < 3; ++line) {
    links[{line, true}] = {(line + 1) % 3, false};
    links[{(line + 1) % 3, false}] = {line, true};
  }
  const auto chains = ChainWalk<LineEnd>(3, links).open_ones_first([](LineEnd end) { return end == LineEnd{1, true}; });
  ASSERT_EQ(chains.size(), 1u);
  EXPECT_TRUE(chains[0].closed);
  EXPECT_EQ(chains[0].entries, (std::vector<LineEnd>{{1, true}, {0, true}, {2, true}}));
  const auto nowhere = ChainWalk<LineEnd>(3, links).open_ones_first([](LineEnd) { return false; });
  ASSERT_EQ(nowhere.size(), 1u);
  EXPECT_EQ(nowhere[0].entries, (std::vector<LineEnd>{{0, false}, {1, false}, {2, false}}));
}

TEST(LogChains, one_coordinate_runs_along_the_whole_road) {
  const RoadNetwork roads{{}, {path_of({{{100, 0}, 3}, {{50, 0}, 2}}), path_of({{{0, 0}, 1}, {{50, 0}, 2}})}};
  const LogChains chains = make_log_chains(roads);
  ASSERT_EQ(chains.chains.size(), 1u);
  EXPECT_FALSE(chains.chains[0].closed);
  EXPECT_DOUBLE_EQ(chains.chains[0].length_m, 100.0);
  EXPECT_DOUBLE_EQ(chains.along_m(0, 10.0), 10.0);  // x = 90, the chain begins at x = 100
  EXPECT_DOUBLE_EQ(chains.along_m(1, 10.0), 90.0);  // x = 10
  EXPECT_EQ(chains.sign(0), 1.0);
  EXPECT_EQ(chains.sign(1), -1.0);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// Turns that relations forbid over one or more ways, and the only ones that they allow.

#include "orthodrive/network/roads/turn_rules.hpp"

#include <algorithm>
#include <set>
#include <string>

#include "network_support.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;

/// "from>to" of all connecting roads, by OSM's ways.
std::set<std::string> turns_of(const roadquery::RoadMap& map) {
  std::set<std::string> turns;
  for (const Road* road : connecting_roads(map))
    turns.insert(road_by_id(map, road->predecessor.id)->osm_id + ">" + road_by_id(map, road->successor.id)->osm_id);
  return turns;
}

/// A dual carriageway (1, 2 eastwards, 3, 4 westwards) that a street (5, 6 between the carriageways, 7) crosses. Node
/// 10 lies on the southern carriageway, 20 on the northern one, `apart_m` further north.
RoadNetwork dual_carriageway(double apart_m) {
  const PathOptions one_way{.highway = "secondary", .width_m = 7.0, .oneway = Oneway::forward};
  const auto with_id = [](PathOptions options, std::int64_t id) {
    options.osm_id = id;
    return options;
  };
  return network_of({make_path({{-150, 0}, {0, 0}}, {1, 10}, with_id(one_way, 1)),
                     make_path({{0, 0}, {150, 0}}, {10, 2}, with_id(one_way, 2)),
                     make_path({{150, apart_m}, {0, apart_m}}, {3, 20}, with_id(one_way, 3)),
                     make_path({{0, apart_m}, {-150, apart_m}}, {20, 4}, with_id(one_way, 4)),
                     make_path({{0, -150}, {0, 0}}, {5, 10}, {.osm_id = 5}),
                     make_path({{0, apart_m}, {0, 0}}, {20, 10}, {.osm_id = 6}),
                     make_path({{0, apart_m}, {0, apart_m + 150}}, {20, 7}, {.osm_id = 7})});
}

TEST(TurnRules, a_turn_over_a_way_inside_a_junction_is_not_built) {
  RoadNetwork roads = dual_carriageway(12.0);
  const std::set<std::string> before = turns_of(build_network(roads).map);
  ASSERT_TRUE(before.contains("1>7")) << "to the left, over the way between the carriageways";
  ASSERT_TRUE(before.contains("5>7"));
  roads.restrictions = {{1, 10, 7, false, {6}}};
  const NetworkResult result = build_network(roads);
  expect_sound(result.map);
  std::set<std::string> wanted = before;
  wanted.erase("1>7");
  EXPECT_EQ(turns_of(result.map), wanted);
  EXPECT_EQ(std::ranges::count(result.findings, "network.restriction_over_road", &Finding::code), 0);
}

TEST(TurnRules, the_only_turn_over_a_way_is_the_only_one) {
  RoadNetwork roads = dual_carriageway(12.0);
  std::set<std::string> wanted = turns_of(build_network(roads).map);
  roads.restrictions = {{1, 10, 7, true, {6}}};
  const NetworkResult result = build_network(roads);
  expect_sound(result.map);
  std::erase_if(wanted, [](const std::string& turn) { return turn.starts_with("1>") && turn != "1>7"; });
  EXPECT_EQ(turns_of(result.map), wanted);
  EXPECT_TRUE(wanted.contains("1>7"));
  EXPECT_TRUE(wanted.contains("5>4")) << "who comes from elsewhere may turn";
}

TEST(TurnRules, restrictions_over_several_ways) {
  RoadNetwork roads = dual_carriageway(12.0);
  // The way between the carriageways is two, drawn against each other.
  roads.paths[5] = make_path({{0, 12}, {0, 6}}, {20, 15}, {.osm_id = 6});
  roads.paths.push_back(make_path({{0, 0}, {0, 6}}, {10, 15}, {.osm_id = 8}));
  const std::set<std::string> before = turns_of(build_network(roads).map);
  ASSERT_TRUE(before.contains("1>7"));
  roads.restrictions = {{1, 10, 7, false, {8, 6}}};
  std::set<std::string> wanted = before;
  wanted.erase("1>7");
  EXPECT_EQ(turns_of(build_network(roads).map), wanted);
  roads.restrictions = {{1, 10, 7, false, {8}}};
  EXPECT_EQ(turns_of(build_network(roads).map), before) << "way 8 does not lead into way 7";
}

TEST(TurnRules, a_way_that_alone_leads_on_counts_as_the_one_before) {
  // Ways 1 and 9 are one road: the restriction over way 9 is one at the node.
  RoadNetwork roads = dual_carriageway(12.0);
  for (const double at_x : {-60.0, -6.0}) {  // its border lies on the road, or inside the junction
    roads.paths[0] = make_path({{-150, 0}, {at_x, 0}}, {1, 11},
                               {.osm_id = 1, .highway = "secondary", .width_m = 7.0, .oneway = Oneway::forward});
    roads.paths.resize(7);
    roads.paths.push_back(make_path({{at_x, 0}, {0, 0}}, {11, 10},
                                    {.osm_id = 9, .highway = "secondary", .width_m = 7.0, .oneway = Oneway::forward}));
    roads.restrictions.clear();
    const std::set<std::string> before = turns_of(build_network(roads).map);
    const std::string last = at_x < -50.0 ? "9" : "1";
    ASSERT_TRUE(before.contains(last + ">2"));
    ASSERT_TRUE(before.contains(last + ">7"));
    std::set<std::string> wanted = before;
    roads.restrictions = {{1, 11, 2, false, {9}}, {1, 11, 7, false, {9, 6}}};
    const NetworkResult result = build_network(roads);
    wanted.erase(last + ">2"), wanted.erase(last + ">7");
    EXPECT_EQ(turns_of(result.map), wanted) << at_x;
    EXPECT_EQ(std::ranges::count(result.findings, "network.restriction_over_road", &Finding::code), 0);
  }
}

TEST(TurnRules, a_way_with_a_road_of_its_own_is_told) {
  RoadNetwork roads = dual_carriageway(90.0);
  const std::set<std::string> before = turns_of(build_network(roads).map);
  roads.restrictions = {{1, 10, 4, false, {6}}, {99, 10, 4, false, {6}}};
  const NetworkResult result = build_network(roads);
  EXPECT_EQ(turns_of(result.map), before);
  ASSERT_EQ(std::ranges::count(result.findings, "network.restriction_over_road", &Finding::code), 1);
  const Finding& finding = *std::ranges::find(result.findings, "network.restriction_over_road", &Finding::code);
  EXPECT_NE(finding.message.find("no turn from way 1 over way 6 into way 4"), std::string::npos) << finding.message;
  EXPECT_NEAR(finding.y_m, site_origin.y + 45.0, 10.0) << "on the way between";
  roads.restrictions = {{1, 10, 4, true, {6}}};
  std::set<std::string> wanted = before;
  wanted.erase("1>2"), wanted.erase("1>5");
  EXPECT_EQ(turns_of(build_network(roads).map), wanted) << "one has to drive onto the way all the same";
}

TEST(TurnRules, what_one_follows_depends_on_where_one_comes_from) {
  const network::TurnRules rules({{1, 10, 4, false, {6, 8}}, {1, 10, 5, true, {6, 8}}, {2, 10, 4, false, {}}});
  const network::DrivenWay start{1, {}}, other{3, {}};
  EXPECT_TRUE(rules.forbid(start, 10, 2)) << "only over way 6";
  EXPECT_FALSE(rules.forbid(start, 11, 2)) << "at another node";
  EXPECT_TRUE(rules.forbid({2, {}}, 10, 4));
  const network::DrivenWay on_6 = rules.drive_on(start, 10, 6);
  EXPECT_EQ(on_6.followed.size(), 2u);
  EXPECT_EQ(rules.drive_on(on_6, 15, 6), on_6) << "still the same way";
  EXPECT_TRUE(rules.forbid(on_6, 16, 7));
  EXPECT_FALSE(rules.forbid(on_6, 16, 8));
  const network::DrivenWay on_8 = rules.drive_on(on_6, 16, 8);
  EXPECT_TRUE(rules.forbid(on_8, 17, 4));
  EXPECT_FALSE(rules.forbid(on_8, 17, 5));
  EXPECT_FALSE(rules.forbid(rules.drive_on(rules.drive_on(other, 10, 6), 16, 8), 17, 4));
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/paint/follow_mark_rule.hpp"

#include <gtest/gtest.h>

namespace orthodrive::network {
namespace {

using roadquery::Lane;
using roadquery::LaneType;

const RoadMarkRule american{.country = "US",
                            .between_directions = "yellow",
                            .inner_edge = "yellow",
                            .is_solid_centre_double = true,
                            .strokes = {{60.0, 1.0, 3.0}, {100.0, 3.0, 9.0}}};

Lane lane(int id, LaneType type, const char* mark) {
  return {.id = id, .type = type, .width = {{}}, .marks = {{0.0, mark, 0.12}}};
}

/// One section with these lanes, painted by the rule.
roadquery::Road painted(const RoadMarkRule& rule, const char* centre, std::vector<Lane> left, std::vector<Lane> right,
                        double kmh = 50.0) {
  roadquery::RoadMap map;
  map.roads.emplace_back();
  roadquery::Road& road = map.roads.front();
  road.speed_limit_mps = kmh / 3.6;
  road.sections.emplace_back();
  road.sections[0].center = lane(0, LaneType::none, centre);
  road.sections[0].left = std::move(left), road.sections[0].right = std::move(right);
  follow_mark_rule(rule, map);
  return map.roads.front();
}

TEST(FollowMarkRule, what_parts_opposite_directions_is_yellow_and_double_where_solid) {
  const roadquery::Road road = painted(american, "solid", {lane(1, LaneType::driving, "solid")},
                                       {lane(-1, LaneType::driving, "broken"), lane(-2, LaneType::driving, "solid")});
  const roadquery::LaneSection& section = road.sections[0];
  EXPECT_EQ(section.center.marks[0].type, "solid solid");
  EXPECT_EQ(section.center.marks[0].color, "yellow");
  for (const Lane& side : {section.left[0], section.right[0], section.right[1]})
    EXPECT_EQ(side.marks[0].color, "standard") << side.id;
  EXPECT_EQ(section.left[0].marks[0].type, "solid");
}

TEST(FollowMarkRule, a_lane_for_both_directions_lies_between_yellow_lines) {
  const roadquery::Road road =
      painted(american, "broken", {lane(1, LaneType::driving, "solid")},
              {lane(-1, LaneType::bidirectional, "broken"), lane(-2, LaneType::driving, "solid")});
  EXPECT_EQ(road.sections[0].center.marks[0].color, "yellow");
  EXPECT_EQ(road.sections[0].right[0].marks[0].color, "yellow");
  EXPECT_EQ(road.sections[0].right[1].marks[0].color, "standard");
}

TEST(FollowMarkRule, one_way_roads_have_an_inner_edge_but_race_tracks_and_single_tracks) {
  const std::vector<Lane> one{lane(-1, LaneType::driving, "solid")};
  EXPECT_EQ(painted(american, "solid", {}, one).sections[0].center.marks[0].color, "yellow");
  EXPECT_EQ(painted(american, "solid", {}, one).sections[0].center.marks[0].type, "solid");
  EXPECT_EQ(painted(american, "solid", {lane(1, LaneType::sidewalk, "none")}, one).sections[0].center.marks[0].color,
            "yellow");
  const std::vector<Lane> shared{lane(-1, LaneType::bidirectional, "solid")};
  EXPECT_EQ(painted(american, "solid", {}, shared).sections[0].center.marks[0].color, "standard");
}

TEST(FollowMarkRule, strokes_go_by_the_limit_and_the_last_rule_counts_for_faster_roads) {
  const std::vector<Lane> left{lane(1, LaneType::driving, "none")}, right{lane(-1, LaneType::driving, "none")};
  for (const auto& [kmh, stroke_m] : {std::pair{30.0, 1.0}, {60.0, 1.0}, {61.0, 3.0}, {130.0, 3.0}}) {
    const roadquery::Road road = painted(american, "broken", left, right, kmh);
    const auto& lines = road.sections[0].center.marks[0].lines;
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_EQ(lines[0].length, stroke_m) << kmh;
    EXPECT_EQ(lines[0].space, 3.0 * stroke_m);
    EXPECT_TRUE(road.sections[0].left[0].marks[0].lines.empty());
  }
}

TEST(FollowMarkRule, without_a_rule_marks_stay_as_they_are) {
  const roadquery::Road road =
      painted({}, "solid", {lane(1, LaneType::driving, "none")}, {lane(-1, LaneType::driving, "broken")});
  EXPECT_EQ(road.sections[0].center.marks[0].type, "solid");
  EXPECT_EQ(road.sections[0].center.marks[0].color, "standard");
  EXPECT_TRUE(road.sections[0].right[0].marks[0].lines.empty());
}

TEST(RoadMarkRules, a_part_has_the_rule_of_its_country_and_others_that_of_the_world) {
  RoadMarkRules rules{.rules = {american}, .here = "US-CA"};
  EXPECT_EQ(rule_here(rules).country, "US");
  rules.here = "DE";
  EXPECT_EQ(rule_here(rules).between_directions, "standard");
  rules.here.clear();
  EXPECT_TRUE(rule_here(rules).strokes.empty());
}

}  // namespace
}  // namespace orthodrive::network

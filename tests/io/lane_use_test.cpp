// SPDX-License-Identifier: Apache-2.0
// Who may use which lane, where the line of the map lies among them, room at nodes, and the table of what is read.

#include "orthodrive/io/osm/lane_use.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdlib>

#include "orthodrive/io/osm/tag_rules.hpp"
#include "orthodrive/io/osm/turning_places.hpp"
#include "paths.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {

io::WayAttributes read_way(io::OsmTags tags) {
  tags.emplace("highway", "primary");
  return io::way_attributes(tags);
}

TEST(LaneUse, a_centre_lane_is_counted_beside_those_of_the_directions) {
  io::WayAttributes way = read_way({{"highway", "secondary"},
                                    {"lanes", "5"},
                                    {"lanes:forward", "2"},
                                    {"lanes:backward", "2"},
                                    {"lanes:both_ways", "1"}});
  EXPECT_EQ(way.path.lanes, 5);
  EXPECT_EQ(way.path.lanes_both_ways, 1);
  EXPECT_NEAR(way.width_m, 16.75, 1e-9);
  EXPECT_TRUE(way.doubts.empty());
  way = read_way({{"lanes", "3"}, {"centre_turn_lane", "yes"}});
  EXPECT_EQ(way.path.lanes_forward, 1);
  EXPECT_EQ(way.path.lanes_backward, 1);
  EXPECT_EQ(way.path.lanes_both_ways, 1);
  way = read_way({{"lanes", "3"}, {"lanes:forward", "1"}, {"turn:lanes:both_ways", "left"}});
  EXPECT_EQ(way.path.lanes_backward, 1) << "the rest";
  EXPECT_TRUE(way.doubts.empty());
  way = read_way({{"lanes", "2"}, {"oneway", "reversible"}});
  EXPECT_EQ(shared_lanes(way.path), 2);
  way = read_way({{"lanes", "3"}, {"oneway", "reversible"}, {"lanes:forward", "2"}, {"lanes:backward", "1"}});
  EXPECT_EQ(shared_lanes(way.path), 3) << "the same lanes, driven either way";
  EXPECT_TRUE(way.doubts.empty());
  way = read_way({{"oneway", "reversible"}, {"lanes:forward", "2"}, {"turn:lanes:backward", "left|through"}});
  EXPECT_EQ(shared_lanes(way.path), 2);
  way = read_way({{"lanes", "2"}, {"oneway", "alternating"}, {"lanes:forward", "2"}, {"lanes:backward", "2"}});
  EXPECT_EQ(shared_lanes(way.path), 2);
  EXPECT_EQ(way.doubts.size(), 1U);
  way = read_way({{"lanes", "1"}});
  EXPECT_EQ(shared_lanes(way.path), 1);
  EXPECT_EQ(shared_lanes(read_way({{"lanes", "1"}, {"oneway", "yes"}}).path), 0);
}

TEST(LaneUse, lanes_of_one_kind_of_vehicle) {
  io::WayAttributes way = read_way({{"lanes", "3"}, {"oneway", "yes"}, {"bus:lanes", "yes|yes|designated"}});
  EXPECT_EQ(way.path.use_forward, "||bus");
  way = read_way({{"lanes", "2"}, {"oneway", "yes"}, {"psv:lanes", "|designated"}, {"vehicle:lanes", "yes|no"}});
  EXPECT_EQ(way.path.use_forward, "|psv");
  way = read_way({{"lanes", "2"}, {"oneway", "yes"}, {"access:lanes", "no|yes"}, {"taxi:lanes", "yes|yes"}});
  EXPECT_EQ(way.path.use_forward, "taxi|");
  way = read_way({{"lanes", "2"}, {"oneway", "yes"}, {"motor_vehicle:lanes", "yes|no"}});
  EXPECT_EQ(way.path.use_forward, "|none");
  way = read_way({{"lanes", "3"}, {"lanes:forward", "2"}, {"bus:lanes:forward", "|designated"}});
  EXPECT_EQ(way.path.use_forward, "|bus");
  EXPECT_EQ(way.path.use_backward, "");
  EXPECT_TRUE(way.doubts.empty());
  way = read_way({{"lanes", "2"}, {"oneway", "yes"}, {"bus:lanes", "yes|yes|designated"}});
  EXPECT_EQ(way.path.use_forward, "") << "three of two lanes";
  EXPECT_EQ(way.doubts.size(), 1u);
  way = read_way(
      {{"lanes", "2"}, {"oneway", "yes"}, {"bus:lanes", "yes|designated"}, {"motor_vehicle:lanes", "yes|yes"}});
  EXPECT_EQ(way.path.use_forward, "") << "cars may use it, too";
}

TEST(LaneUse, cycle_lanes_of_a_list_are_not_counted) {
  const io::WayAttributes way = read_way({{"lanes", "2"},
                                          {"oneway", "yes"},
                                          {"vehicle:lanes", "yes|yes|no"},
                                          {"bicycle:lanes", "||designated"},
                                          {"turn:lanes", "left|through|"}});
  EXPECT_EQ(way.path.side_lanes, "bicycle:right");
  EXPECT_EQ(way.path.use_forward, "");
  EXPECT_EQ(way.path.turn_forward, "left|through");
  EXPECT_EQ(way.path.lanes, 2);
  EXPECT_TRUE(way.doubts.empty());
}

TEST(LaneUse, lanes_at_the_sides) {
  const auto sides = [](io::OsmTags tags) { return read_way(std::move(tags)).path.side_lanes; };
  EXPECT_EQ(sides({{"cycleway", "lane"}}), "bicycle:along bicycle:against");
  EXPECT_EQ(sides({{"cycleway", "lane"}, {"oneway", "yes"}}), "bicycle:along");
  EXPECT_EQ(sides({{"cycleway", "opposite_lane"}, {"oneway", "yes"}}), "bicycle:against");
  EXPECT_EQ(sides({{"cycleway:right", "lane"}}), "bicycle:right");
  EXPECT_EQ(sides({{"cycleway:both", "lane"}}), "bicycle:left bicycle:right");
  EXPECT_EQ(sides({{"cycleway:left", "lane"}, {"oneway", "-1"}}), "bicycle:right") << "turned round with the way";
  EXPECT_EQ(sides({{"cycleway", "track"}}), "");
  EXPECT_EQ(sides({{"busway", "lane"}, {"lanes", "4"}}), "bus:along bus:against");
  EXPECT_EQ(sides({{"busway:right", "lane"}, {"lanes", "3"}}), "bus:right");
  EXPECT_EQ(sides({{"lanes:psv:forward", "1"}, {"lanes", "3"}}), "psv:along");
  EXPECT_EQ(sides({{"lanes:bus", "1"}, {"lanes", "3"}, {"oneway", "yes"}}), "bus:along");
  EXPECT_NEAR(read_way({{"cycleway", "lane"}}).width_m, 7.5 + 3.0, 1e-9) << "lanes in the carriageway make it wider";
}

TEST(LaneUse, lanes_against_a_one_way_road_are_none_for_cars) {
  io::WayAttributes way = read_way({{"oneway", "yes"},
                                    {"lanes", "3"},
                                    {"lanes:forward", "2"},
                                    {"lanes:backward", "1"},
                                    {"oneway:bus", "no"},
                                    {"bus:lanes:backward", "designated"}});
  EXPECT_EQ(way.path.lanes_forward, 2);
  EXPECT_EQ(way.path.lanes_backward, 1);
  EXPECT_EQ(way.path.use_backward, "bus");
  EXPECT_TRUE(way.doubts.empty());
  way = read_way({{"oneway", "yes"}, {"lanes", "2"}, {"busway", "opposite_lane"}});
  EXPECT_EQ(way.path.lanes_forward, 1);
  EXPECT_EQ(way.path.use_backward, "bus");
  way = read_way({{"oneway", "yes"}, {"lanes", "2"}, {"lanes:backward", "1"}, {"oneway:psv", "no"}});
  EXPECT_EQ(way.path.use_backward, "psv");
  way = read_way({{"oneway", "yes"}, {"lanes", "2"}, {"lanes:backward", "1"}, {"oneway:bicycle", "no"}});
  EXPECT_EQ(way.path.lanes_backward, 0);
  EXPECT_EQ(way.path.side_lanes, "bicycle:against");
}

TEST(LaneUse, who_may_drive_on_a_road) {
  const auto use = [](io::OsmTags tags) { return read_way(std::move(tags)).path.use; };
  EXPECT_EQ(use({{"access", "no"}, {"bus", "yes"}}), "bus");
  EXPECT_EQ(use({{"motor_vehicle", "no"}, {"psv", "designated"}}), "psv");
  EXPECT_EQ(use({{"vehicle", "no"}, {"bicycle", "yes"}}), "bicycle");
  EXPECT_EQ(use({{"vehicle", "no"}}), "none");
  EXPECT_EQ(use({{"access", "no"}, {"motorcar", "yes"}}), "") << "the closest key counts";
  EXPECT_EQ(use({{"access", "private"}}), "");
  EXPECT_EQ(use({{"bus", "designated"}}), "") << "others may come, too";
  EXPECT_EQ(use({{"highway", "busway"}}), "bus");
  EXPECT_EQ(use({{"highway", "raceway"}, {"access", "no"}}), "");
}

TEST(LaneUse, limits_of_each_direction) {
  io::WayAttributes way = read_way({{"maxspeed:forward", "70"}, {"maxspeed:backward", "30 mph"}});
  EXPECT_EQ(way.path.speeds_forward, "70");
  EXPECT_EQ(way.path.speeds_backward, "48.2803");
  EXPECT_EQ(way.path.speed_limit_kmh, 70.0) << "the larger one, of what has none of its own";
  way = read_way({{"maxspeed", "50"}, {"maxspeed:backward", "30"}, {"oneway", "-1"}});
  EXPECT_EQ(way.path.speeds_forward, "30") << "turned round with the way";
  way = read_way({{"oneway", "yes"}, {"lanes", "2"}, {"maxspeed:lanes", "100|80"}});
  EXPECT_EQ(way.path.speeds_forward, "100|80");
  way = read_way({{"maxspeed:both", "40"}});
  EXPECT_EQ(way.path.speed_limit_kmh, 40.0);
  EXPECT_EQ(read_way({{"maxspeed:forward", "fast"}}).doubts.size(), 1u);
}

TEST(LaneUse, limits_by_the_law_and_where_the_road_lies) {
  const auto context = [](io::OsmTags tags) { return read_way(std::move(tags)).path.speed_context; };
  EXPECT_EQ(context({{"highway", "primary"}, {"maxspeed", "CZ:urban"}}), "CZ:urban");
  EXPECT_EQ(context({{"highway", "primary"}, {"maxspeed:type", "GB:nsl_dual"}}), "GB:nsl_dual");
  EXPECT_EQ(context({{"highway", "primary"}, {"source:maxspeed", "RO:trunk"}}), "RO:trunk");
  EXPECT_EQ(context({{"highway", "primary"}, {"zone:maxspeed", "DE:30"}}), "DE:30");
  EXPECT_EQ(context({{"highway", "primary"}, {"zone:traffic", "DE:rural"}}), "DE:rural");
  EXPECT_EQ(context({{"highway", "trunk"}, {"motorroad", "yes"}}), "motorroad");
  EXPECT_EQ(context({{"highway", "residential"}}), "urban");
  EXPECT_EQ(context({{"highway", "primary"}, {"lit", "yes"}}), "urban");
  EXPECT_EQ(context({{"highway", "primary"}, {"sidewalk:left", "separate"}}), "urban");
  EXPECT_EQ(context({{"highway", "primary"}, {"sidewalk", "no"}}), "rural");
  EXPECT_EQ(context({{"highway", "primary"}}), "");
  EXPECT_EQ(
      read_way({{"highway", "primary"}, {"maxspeed", "80"}, {"source:maxspeed", "CH:rural"}}).path.speed_limit_kmh,
      80.0);
  EXPECT_EQ(read_way({{"highway", "primary"}, {"zone:maxspeed", "30"}}).path.speed_limit_kmh, 30.0);
  EXPECT_EQ(read_way({{"maxspeed:backward", "FR:zone30"}}).path.speeds_backward, "FR:zone30");
  EXPECT_EQ(read_way({{"maxspeed", "sign"}, {"maxspeed:type", "moon"}}).doubts.size(), 0u);
}

TEST(LaneUse, widths_of_parts) {
  EXPECT_EQ(read_way({{"width:lanes", "3|3.5"}, {"oneway", "yes"}}).width_m, 6.5);
  EXPECT_EQ(read_way({{"width:lanes:forward", "3"}, {"width:lanes:backward", "3.5"}}).width_m, 6.5);
  EXPECT_EQ(read_way({{"width:forward", "3"}, {"width:backward", "4"}}).width_m, 7.0);
  EXPECT_EQ(read_way({{"est_width", "5"}}).width_m, 5.0);
  EXPECT_EQ(read_way({{"width", "12"}, {"width:carriageway", "6"}}).width_m, 6.0);
}

TEST(LaneUse, lanes_for_cars_with_passengers_are_lanes_for_cars) {
  const io::OsmTags lanes{{"oneway", "yes"}, {"lanes", "3"}, {"hov:lanes", "designated||"}};
  for (const char* shut : {"motor_vehicle:lanes", "vehicle:lanes", "access:lanes", "motorcar:lanes"}) {
    io::OsmTags tags = lanes;
    tags.emplace(shut, "no||");
    const io::WayAttributes way = read_way(tags);
    EXPECT_EQ(way.path.use_forward, "") << shut;
    EXPECT_EQ(way.path.lanes, 3);
  }
  io::OsmTags with_buses = lanes;
  with_buses.emplace("bus:lanes", "designated||designated");
  EXPECT_EQ(read_way(with_buses).path.use_forward, "||bus") << "the first is shared";
  EXPECT_EQ(read_way({{"motor_vehicle", "no"}, {"hov", "designated"}}).path.use, "");
  EXPECT_EQ(read_way({{"motor_vehicle", "no"}, {"hov", "no"}, {"bus", "yes"}}).path.use, "bus");
}

TEST(LaneUse, widths_of_lanes_in_any_spelling) {
  const auto read = [](io::OsmTags tags) { return read_way(std::move(tags)); };
  for (const char* spelling : {"3.5|3|2.5", "3.5 m|3 m|2.5 m", " 3.5 | 3 |2,5", "3.5m|3m|2.5m", "3.50|3.0|2.50"}) {
    const io::WayAttributes way = read({{"oneway", "yes"}, {"lanes", "3"}, {"width:lanes", spelling}});
    EXPECT_EQ(way.path.widths_forward, "3.5|3|2.5") << spelling;
    EXPECT_NEAR(way.width_m, 9.0, 1e-9) << spelling;
    EXPECT_EQ(way.path.width_source, WidthSource::tag);
    EXPECT_THAT(way.doubts, testing::IsEmpty()) << spelling;
  }
  for (const char* spelling : {"11'|10'", "11 ft|10 ft", "11'0\"|10'0\"", "11 ft 0 in|10 feet"})
    EXPECT_EQ(read({{"oneway", "yes"}, {"width:lanes", spelling}}).path.widths_forward, "3.3528|3.048") << spelling;
  EXPECT_EQ(read({{"oneway", "yes"}, {"width:lanes", "3|3.5"}}).path.lanes, 2) << "the list tells how many";
  EXPECT_EQ(read({{"oneway", "-1"}, {"width:lanes:backward", "3|3.5"}}).path.widths_forward, "3|3.5");
  const io::WayAttributes both = read({{"lanes", "4"},
                                       {"lanes:forward", "2"},
                                       {"lanes:both_ways", "1"},
                                       {"width:lanes:forward", "3|3.5"},
                                       {"width:lanes:backward", "4"},
                                       {"width:lanes:both_ways", "2.5"}});
  EXPECT_EQ(both.path.widths_forward, "3|3.5");
  EXPECT_EQ(both.path.widths_backward, "4");
  EXPECT_EQ(both.path.widths_both_ways, "2.5");
  EXPECT_NEAR(both.width_m, 13.0, 1e-9);
  const io::WayAttributes cycles =
      read({{"oneway", "yes"}, {"lanes", "2"}, {"width:lanes", "3.5|3|1.8"}, {"bicycle:lanes", "||designated"}});
  EXPECT_EQ(cycles.path.widths_forward, "3.5|3") << "cycle lanes lie at the side";
  EXPECT_NEAR(cycles.width_m, 8.0, 1e-9) << "with one of 1.5 m";
  EXPECT_EQ(read({{"lanes", "4"}, {"width:forward", "7"}, {"lanes:forward", "2"}}).path.widths_forward, "3.5|3.5");
  EXPECT_NEAR(read({{"width", "12"}, {"oneway", "yes"}, {"width:lanes", "3|3.5"}}).width_m, 12.0, 1e-9);
}

TEST(LaneUse, widths_of_lanes_that_tell_less) {
  const double primary_m = default_width_m("primary", 3, Oneway::forward) / 3.0;
  io::WayAttributes way = read_way({{"oneway", "yes"}, {"lanes", "3"}, {"width:lanes", "3.5|3|"}});
  EXPECT_EQ(way.path.widths_forward, "3.5|3|");
  EXPECT_NEAR(way.width_m, 6.5 + primary_m, 1e-9) << "the last is as wide as in the class";
  EXPECT_EQ(way.path.width_source, WidthSource::lanes);
  EXPECT_THAT(way.doubts, testing::IsEmpty());
  way = read_way({{"lanes", "2"}, {"width:lanes:forward", "4"}});
  EXPECT_NEAR(way.width_m, 4.0 + 0.5 * default_width_m("primary", 2, Oneway::no), 1e-9) << "not the one lane alone";
  way = read_way({{"oneway", "yes"}, {"width:lanes", "||"}});
  EXPECT_EQ(way.path.widths_forward, "");
  EXPECT_EQ(way.path.width_source, WidthSource::highway);
}

TEST(LaneUse, odd_widths_of_lanes_are_told) {
  const auto doubts = [](io::OsmTags tags) { return read_way(std::move(tags)).doubts; };
  using testing::ElementsAre, testing::HasSubstr;
  EXPECT_THAT(doubts({{"oneway", "yes"}, {"lanes", "2"}, {"width:lanes", "3|wide"}}),
              ElementsAre(HasSubstr("width:lanes=3|wide: wide is no width of a lane")));
  EXPECT_THAT(doubts({{"oneway", "yes"}, {"lanes", "2"}, {"width:lanes", "3|350"}}),
              ElementsAre(HasSubstr("350 is no width of a lane")));
  EXPECT_THAT(doubts({{"oneway", "yes"}, {"lanes", "2"}, {"width:lanes", "3|3.5|3"}}),
              ElementsAre(HasSubstr("width:lanes tells 3 lanes forward, but there are 2")));
  EXPECT_THAT(doubts({{"lanes", "2"}, {"width:lanes", "3|3.5|3"}}),
              ElementsAre(HasSubstr("tells 3 lanes, but there are 2")));
  EXPECT_THAT(doubts({{"lanes", "2"}, {"width:lanes", "3|3.5"}}), ElementsAre(HasSubstr("which lane is whose")));
  EXPECT_THAT(doubts({{"lanes", "2"}, {"width:lanes", "3|3"}}), testing::IsEmpty());
  EXPECT_THAT(doubts({{"lanes", "1"}, {"width:lanes:forward", "3"}}), ElementsAre(HasSubstr("the lanes are for both")));
  EXPECT_EQ(read_way({{"lanes", "2"}, {"width:lanes", "3|3.5"}}).width_m, 6.5);
  EXPECT_THAT(read_way({{"width:forward", "wide"}}).odd, ElementsAre("width:forward=wide"));
  EXPECT_THAT(read_way({{"width:carriageway", "-"}}).odd, ElementsAre("width:carriageway=-"));
}

TEST(LaneUse, widths_of_lanes_turn_with_the_road) {
  RoadPath path = read_way({{"lanes", "4"},
                            {"lanes:forward", "1"},
                            {"lanes:backward", "1"},
                            {"lanes:both_ways", "2"},
                            {"width:lanes:forward", "3"},
                            {"width:lanes:both_ways", "2.5|"}})
                      .path;
  path.nodes.resize(2);
  turn_round(path);
  EXPECT_EQ(path.widths_backward, "3");
  EXPECT_EQ(path.widths_both_ways, "|2.5");
}

TEST(LaneUse, surfaces_of_parts) {
  EXPECT_EQ(read_way({{"surface:forward", "sett"}, {"surface:backward", "sett"}}).path.surface, "sett");
  const io::WayAttributes way = read_way({{"surface:lanes", "asphalt|sett"}});
  EXPECT_EQ(way.path.surface, "asphalt");
  EXPECT_EQ(way.doubts.size(), 1u);
}

TEST(LaneUse, placement) {
  const auto read = [](io::OsmTags tags) {
    const Placement p = read_way(std::move(tags)).path.placement;
    return fmt::format("{}{} {}{}", p.backward ? "b" : "f", p.start, p.end, p.transition ? " t" : "");
  };
  EXPECT_EQ(read({{"oneway", "yes"}, {"lanes", "3"}, {"placement", "right_of:1"}}), "f1 1");
  EXPECT_EQ(read({{"oneway", "yes"}, {"lanes", "3"}, {"placement", "left_of:1"}}), "f0 0");
  EXPECT_EQ(read({{"oneway", "yes"}, {"lanes", "3"}, {"placement", "middle_of:2"}}), "f1.5 1.5");
  EXPECT_EQ(read({{"oneway", "yes"}, {"lanes", "3"}, {"placement", "transition"}}), "f-1 -1 t");
  EXPECT_EQ(read({{"oneway", "yes"}, {"placement:start", "left_of:1"}, {"placement:end", "right_of:2"}}), "f0 2");
  EXPECT_EQ(read({{"lanes", "3"}, {"placement:forward", "right_of:1"}}), "f1 1");
  EXPECT_EQ(read({{"lanes", "3"}, {"placement:backward", "middle_of:1"}}), "b0.5 0.5");
  EXPECT_EQ(read({{"oneway", "yes"}, {"lanes", "2"}, {"placement", "right_of:4"}}), "f-1 -1") << "of two lanes";
  EXPECT_EQ(read_way({{"placement", "right_of:1"}}).doubts.size(), 1u) << "of which direction?";
  EXPECT_EQ(read_way({{"oneway", "yes"}, {"placement", "beside"}}).doubts.size(), 1u);
}

TEST(LaneUse, turning_a_path_round_turns_what_its_lanes_say) {
  RoadPath path = read_way({{"lanes", "3"},
                            {"lanes:forward", "2"},
                            {"bus:lanes:forward", "|designated"},
                            {"cycleway:left", "lane"},
                            {"maxspeed:backward", "30"},
                            {"placement:forward", "right_of:1"}})
                      .path;
  path.nodes.resize(2);
  turn_round(path);
  EXPECT_EQ(path.lanes_backward, 2);
  EXPECT_EQ(path.use_backward, "|bus");
  EXPECT_EQ(path.side_lanes, "bicycle:right");
  EXPECT_EQ(path.speeds_forward, "30");
  EXPECT_TRUE(path.placement.backward);
}

/// A road of 100 m to the east.
RoadNetwork straight_road(double width_m) {
  RoadPath path{.osm_id = 1, .highway = "residential"};
  path.nodes = {{.p = origin + Vec2{10, 50}, .osm_node = 1, .width_m = width_m},
                {.p = origin + Vec2{110, 50}, .osm_node = 2, .s_m = 100.0, .width_m = width_m}};
  return {utm33, {path}};
}

double widest_m(const RoadPath& path) { return std::ranges::max(path.nodes, {}, &RoadNode::width_m).width_m; }

TEST(TurningPlaces, a_circle_at_a_dead_end_is_paved) {
  const auto place = io::turning_place(2, {{"highway", "turning_circle"}, {"diameter", "18"}});
  ASSERT_TRUE(place);
  RoadNetwork roads = straight_road(5.5);
  io::widen_at({*place}, site_of(200).area, roads);
  const RoadPath& path = roads.paths[0];
  EXPECT_NEAR(widest_m(path), 18.0, 0.3);
  EXPECT_NEAR(path.nodes.back().s_m, 100.0 + 0.9 * 9.0, 1e-6) << "to its far side";
  EXPECT_EQ(path.nodes.front().width_m, 5.5);
  for (std::size_t i = 1; i < path.nodes.size(); ++i) EXPECT_GT(path.nodes[i].s_m, path.nodes[i - 1].s_m);
  roads = straight_road(5.5);
  const auto loop = io::turning_place(1, {{"highway", "turning_loop"}});
  ASSERT_TRUE(loop.has_value());
  io::widen_at({*loop}, site_of(200).area, roads);
  EXPECT_NEAR(widest_m(roads.paths[0]), 18.0, 0.3);
  EXPECT_EQ(roads.paths[0].nodes.back().width_m, 5.5);
  EXPECT_LT(roads.paths[0].nodes.front().p.x, origin.x + 10.0) << "at the beginning of the way";
}

TEST(TurningPlaces, a_passing_place_is_as_wide_as_two_cars_need) {
  RoadNetwork roads = straight_road(3.0);
  roads.paths[0].nodes.insert(roads.paths[0].nodes.begin() + 1,
                              {.p = origin + Vec2{60, 50}, .osm_node = 7, .s_m = 50.0, .width_m = 3.0});
  const auto place = io::turning_place(7, {{"highway", "passing_place"}});
  ASSERT_TRUE(place.has_value());
  io::widen_at({*place}, site_of(200).area, roads);
  EXPECT_NEAR(widest_m(roads.paths[0]), 5.5, 1e-9);
  EXPECT_EQ(roads.paths[0].nodes.front().width_m, 3.0);
  EXPECT_EQ(roads.paths[0].nodes.back().width_m, 3.0);
  EXPECT_NEAR(roads.paths[0].nodes.back().s_m, 100.0, 1e-9);
}

TEST(TagRules, tags_that_are_not_read_are_named) {
  const auto unread = io::unread_tags({{"highway", "residential"},
                                       {"traffic_calming", "hump;choker"},
                                       {"change:lanes", "yes|no"},
                                       {"cycleway:left", "track"},
                                       {"maxspeed", "50"},
                                       {"maxspeed:conditional", "30 @ (22:00-06:00)"},
                                       {"name", "High Street"}},
                                      io::TaggedObject::way);
  std::vector<std::string> tags;
  tags.reserve(unread.size());
  for (const io::UnreadTag& tag : unread) tags.push_back(tag.tag);
  EXPECT_THAT(tags, testing::UnorderedElementsAre("traffic_calming=choker", "change:lanes=yes|no",
                                                  "cycleway:left=track", "maxspeed:conditional=30 @ (22:00-06:00)"));
  EXPECT_EQ(io::unread_tags({{"barrier", "kerb"}}, io::TaggedObject::node).size(), 1u);
  for (const auto& [key, value] :
       {std::pair{"barrier", "gate"}, {"highway", "mini_roundabout"}, {"traffic_calming", "table"}})
    EXPECT_TRUE(io::unread_tags({{key, value}}, io::TaggedObject::node).empty()) << key;
  for (const char* value : {"yes", "island", "chicane", "rumble_strip", "made_up"})
    EXPECT_EQ(io::unread_tags({{"traffic_calming", value}}, io::TaggedObject::node).size(), 1u) << value;
  EXPECT_TRUE(io::unread_tags({{"highway", "turning_circle"}}, io::TaggedObject::node).empty());
}

std::string page_of_rules() {
  std::string text =
      "# What is read of OpenStreetMap's tags\n\n"
      "Of roads and of their nodes. The table is `io/osm/tag_rules` and this page is written from it by "
      "`tests/io/lane_use_test` "
      "(`ORTHODRIVE_RECORD=1`).\nWhat is met and not read is counted: one finding `osm.tag_not_read` for each tag and "
      "value, at its first "
      "place. Tags of lanes that\ncontradict each other or cannot be read are `osm.lane_tags`, with what was taken. A "
      "key with `*` stands for all "
      "that begin so.\n";
  for (const bool is_read : {true, false})
    for (const io::TaggedObject on : {io::TaggedObject::way, io::TaggedObject::node}) {
      text += fmt::format("\n## {}, {}\n\n| key | wiki | {} |\n|---|---|---|\n",
                          on == io::TaggedObject::way ? "Roads" : "Nodes on roads", is_read ? "read" : "not read",
                          is_read ? "what is made of it" : "why not");
      std::string keys;  // keys in a row that mean the same share a line
      const io::TagRule* before = nullptr;
      const auto end_line = [&] {
        if (before) text += fmt::format("| {} | {} | {} |\n", keys, before->page, before->meaning);
      };
      for (const io::TagRule& rule : io::tag_rules()) {
        if (rule.is_read != is_read || rule.on != on) continue;
        const bool is_same = before && before->page == rule.page && before->meaning == rule.meaning;
        if (!is_same) end_line();
        keys = is_same ? fmt::format("{}, `{}`", keys, rule.key) : fmt::format("`{}`", rule.key);
        before = &rule;
      }
      end_line();
    }
  return text;
}

TEST(TagRules, the_page_has_the_table) {
  const auto file = paths::in_source("docs/osm_tags.md");
  if (std::getenv("ORTHODRIVE_RECORD")) write_bytes(file, page_of_rules());
  EXPECT_EQ(bytes_of(file), page_of_rules()) << "ORTHODRIVE_RECORD=1 test_io --gtest_filter='TagRules.*' writes it";
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// Slips of mappers and forms of files that other importers were reported for (docs/notes/trackers.md): what is read,
// what becomes a finding, and that nothing is passed over in silence.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <optional>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/vector/building_reader.hpp"
#include "orthodrive/io/vector/surroundings_reader.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

/// Nodes of ids 10 * column + row, 10 m apart.
std::string grid_nodes() {
  const CoordinateTransform lonlat_from_utm(utm33, Crs{"EPSG:4326"});
  std::string text;
  for (int column = 1; column < 9; ++column)
    for (int row = 1; row < 9; ++row) {
      const Vec2 q = lonlat_from_utm.target_from_source(origin + Vec2{10.0 * column, 10.0 * row});
      text += fmt::format("<node id='{}' lon='{:.7f}' lat='{:.7f}'/>", 10 * column + row, q.x, q.y);
    }
  return text;
}
std::string tags_xml(const io::OsmTags& tags) {
  std::string text;
  for (const auto& [key, value] : tags) text += fmt::format("<tag k='{}' v='{}'/>", key, value);
  return text;
}
std::string way_of(int id, const std::vector<int>& nodes, const io::OsmTags& tags) {
  std::string text = fmt::format("<way id='{}'>", id);
  for (const int node : nodes) text += fmt::format("<nd ref='{}'/>", node);
  return text + tags_xml(tags) + "</way>";
}
std::string relation_of(int id, const std::string& members, const io::OsmTags& tags) {
  return fmt::format("<relation id='{}'>{}{}</relation>", id, members, tags_xml(tags));
}
std::string member_xml(const char* type, int id, const char* role) {
  return fmt::format("<member type='{}' ref='{}' role='{}'/>", type, id, role);
}
const io::OsmTags street = {{"highway", "residential"}};

struct ReadMap {
  explicit ReadMap(const std::string& objects) {
    write_bytes(scratch / "a.osm", "<osm version='0.6'>" + grid_nodes() + objects + "</osm>");
  }
  RoadNetwork roads() { return io::read_osm_roads(scratch / "a.osm", site_of(100), &findings); }
  [[nodiscard]] std::vector<std::string> told() const {
    std::vector<std::string> all;
    for (const Finding& finding : findings) all.push_back(finding.code + ": " + finding.message);
    return all;
  }
  Scratch scratch;
  Findings findings;
};

TEST(OsmOddities, restrictions_of_cars_that_are_not_read_are_told) {
  const std::string ways = way_of(7, {11, 21}, street) + way_of(8, {21, 31}, street) + way_of(9, {31, 32}, street);
  const std::string over_node =
                        member_xml("way", 7, "from") + member_xml("node", 21, "via") + member_xml("way", 8, "to"),
                    over_way = member_xml("way", 7, "from") + member_xml("way", 8, "via") + member_xml("way", 9, "to");
  const auto restriction = [](int id, const std::string& members, io::OsmTags tags) {
    tags.emplace("type", "restriction");
    return relation_of(id, members, tags);
  };
  ReadMap map(
      ways + restriction(1, over_node, {{"restriction:motor_vehicle", "no_left_turn"}}) +
      restriction(2, over_way, {{"restriction", "no_u_turn"}}) +
      restriction(3, over_node, {{"restriction:conditional", "no_left_turn @ (07:00-09:00)"}}) +
      restriction(4, over_node, {{"restriction", "left"}}) +
      restriction(5, member_xml("way", 7, "from") + member_xml("node", 21, "via"), {{"restriction", "no_exit"}}) +
      restriction(6, over_node, {{"restriction:hgv", "no_left_turn"}}) +
      restriction(7, over_way, {{"restriction", "no_u_turn"}, {"except", "bicycle;motorcar"}}) +
      restriction(8, over_way, {{"restriction:hgv:conditional", "no_u_turn @ (22:00-06:00)"}}));
  const RoadNetwork roads = map.roads();
  ASSERT_EQ(roads.restrictions.size(), 2U);
  EXPECT_EQ(roads.restrictions[0].via_node, 21);
  EXPECT_THAT(roads.restrictions[0].via_ways, IsEmpty());
  EXPECT_THAT(roads.restrictions[1].via_ways, ElementsAre(8));
  EXPECT_THAT(map.told(), ElementsAre(HasSubstr("relation 3: no_left_turn @ (07:00-09:00) counts at some hours only"),
                                      HasSubstr("relation 4: restriction=left is not known"),
                                      HasSubstr("relation 5: no_exit lacks from, via or to")));
  EXPECT_EQ(map.findings[0].severity, Severity::info);
}

/// A relation whose members are ways: from, to and those between, in the order given.
std::string over_ways(int id, const std::string& value, int from, const std::vector<int>& via, int to) {
  std::string members = member_xml("way", to, "to");
  for (const int way : via) members += member_xml("way", way, "via");
  return relation_of(id, members + member_xml("way", from, "from"), {{"type", "restriction"}, {"restriction", value}});
}

TEST(OsmOddities, ways_over_which_a_restriction_goes_stand_in_any_order_and_direction) {
  const io::OsmTags one_way{{"highway", "residential"}, {"oneway", "yes"}};
  // 7 from 11 to 21, then 8, 9 and 10 up to 51, then 12; drawn in both directions. 13 crosses 9 on its way.
  const std::string ways = way_of(7, {11, 21}, one_way) + way_of(8, {31, 21}, street) +
                           way_of(9, {31, 32, 41}, street) +
                           way_of(10, {51, 41}, {{"highway", "residential"}, {"oneway", "-1"}}) +
                           way_of(12, {61, 51, 52}, street) + way_of(13, {22, 32, 42}, street);
  std::vector<int> via{8, 9, 10};
  do {
    ReadMap map(ways + over_ways(1, "no_left_turn", 7, via, 12));
    const RoadNetwork roads = map.roads();
    ASSERT_EQ(roads.restrictions.size(), 1U);
    EXPECT_EQ(roads.restrictions[0].via_node, 21);
    EXPECT_THAT(roads.restrictions[0].via_ways, ElementsAre(8, 9, 10));
    EXPECT_THAT(map.told(), IsEmpty());
  } while (std::next_permutation(via.begin(), via.end()));
  ReadMap map(ways + over_ways(1, "only_straight_on", 8, {9}, 13));
  EXPECT_THAT(map.roads().restrictions.at(0).via_ways, ElementsAre(9)) << "leaves it in its middle";
}

TEST(OsmOddities, restrictions_over_ways_that_cannot_be_driven_are_told) {
  const io::OsmTags one_way{{"highway", "residential"}, {"oneway", "yes"}};
  const std::string ways = way_of(7, {11, 21}, one_way) + way_of(8, {21, 31}, one_way) + way_of(9, {31, 41}, one_way) +
                           way_of(10, {51, 61}, street) + way_of(11, {21, 22}, {{"highway", "footway"}});
  ReadMap map(ways + over_ways(1, "no_u_turn", 9, {8}, 7) + over_ways(2, "only_right_turn", 7, {10}, 9) +
              over_ways(3, "no_u_turn", 7, {77}, 9) + over_ways(4, "no_u_turn", 7, {11}, 9) +
              over_ways(5, "no_u_turn", 8, {7}, 9) + over_ways(6, "no_u_turn", 7, {8, 8, 8, 8, 8, 8, 8, 8, 8}, 9) +
              over_ways(7, "no_entry", 7, {8}, 9));
  const RoadNetwork roads = map.roads();
  ASSERT_EQ(roads.restrictions.size(), 1U);
  EXPECT_THAT(map.told(), ElementsAre(HasSubstr("relation 1: no_u_turn over ways is left out: cars drive from way 7"),
                                      HasSubstr("relation 2: only_right_turn over ways is left out: its ways do not"),
                                      HasSubstr("relation 3: no_u_turn over ways is left out: way 77 is no road"),
                                      HasSubstr("relation 4: no_u_turn over ways is left out: way 11 is no road"),
                                      HasSubstr("relation 5: no_u_turn over ways is left out: "),
                                      HasSubstr("relation 6: no_u_turn over ways is left out: it goes over 9 ways")));
}

TEST(OsmOddities, an_only_turn_that_is_none_closes_nothing) {
  const auto only_to = [](int id, int to) {
    return relation_of(id, member_xml("way", 7, "from") + member_xml("node", 21, "via") + member_xml("way", to, "to"),
                       {{"type", "restriction"}, {"restriction", "only_straight_on"}});
  };
  ReadMap map(way_of(7, {11, 21}, street) + way_of(8, {21, 31}, street) + way_of(9, {31, 32}, street) +
              way_of(10, {22, 21}, {{"highway", "residential"}, {"oneway", "yes"}}) +
              way_of(11, {21, 12}, {{"highway", "residential"}, {"access", "no"}}) +
              way_of(12, {20, 21, 41}, {{"highway", "residential"}, {"oneway", "yes"}}) + only_to(1, 8) +
              only_to(2, 9) + only_to(3, 10) + only_to(4, 11) + only_to(5, 12) + only_to(6, 99));
  const RoadNetwork roads = map.roads();
  ASSERT_EQ(roads.restrictions.size(), 2U);
  EXPECT_EQ(roads.restrictions[0].to_way, 8);
  EXPECT_EQ(roads.restrictions[1].to_way, 12);
  std::vector<std::string> told;
  for (const Finding& finding : map.findings)
    if (finding.code == "osm.restriction_not_read") told.push_back(finding.message.substr(0, 11));
  EXPECT_THAT(told, ElementsAre("relation 2:", "relation 3:", "relation 4:", "relation 6:"));
}

TEST(OsmOddities, restrictions_of_ways_that_are_no_roads_say_nothing) {
  ReadMap map(way_of(7, {11, 21}, street) +
              relation_of(2, member_xml("way", 70, "from") + member_xml("way", 71, "via") + member_xml("way", 72, "to"),
                          {{"type", "restriction"}, {"restriction", "no_u_turn"}}));
  (void)map.roads();
  EXPECT_THAT(map.told(), IsEmpty());
}

TEST(OsmOddities, values_are_read_without_blanks_and_oneway_in_any_case) {
  ReadMap map(way_of(7, {11, 21}, {{"highway", " residential "}, {"lanes", " 4 "}, {"maxspeed", " 70"}}) +
              way_of(8, {31, 41}, {{"highway", "residential"}, {"oneway", "Yes"}}) +
              way_of(9, {51, 61}, {{"highway", "residential"}, {"oneway", "left"}}));
  const RoadNetwork roads = map.roads();
  ASSERT_EQ(roads.paths.size(), 3U);
  EXPECT_EQ(roads.paths[0].lanes, 4);
  EXPECT_EQ(roads.paths[0].speed_limit_kmh, 70.0);
  EXPECT_EQ(roads.paths[1].oneway, Oneway::forward);
  EXPECT_EQ(roads.paths[2].oneway, Oneway::no);
  EXPECT_THAT(map.told(), ElementsAre(HasSubstr("osm.lane_tags: way 9: oneway=left is not known")));
}

TEST(OsmOddities, lists_of_lanes_are_read_without_blanks) {
  const io::WayAttributes way = io::way_attributes({{"highway", "secondary"},
                                                    {"oneway", "yes"},
                                                    {"lanes", "3"},
                                                    {"turn:lanes", "left| through |through; right "},
                                                    {"vehicle:lanes", "yes| yes| no"},
                                                    {"bus:lanes", "yes |yes| designated"},
                                                    {"maxspeed:lanes", "100| 80 |30 mph"}});
  EXPECT_EQ(way.path.turn_forward, "left|through|through;right");
  EXPECT_EQ(way.path.use_forward, "||bus");
  EXPECT_EQ(way.path.speeds_forward, "100|80|48.2803");
  EXPECT_THAT(way.doubts, IsEmpty());
}

TEST(OsmOddities, values_of_highway_that_nobody_knows_are_told) {
  ReadMap map(way_of(7, {11, 21}, street) + way_of(8, {31, 41}, {{"highway", "residential;service"}}) +
              way_of(9, {51, 61}, {{"highway", "Secondary"}}) + way_of(10, {12, 22}, {{"highway", "footway"}}) +
              way_of(11, {32, 42}, {{"highway", "steps"}}));
  EXPECT_EQ(map.roads().paths.size(), 1U);
  EXPECT_THAT(map.told(), ElementsAre(HasSubstr("osm.highway_not_known: way 8: highway=residential;service"),
                                      HasSubstr("osm.highway_not_known: way 9: highway=Secondary")));
}

TEST(OsmOddities, turn_lanes_count_where_lanes_leaves_them_out) {
  const io::WayAttributes way =
      io::way_attributes({{"highway", "secondary"}, {"lanes", "2"}, {"turn:lanes:forward", "left|through"}});
  EXPECT_EQ(std::tuple(way.path.lanes, way.path.lanes_forward, way.path.lanes_backward), std::tuple(3, 2, 1));
  EXPECT_EQ(way.width_m, default_width_m("secondary", 3, Oneway::no)) << "of three lanes";
  EXPECT_THAT(way.doubts, ElementsAre(HasSubstr("lanes=2 but 2 of one direction alone")));
  const io::WayAttributes whole =
      io::way_attributes({{"highway", "secondary"}, {"lanes", "3"}, {"turn:lanes:backward", "left|through"}});
  EXPECT_EQ(std::tuple(whole.path.lanes_forward, whole.path.lanes_backward), std::tuple(1, 2));
  EXPECT_THAT(whole.doubts, IsEmpty());
}

TEST(OsmOddities, feet_and_inches_in_all_spellings) {
  for (const char* text : {"16'3\"", "16 ft 3 in", "16ft3in", "16 feet 3 in", "16' 3\"", "16'3''"})
    EXPECT_NEAR(io::parse_width_m(text), 16.25 * 0.3048, 1e-12) << text;
  for (const char* bad : {"16 ft 3", "16' 3 m", "ft", "16 ft in"}) EXPECT_EQ(io::parse_width_m(bad), 0.0) << bad;
}

TEST(OsmOddities, areas_that_cannot_be_closed_are_told) {
  const io::OsmTags house = {{"building", "yes"}}, multi = {{"type", "multipolygon"}, {"building", "yes"}};
  const std::string objects = way_of(1, {11, 21, 22, 12, 11}, house) +                   // a house
                              way_of(2, {31, 41, 42, 32}, house) +                       // not closed
                              way_of(3, {51, 62, 61, 52, 51}, house) +                   // a bow tie
                              way_of(4, {13, 23, 24, 14, 999, 13}, house) +              // a node is missing
                              way_of(20, {33, 43, 44}, {}) + way_of(21, {44, 34}, {}) +  // an open ring of two ways
                              way_of(22, {53, 63, 64}, {}) +                             // the other half is missing
                              way_of(23, {15, 25, 26, 16, 15}, {}) +  // twice a member, and touching holes
                              way_of(24, {27, 37, 38}, {}) + way_of(30, {71, 81, 82, 72}, street)  // no building
                              + relation_of(5, member_xml("way", 20, "outer") + member_xml("way", 21, "outer"), multi) +
                              relation_of(6, member_xml("way", 22, "outer") + member_xml("way", 98, "outer"), multi) +
                              relation_of(7, member_xml("way", 23, "outer") + member_xml("way", 23, "outer"), multi) +
                              relation_of(8, member_xml("way", 24, "outer") + member_xml("way", 99, "outer"),
                                          {{"type", "multipolygon"}, {"natural", "water"}});
  ReadMap map(objects);
  Findings& findings = map.findings;
  const std::vector<Building> buildings = io::read_buildings({map.scratch / "a.osm"}, site_of(100), &findings);
  EXPECT_EQ(buildings.size(), 2U) << "ways 1 and 23";
  EXPECT_THAT(map.told(), UnorderedElementsAre(
                              HasSubstr("buildings.no_area: way/2: its outline is not closed"),
                              HasSubstr("buildings.no_area: way/3: its outline crosses itself"),
                              HasSubstr("buildings.no_area: way/4: a part of its outline is not in the file"),
                              HasSubstr("buildings.no_area: relation/5: its outline is not closed"),
                              HasSubstr("buildings.no_area: relation/6: a part of its outline is not in the file")));
  for (const Finding& finding : findings)
    EXPECT_TRUE(bounds_of(site_of(100).area.outer).contains({finding.x_m, finding.y_m}));
  findings.clear();
  (void)io::read_surroundings({map.scratch / "a.osm"}, site_of(100), &findings);
  EXPECT_THAT(map.told(), ElementsAre(HasSubstr("surroundings.no_area: relation/8 (water): a part of its outline")));
  findings.clear();
  (void)io::read_buildings({map.scratch / "a.osm"}, site_of(5), &findings);
  EXPECT_THAT(findings, IsEmpty()) << "they lie elsewhere";
}

/// One PBF blob (https://wiki.openstreetmap.org/wiki/PBF_Format): a header whose only data field is of that number.
std::string pbf_with_field(char field) {
  const std::string data = "not packed so";
  const std::string blob = std::string{0x10, static_cast<char>(data.size()), static_cast<char>(field << 3 | 2),
                                       static_cast<char>(data.size())} +
                           data;
  const std::string header = std::string("\x0a\x09OSMHeader\x18") + static_cast<char>(blob.size());
  return std::string{0, 0, 0, static_cast<char>(header.size())} + header + blob;
}

TEST(OsmOddities, pbf_packed_otherwise_is_refused_with_what_helps) {
  const Scratch scratch;
  const auto line_for = [&](const std::string& bytes) -> std::string {
    write_bytes(scratch / "a.osm.pbf", bytes);
    try {
      (void)io::read_osm_roads(scratch / "a.osm.pbf", site_of(100), nullptr);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  for (const char field : {6, 7})  // lz4, zstd
    EXPECT_THAT(line_for(pbf_with_field(field)),
                testing::AllOf(HasSubstr("a form that is not read"), HasSubstr("osmium cat IN -o OUT.osm.pbf"),
                               testing::Not(HasSubstr("get the file again"))));
  EXPECT_THAT(line_for(pbf_with_field(3)), HasSubstr("get the file again")) << "zlib, but broken";
}

}  // namespace
}  // namespace orthodrive

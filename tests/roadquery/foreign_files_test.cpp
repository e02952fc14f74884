// SPDX-License-Identifier: Apache-2.0
// OpenDRIVE as others write it: every element of the standard in every order, and what is said of the rest.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include "roadquery/query/ground_query.hpp"
#include "roadquery/roadquery.h"
#include "roadquery/roads/road_structures.hpp"
#include "roadquery/roads/speed_limits.hpp"
#include "roadquery/surface/poly_curve.hpp"

namespace roadquery {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string straight =
    R"(<planView><geometry s="0" x="0" y="0" hdg="0" length="200"><line/></geometry></planView>)";
const std::string two_lanes =
    R"(<lanes><laneSection s="0"><left><lane id="1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></left>)"
    R"(<center><lane id="0" type="none"/></center>)"
    R"(<right><lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right></laneSection></lanes>)";

std::string road_of(const std::string& inside, const std::string& id = "1", const std::string& length = "200") {
  return "<road name=\"\" length=\"" + length + "\" id=\"" + id + "\" junction=\"-1\">" + inside + "</road>";
}

class ForeignFile : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    path_ = (std::filesystem::path(testing::TempDir()) /
             (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".xodr"))
                .string();
    std::ofstream(path_, std::ios::binary) << text;
    return path_;
  }
  RoadMap read(const std::string& inside, const std::string& header = "") {
    return read_opendrive(write("<?xml version=\"1.0\"?><OpenDRIVE><header revMajor=\"1\" revMinor=\"4\">" + header +
                                "</header>" + inside + "</OpenDRIVE>"));
  }
  ~ForeignFile() override {
    if (!path_.empty()) std::filesystem::remove(path_);
  }
  std::string path_;
};

std::string notes_of(const RoadMap& map) {
  std::string text;
  for (const ReadingNote& note : map.notes) text += note.code + ": " + note.message + "\n";
  return text;
}

TEST_F(ForeignFile, ids_may_be_any_text) {
  const auto linked = [](const std::string& a, const std::string& b) {
    return road_of("<link><successor elementType=\"road\" elementId=\"" + b + "\" contactPoint=\"start\"/></link>" +
                       straight + two_lanes,
                   a) +
           road_of("<link><predecessor elementType=\"road\" elementId=\"" + a + "\" contactPoint=\"end\"/></link>" +
                       straight + two_lanes,
                   b) +
           "<junction id=\"J\" name=\"\"><connection id=\"first\" incomingRoad=\"" + a + "\" connectingRoad=\"" + b +
           "\" contactPoint=\"start\"/><priority high=\"" + a + "\" low=\"" + b + "\"/></junction>";
  };
  for (const auto& [a, b] : {std::pair<std::string, std::string>{"road_A1", "road_B2"},
                             {"99999999999", "99999999998"},
                             {"{6f-1}", "7"},
                             {"07", "7"},
                             {"7", "-9223372036854775808"}}) {
    const RoadMap map = read(linked(a, b));
    ASSERT_EQ(map.roads.size(), 2u);
    const bool swapped = map.roads[0].successor.kind == LinkKind::none;
    const Road &first = map.roads[swapped ? 1 : 0], &second = map.roads[swapped ? 0 : 1];
    EXPECT_NE(first.id, second.id);
    EXPECT_EQ(first.successor.id, second.id);
    EXPECT_EQ(second.predecessor.id, first.id);
    EXPECT_EQ(map.junctions.at(0).connections.at(0).incoming_road, first.id);
    EXPECT_EQ(map.junctions.at(0).connections.at(0).connecting_road, second.id);
    EXPECT_EQ(map.junctions.at(0).priorities.at(0).low, second.id);
    EXPECT_EQ(first.text_id, a == "7" ? "" : a);
    EXPECT_THAT(notes_of(map), HasSubstr("opendrive.text_ids"));
  }
  EXPECT_THROW((void)read(road_of(straight + two_lanes, "a") + road_of(straight + two_lanes, "a")), std::runtime_error);
}

TEST_F(ForeignFile, text_ids_get_numbers_that_no_id_of_the_file_has) {
  const RoadMap map = read(road_of(straight + two_lanes, "b") + road_of(straight + two_lanes, "2147483647") +
                           road_of(straight + two_lanes, "a") + road_of(straight + two_lanes, "0"));
  ASSERT_EQ(map.roads.size(), 4u);
  EXPECT_EQ(map.roads[0].id, 0);
  EXPECT_EQ(map.roads[1].text_id, "a");
  EXPECT_EQ(map.roads[2].text_id, "b") << "in alphabetical order, whatever the file's";
  EXPECT_EQ(map.roads[3].id, 2147483647);
}

std::string lane(int id, const std::string& inside, const std::string& more = "") {
  return "<lane id=\"" + std::to_string(id) + "\" type=\"driving\" " + more + ">" + inside + "</lane>";
}
std::string sections(const std::string& left, const std::string& right) {
  return "<laneSection s=\"0\"><left>" + left + "</left><center><lane id=\"0\" type=\"none\"/></center><right>" +
         right + "</right></laneSection>";
}
TEST_F(ForeignFile, borders_are_widths) {
  const auto border = [](double s, double a, double b) {
    return "<border sOffset=\"" + std::to_string(s) + "\" a=\"" + std::to_string(a) + "\" b=\"" + std::to_string(b) +
           "\" c=\"0\" d=\"0\"/>";
  };
  const RoadMap map = read(road_of(
      straight + "<lanes>" +
      sections(
          lane(1, border(0, 3.5, 0.01) + border(100, 4.5, 0.0)) + lane(2, border(0, 6.0, 0.0) + border(50, 6.0, 0.02)),
          lane(-1, border(0, -3.5, 0)) + lane(-2, border(0, -6, 0)) +
              lane(-3, "<width sOffset=\"0\" a=\"2\" b=\"0\" c=\"0\" d=\"0\"/>") + lane(-4, border(0, -9, 0))) +
      "</lanes>"));
  const LaneSection& section = map.roads[0].sections[0];
  for (const double s : {0.0, 20.0, 50.0, 99.0, 100.0, 150.0}) {
    const double first = s < 100.0 ? 3.5 + 0.01 * s : 4.5, second = s < 50.0 ? 6.0 : 6.0 + 0.02 * (s - 50.0);
    EXPECT_NEAR(lane_width(section.left[0], s), first, 1e-9) << s;
    EXPECT_NEAR(lane_width(section.left[1], s), second - first, 1e-9) << s;
    EXPECT_NEAR(lane_width(section.right[0], s), 3.5, 1e-9);
    EXPECT_NEAR(lane_width(section.right[1], s), 2.5, 1e-9);
    EXPECT_NEAR(lane_width(section.right[2], s), 2.0, 1e-9);
    EXPECT_NEAR(lane_width(section.right[3], s), 1.0, 1e-9);
  }
  EXPECT_EQ(notes_of(map), "");
}

TEST_F(ForeignFile, crossfall_lets_each_half_fall_outwards) {
  const auto with = [&](const std::string& crossfall) {
    return read(road_of(straight + "<lateralProfile><superelevation s=\"0\" a=\"0.02\" b=\"0\" c=\"0\" d=\"0\"/>" +
                        crossfall + "</lateralProfile>" + two_lanes));
  };
  const RoadMap both = with(R"(<crossfall side="both" s="0" a="0.03" b="0" c="0" d="0"/>)");
  for (const double s : {0.0, 77.0, 200.0}) {
    // The halves' angles: superelevation less crossfall on the left, plus on the right.
    for (const double t : {-3.0, -1.75, 1.75, 3.0}) {
      const SurfacePoint p = surface_point(both.roads[0], s, t);
      EXPECT_NEAR(p.z, p.y * std::tan(t > 0.0 ? 0.02 - 0.03 : 0.02 + 0.03), 1e-9);
    }
  }
  const RoadMap left = with(R"(<crossfall side="left" s="0" a="0.03" b="1e-4" c="0" d="0"/>)");
  for (const double s : {0.0, 33.3, 150.0}) {
    const SurfacePoint p = surface_point(left.roads[0], s, 2.0), q = surface_point(left.roads[0], s, -2.0);
    EXPECT_NEAR(p.z, p.y * std::tan(0.02 - 0.03 - 1e-4 * s), 1e-6);
    EXPECT_NEAR(q.z, q.y * std::tan(0.02), 1e-9);
  }
  EXPECT_EQ(notes_of(both), "");
}

TEST_F(ForeignFile, road_marks_are_read_with_their_colours_and_lines) {
  const std::string lanes =
      R"(<lanes><laneSection s="0"><center><lane id="0">)"
      R"(<roadMark sOffset="0" type="solid solid" weight="bold" color="yellow"/>)"
      R"(<roadMark sOffset="9" type="Broken" color="white" width="0.15"><type name="dashes" width="0.2">)"
      R"(<line length="3" space="9" tOffset="0.1" sOffset="1" width="0.2" color="blue" rule="none"/></type>)"
      R"(<explicit><line length="2" tOffset="-0.1" sOffset="40" width="0.3"/></explicit></roadMark>)"
      R"(</lane></center><right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/>)"
      R"(<roadMark sOffset="0" type="none"/></lane></right></laneSection></lanes>)";
  const RoadMap map = read(road_of(straight + lanes));
  const LaneSection& section = map.roads[0].sections[0];
  ASSERT_EQ(section.center.marks.size(), 2u);
  const RoadMark &bold = section.center.marks[0], &written = section.center.marks[1];
  EXPECT_EQ(bold.type + ' ' + bold.color, "solid solid yellow");
  EXPECT_EQ(bold.width, 0.25);
  EXPECT_TRUE(bold.lines.empty());
  EXPECT_EQ(written.type + ' ' + written.color, "broken white");
  ASSERT_EQ(written.lines.size(), 2u);
  const RoadMarkLine &dashes = written.lines[0], &once = written.lines[1];
  EXPECT_EQ(dashes.length + dashes.space + dashes.t_offset + dashes.s_offset + dashes.width, 3 + 9 + 0.1 + 1 + 0.2);
  EXPECT_EQ(dashes.color, "blue");
  EXPECT_FALSE(dashes.is_single_stroke);
  EXPECT_EQ(once.length + once.space + once.t_offset + once.s_offset + once.width, 2 + 0 - 0.1 + 40 + 0.3);
  EXPECT_TRUE(once.is_single_stroke);
  EXPECT_EQ(section.right[0].marks[0].type, "none");
  EXPECT_EQ(notes_of(map), "");
  std::string odd = lanes;
  odd.replace(odd.find("solid solid"), 11, "solid twice");
  odd.replace(odd.find("yellow"), 6, "ochre");
  EXPECT_THAT(notes_of(read(road_of(straight + odd))),
              AllOf(HasSubstr("type=\"solid twice\""), HasSubstr("color=\"ochre\"")));
}

TEST_F(ForeignFile, what_stands_twice_or_out_of_order_is_sorted_and_the_last_one_counts) {
  const std::string elevations =
      R"(<elevationProfile><elevation s="100" a="2" b="0" c="0" d="0"/><elevation s="0" a="9" b="0" c="0" d="0"/>)"
      R"(<elevation s="0" a="1" b="0" c="0" d="0"/></elevationProfile>)";
  const std::string shapes =
      R"(<lateralProfile><superelevation s="50" a="0" b="0" c="0" d="0"/><superelevation s="0" a="0" b="0" c="0" d="0"/>)"
      R"(<shape s="100" t="0" a="0" b="0.1" c="0" d="0"/><shape s="0" t="0" a="0" b="0" c="0" d="0"/>)"
      R"(<shape s="0" t="-4" a="0" b="0" c="0" d="0"/><shape s="100.0000001" t="-4" a="0.4" b="-0.1" c="0" d="0"/>)"
      R"(<shape s="100" t="0" a="0" b="0.02" c="0" d="0"/></lateralProfile>)";
  const std::string lanes =
      R"(<lanes><laneOffset s="100" a="1" b="0" c="0" d="0"/><laneOffset s="0" a="0" b="0" c="0" d="0"/>)"
      R"(<laneSection s="120"><center><lane id="0"/></center><right><lane id="-1" type="driving"><width sOffset="0" a="5" b="0" c="0" d="0"/></lane></right></laneSection>)"
      R"(<laneSection s="0"><center><lane id="0"/></center><right><lane id="-1" type="driving">)"
      R"(<width sOffset="60" a="4" b="0" c="0" d="0"/><width sOffset="0" a="3" b="0" c="0" d="0"/>)"
      R"(<roadMark sOffset="50" type="solid"/><roadMark sOffset="0" type="broken"/>)"
      R"(<material sOffset="9" friction="0.5"/><material sOffset="3" friction="0.7"/><material sOffset="3" friction="0.6"/>)"
      R"(<height sOffset="10" inner="0.1" outer="0.1"/><height sOffset="0" inner="0" outer="0"/><height sOffset="10" inner="0.2" outer="0.2"/>)"
      R"(</lane></right></laneSection></lanes>)";
  const std::string plan =
      R"(<planView><geometry s="100" x="100" y="0" hdg="0" length="100"><line/></geometry><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>)";
  const RoadMap map = read(road_of(plan + elevations + shapes + lanes));
  const Road& road = map.roads[0];
  EXPECT_NEAR(reference_point(road, 30.0).x, 30.0, 1e-12);
  EXPECT_NEAR(reference_point(road, 130.0).x, 130.0, 1e-12);
  EXPECT_EQ(elevation(road, 10.0), 1.0);
  EXPECT_EQ(elevation(road, 110.0), 2.0);
  EXPECT_NEAR(shape(road, 150.0, 2.0).h, 0.04, 1e-12);
  EXPECT_NEAR(shape(road, 150.0, -2.0).h, 0.2, 1e-12);
  EXPECT_NEAR(shape(road, 50.0, -2.0).h, 0.1, 1e-9);
  EXPECT_EQ(evaluate(road.lane_offset, 150.0), 1.0);
  ASSERT_EQ(road.sections.size(), 2u);
  EXPECT_EQ(lane_width(road.sections[0].right[0], 70.0), 4.0);
  EXPECT_EQ(lane_width(road.sections[1].right[0], 0.0), 5.0);
  EXPECT_EQ(road.sections[0].right[0].marks[0].type, "broken");
  ASSERT_EQ(road.sections[0].right[0].materials.size(), 2u);
  EXPECT_EQ(road.sections[0].right[0].materials[0].friction, 0.6);
  ASSERT_EQ(road.sections[0].right[0].heights.size(), 2u);
  EXPECT_EQ(road.sections[0].right[0].heights[1].inner, 0.2);
  for (const char* element : {"geometry", "elevation", "superelevation", "laneOffset", "laneSection", "width",
                              "roadMark", "material", "height"})
    EXPECT_THAT(notes_of(map), HasSubstr("<" + std::string(element) + "> elements were not in order")) << element;
  for (const char* element : {"elevation", "shape", "material", "height"})
    EXPECT_THAT(notes_of(map), HasSubstr("<" + std::string(element) + "> elements stand at one place more than once"));
  EXPECT_NO_THROW(RoadQuery{map});
}

TEST_F(ForeignFile, limits_are_those_of_the_place_and_of_the_lane) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  const std::string types =
      R"(<type s="0" type="rural"><speed max="100" unit="km/h"/></type><type s="50" type="town"><speed max="30" unit="mph"/></type>)"
      R"(<type s="100" type="town"><speed max="10"/></type><type s="120" type="motorway"><speed max="no limit"/></type>)"
      R"(<type s="140" type="town"><speed max="undefined" unit="km/h"/></type><type s="160" type="town"><speed max="fast"/></type>)"
      R"(<type s="180" type="town"/>)";
  const std::string lanes =
      "<lanes>" +
      sections(lane(1, ""),
               lane(-1, R"(<speed sOffset="20" max="30" unit="km/h"/><speed sOffset="110" max="undefined"/>)"
                        R"(<speed sOffset="150" max="no limit"/>)")) +
      "</lanes>";
  const RoadMap map = read(road_of(types + straight + lanes));
  const Road& road = map.roads[0];
  const auto expect = [&](double s, double left, double right) {
    EXPECT_NEAR(lane_limit_mps(road, 1, s), left, 1e-9) << s;
    EXPECT_NEAR(lane_limit_mps(road, -1, s), right, 1e-9) << s;
  };
  expect(10.0, 100.0 / 3.6, 100.0 / 3.6);
  expect(30.0, 100.0 / 3.6, 30.0 / 3.6);
  expect(60.0, 30.0 * 0.44704, 30.0 / 3.6);
  expect(105.0, 10.0, 30.0 / 3.6);
  EXPECT_EQ(lane_limit_mps(road, 1, 130.0), inf);
  EXPECT_EQ(lane_limit_mps(road, -1, 130.0), inf) << "undefined for the lane: the road's counts";
  expect(145.0, 0.0, 0.0);
  EXPECT_EQ(lane_limit_mps(road, -1, 155.0), inf);
  EXPECT_EQ(road.speed_limit_mps, 100.0 / 3.6);
  EXPECT_THAT(notes_of(map), HasSubstr("<speed> has max=\"fast\", which is no speed"));
  EXPECT_EQ(fastest_limit_mps(road, 60.0), 30.0 * 0.44704);
}

TEST_F(ForeignFile, bridges_and_tunnels_of_the_standard_count) {
  const auto with = [&](const std::string& objects) {
    return read(road_of(straight + two_lanes + "<objects>" + objects + "</objects>"));
  };
  EXPECT_TRUE(with(R"(<bridge s="0" length="200" id="b" type="concrete"/>)").roads[0].bridge);
  EXPECT_TRUE(with(R"(<tunnel s="0" length="200" id="t" type="standard"/>)").roads[0].tunnel);
  const RoadMap map =
      with(R"(<bridge s="50" length="40" id="b" type="steel"/><tunnel s="120" length="500" id="t" type="standard"/>)");
  EXPECT_FALSE(map.roads[0].bridge || map.roads[0].tunnel);
  EXPECT_TRUE(is_on_structure(map.roads[0], 60.0) && is_on_structure(map.roads[0], 190.0));
  EXPECT_FALSE(is_on_structure(map.roads[0], 100.0));
}

TEST_F(ForeignFile, roads_are_cut_where_a_bridge_begins_and_ends) {
  const std::string first = road_of(
      R"(<link><successor elementType="road" elementId="2" contactPoint="end"/></link>)"
      R"(<planView><geometry s="0" x="0" y="0" hdg="0.3" length="120"><arc curvature="0.01"/></geometry>)"
      R"(<geometry s="120" x="100" y="0" hdg="0" length="80"><spiral curvStart="0" curvEnd="0.01"/></geometry></planView>)"
      R"(<elevationProfile><elevation s="0" a="3" b="0.02" c="1e-4" d="0"/></elevationProfile>)"
      R"(<lateralProfile><superelevation s="0" a="0.01" b="1e-4" c="0" d="0"/><shape s="0" t="-9" a="0" b="0" c="0.001" d="0"/><shape s="150" t="-9" a="0.2" b="0" c="0" d="0"/></lateralProfile>)" +
      two_lanes + R"(<objects><bridge s="40" length="60" id="b" type="concrete"/></objects>)");
  const std::string second = road_of(
      R"(<link><successor elementType="road" elementId="1" contactPoint="end"/></link>)" + straight + two_lanes, "2");
  const RoadMap map = read(first + second), cut = cut_at_structures(map);
  ASSERT_EQ(cut.roads.size(), 4u);
  const Road &a = cut.roads[0], &other = cut.roads[1], &b = cut.roads[2], &c = cut.roads[3];
  EXPECT_EQ(a.length, 40.0);
  EXPECT_EQ(b.length, 60.0);
  EXPECT_EQ(c.length, 100.0);
  EXPECT_FALSE(a.bridge || c.bridge);
  EXPECT_TRUE(b.bridge);
  EXPECT_EQ(a.successor.id, b.id);
  EXPECT_EQ(b.successor.id, c.id);
  EXPECT_EQ(c.predecessor.id, b.id);
  EXPECT_EQ(c.successor.id, 2);
  EXPECT_EQ(other.successor.id, c.id) << "what touched the road's end touches its last piece";
  for (double s = 0.5; s < 200.0; s += 3.0) {
    const Road& piece = s < 40.0 ? a : s < 100.0 ? b : c;
    const double from = s < 40.0 ? 0.0 : s < 100.0 ? 40.0 : 100.0;
    const SurfacePoint p = surface_point(map.roads[0], s, 2.0), q = surface_point(piece, s - from, 2.0);
    EXPECT_NEAR(p.x, q.x, 1e-9);
    EXPECT_NEAR(p.y, q.y, 1e-9);
    EXPECT_NEAR(p.z, q.z, 1e-9);
    EXPECT_EQ(lane_id_at(piece, s - from, 2.0), 1);
  }
  const RoadQuery query(cut);
  Cursor cursor;
  const SurfacePoint p = surface_point(map.roads[0], 70.0, 1.0);
  EXPECT_NEAR(query.find(p.x, p.y, p.z, cursor)->z, p.z, 1e-5);
}

TEST_F(ForeignFile, level_lanes_do_not_bank) {
  const std::string lanes =
      "<lanes>" +
      sections(
          lane(1, R"(<width sOffset="0" a="3" b="0" c="0" d="0"/>)", "level=\"true\""),
          lane(-1, R"(<width sOffset="0" a="3.5" b="0" c="0" d="0"/>)", "level=\"false\"") +
              lane(-2,
                   R"(<width sOffset="0" a="3" b="0.01" c="0" d="0"/><height sOffset="0" inner="0.1" outer="0.12"/>)",
                   "level=\"true\"") +
              lane(-3, R"(<width sOffset="0" a="2" b="0" c="0" d="0"/>)")) +
      "</lanes>";
  const RoadMap map = read(road_of(
      straight + R"(<lateralProfile><superelevation s="0" a="0.05" b="-2e-4" c="0" d="0"/></lateralProfile>)" + lanes));
  const Road& road = map.roads[0];
  for (const double s : {0.0, 13.0, 77.0, 199.0}) {
    const double bank = 0.05 - 2e-4 * s;
    EXPECT_NEAR(surface_height(road, s, 2.0), 0.0, 1.5e-4) << "level from the middle on";
    EXPECT_NEAR(surface_height(road, s, -2.0), -2.0 * std::sin(bank), 1e-9);
    const double width = 3.0 + 0.01 * s, level = -3.5 * std::sin(bank);
    for (const double share : {0.1, 0.9})
      EXPECT_NEAR(surface_height(road, s, -3.5 - share * width), level + 0.1 + 0.02 * share, 1.5e-4) << s;
    EXPECT_NEAR(surface_height(road, s, -3.5 - width - 1.0), level, 1.5e-4) << "lanes outside of a level one are level";
  }
}

TEST_F(ForeignFile, lanes_outside_of_a_level_one_are_said) {
  const auto notes_with = [&](const std::string& inner, const std::string& outer) {
    const std::string width = R"(<width sOffset="0" a="3" b="0" c="0" d="0"/>)";
    return notes_of(read(road_of(straight + "<lanes>" +
                                 sections("", lane(-1, width) + lane(-2, width, "level=\"" + inner + "\"") +
                                                  lane(-3, width, "level=\"" + outer + "\"")) +
                                 "</lanes>")));
  };
  EXPECT_THAT(notes_with("true", "false"), HasSubstr("opendrive.level"));
  EXPECT_EQ(notes_with("true", "true"), "");
  EXPECT_EQ(notes_with("false", "true"), "");
  EXPECT_EQ(notes_with("false", "false"), "");
}

TEST_F(ForeignFile, links_to_what_is_not_there_are_said) {
  const auto width = [](int id, const std::string& link) {
    return lane(id, link + R"(<width sOffset="0" a="3" b="0" c="0" d="0"/>)");
  };
  const auto notes_with = [&](const std::string& to, const std::string& kind, int to_lane, int from, int via_lane) {
    const auto lane_link = [](const std::string& end, int id) {
      return "<link><" + end + " id=\"" + std::to_string(id) + "\"/></link>";
    };
    const std::string first = road_of("<link><successor elementType=\"" + kind + "\" elementId=\"" + to +
                                          "\" contactPoint=\"start\"/></link>" + straight + "<lanes>" +
                                          sections("", width(-1, lane_link("successor", to_lane))) + "</lanes>",
                                      "a");
    const std::string second =
        road_of("<link><predecessor elementType=\"road\" elementId=\"a\" contactPoint=\"end\"/></link>" + straight +
                    "<lanes>" + sections("", width(-1, lane_link("predecessor", -1))) + "</lanes>",
                "b");
    return notes_of(read(first + second +
                         "<junction id=\"J\" name=\"\"><connection id=\"0\" incomingRoad=\"a\" connectingRoad=\"b\" "
                         "contactPoint=\"start\"><laneLink from=\"" +
                         std::to_string(from) + "\" to=\"" + std::to_string(via_lane) +
                         "\"/></connection></junction>"));
  };
  EXPECT_THAT(notes_with("b", "road", -1, -1, -1), Not(HasSubstr("opendrive.broken_link")));
  EXPECT_THAT(notes_with("J", "junction", -1, -1, -1), Not(HasSubstr("opendrive.broken_link")));
  EXPECT_THAT(notes_with("c", "road", -1, -1, -1), HasSubstr("name a <road> that the file does not have"));
  EXPECT_THAT(notes_with("K", "junction", -1, -1, -1), HasSubstr("name a <junction> that the file does not have"));
  for (const auto& [to_lane, from, via_lane] : {std::array{-2, -1, -1}, {-1, -2, -1}, {-1, -1, 1}})
    EXPECT_THAT(notes_with("b", "road", to_lane, from, via_lane), HasSubstr("name a <lane> that is not"));
  const RoadMap map =
      read(road_of(straight + two_lanes) +
           R"(<junction id="5" name=""><connection id="0" incomingRoad="1" connectingRoad="9"/></junction>)");
  EXPECT_THAT(notes_of(map), HasSubstr("connections of junctions name a <road>"));
  ASSERT_EQ(map.notes.size(), 1u);
  EXPECT_EQ(map.notes[0].road, 1);
}

TEST_F(ForeignFile, curves_that_begin_beside_their_place_are_said) {
  const auto notes_with = [&](const std::string& values) {
    return notes_of(
        read(road_of("<planView><geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"20\"><paramPoly3 "
                     "pRange=\"arcLength\" cU=\"0\" dU=\"0\" cV=\"0\" dV=\"0\" " +
                         values + "/></geometry></planView>" + two_lanes,
                     "1", "20")));
  };
  EXPECT_EQ(notes_with(R"(aU="0" bU="1" aV="0" bV="0")"), "");
  EXPECT_EQ(notes_with(R"(aU="1e-4" bU="1" aV="0" bV="-1e-4")"), "");
  for (const char* off : {R"(aU="1" bU="1" aV="0" bV="0")", R"(aU="0" bU="1" aV="-1" bV="0")",
                          R"(aU="0" bU="1" aV="0" bV="0.02")", R"(aU="0" bU="-1" aV="0" bV="0")"})
    EXPECT_THAT(notes_with(off), HasSubstr("opendrive.curve_start")) << off;
}

TEST_F(ForeignFile, curves_of_cubics_are_as_long_as_their_road) {
  const RoadMap map = read(road_of(
      R"(<planView><geometry s="0" x="0" y="0" hdg="0" length="20"><paramPoly3 pRange="normalized" aU="0" bU="60" cU="-80" dU="40" aV="0" bV="0" cV="0" dV="0"/></geometry></planView>)" +
          two_lanes,
      "1", "20"));
  for (double s = 0.0; s <= 20.0; s += 0.5) {
    const PlanPoint p = reference_point(map.roads[0], s);
    EXPECT_NEAR(p.x, s, 1e-9);
    EXPECT_NEAR(p.speed, 1.0, 1e-9);
  }
  const RoadQuery query(map);
  Cursor cursor;
  for (double x = 0.3; x < 20.0; x += 0.7) {
    const auto hit = query.find(x, 1.0, 0.0, cursor);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->s, x, 2e-6);
  }
}

TEST_F(ForeignFile, poly3_is_a_curve_over_its_chord) {
  const std::string poly =
      R"(<planView><geometry s="0" x="5" y="6" hdg="0.4" length="60"><poly3 a="0" b="0.1" c="0.01" d="-1e-4"/></geometry></planView>)";
  const RoadMap map = read(road_of(poly + two_lanes, "1", "60"));
  double length = 0.0;
  PlanPoint last = reference_point(map.roads[0], 0.0);
  for (int i = 1; i <= 6000; ++i) {
    const PlanPoint p = reference_point(map.roads[0], 0.01 * i);
    length += std::hypot(p.x - last.x, p.y - last.y);
    const double dx = p.x - 5.0, dy = p.y - 6.0, c = std::cos(0.4), n = std::sin(0.4), u = c * dx + n * dy;
    EXPECT_NEAR(c * dy - n * dx, u * (0.1 + u * (0.01 - 1e-4 * u)), 1e-9);
    last = p;
  }
  EXPECT_NEAR(length, 60.0, 1e-6);
}

TEST_F(ForeignFile, offset_with_a_heading_turns_the_map_about_its_origin) {
  const std::string offset = R"(<offset x="1000" y="2000" z="5" hdg="0.5"/>)";
  const RoadMap map = read(road_of(straight + two_lanes), offset);
  const SurfacePoint p = surface_point(map.roads[0], 100.0, 2.0);
  EXPECT_NEAR(p.x, 1000.0 + 100.0 * std::cos(0.5) - 2.0 * std::sin(0.5), 1e-9);
  EXPECT_NEAR(p.y, 2000.0 + 100.0 * std::sin(0.5) + 2.0 * std::cos(0.5), 1e-9);
  EXPECT_NEAR(p.z, 5.0, 1e-9);
  const RoadMap back = read_opendrive(path_, HeaderOffset::subtract);
  const SurfacePoint q = surface_point(back.roads[0], 0.0, 0.0);
  EXPECT_NEAR(std::cos(0.5) * q.x - std::sin(0.5) * q.y + 1000.0, 0.0, 1e-9);
  EXPECT_NEAR(std::sin(0.5) * q.x + std::cos(0.5) * q.y + 2000.0, 0.0, 1e-9);
  EXPECT_NEAR(reference_point(back.roads[0], 0.0).hdg, -0.5, 1e-12);
}

TEST_F(ForeignFile, names_may_have_a_prefix) {
  std::string text =
      "<OpenDRIVE xmlns=\"\"><header revMajor=\"1\" revMinor=\"7\"/>" + road_of(straight + two_lanes) + "</OpenDRIVE>";
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos; ++at)
    text.insert(at + (text[at + 1] == '/' ? 2 : 1), "odr:");
  text.replace(text.find("xmlns=\"\""), 8, "xmlns:odr=\"http://example.org/a\" xmlns:v=\"http://example.org/b\"");
  text.insert(text.find("<odr:lanes"), "<v:lanes><v:laneSection s=\"0\"/></v:lanes>");
  const RoadMap map = read_opendrive(write("<?xml version=\"1.0\"?>" + text));
  ASSERT_EQ(map.roads.size(), 1u);
  EXPECT_EQ(map.roads[0].sections.size(), 1u) << "elements of another namespace are nobody's";
  EXPECT_EQ(map.roads[0].sections[0].left.size(), 1u);
  EXPECT_THAT(notes_of(map), HasSubstr("opendrive.unknown_element"));
}

TEST_F(ForeignFile, other_encodings_are_read) {
  const std::string body =
      "<OpenDRIVE><header revMajor=\"1\" revMinor=\"4\" name=\"Stra\xdf"
      "e \x80\"/>" +
      road_of(straight + two_lanes) + "</OpenDRIVE>";
  const RoadMap named = read_opendrive(write("<?xml version=\"1.0\" encoding=\"windows-1252\"?>" + body));
  EXPECT_EQ(named.name, "Straße €");
  EXPECT_EQ(notes_of(named), "");
  const RoadMap unnamed = read_opendrive(write("<?xml version=\"1.0\"?>" + body));
  EXPECT_EQ(unnamed.name, "Straße €");
  EXPECT_THAT(notes_of(unnamed), HasSubstr("opendrive.encoding"));
  const RoadMap other = read_opendrive(write("<?xml version=\"1.0\" encoding=\"GB2312\"?>" + body));
  EXPECT_EQ(other.roads.size(), 1u);
  EXPECT_THAT(notes_of(other), HasSubstr("the encoding GB2312 is not known"));
  EXPECT_THROW((void)read_opendrive(write("<?xml version=\"1.0\" encoding=\"UTF-32\"?>" + body)), std::runtime_error);
}

TEST_F(ForeignFile, lanes_closed_to_cars_are_not_driven) {
  const auto type_with = [&](const std::string& access) {
    const RoadMap map = read(road_of(straight + "<lanes>" + sections("", lane(-1, access)) + "</lanes>"));
    return map.roads[0].sections[0].right[0].type;
  };
  const std::pair<const char*, LaneType> all_closed[] = {
      {R"(<access sOffset="0" rule="allow" restriction="bus"/>)", LaneType::bus},
      {R"(<access sOffset="0" rule="deny" restriction="passengerCar"/>)", LaneType::other},
      {R"(<access sOffset="1.000" rule="allow" restriction="bus"/><access sOffset="1.0000009" rule="allow" restriction="taxi"/>)",
       LaneType::bus},
      {R"(<access sOffset="0" rule="allow"><restriction type="bus"/><restriction type="bicycle"/></access>)",
       LaneType::other},
      {R"(<access sOffset="0" rule="deny"><restriction type="truck"/><restriction type="passengerCar"/></access>)",
       LaneType::other}};
  for (const auto& [closed, type] : all_closed) EXPECT_EQ(type_with(closed), type) << closed;
  for (
      const char* open :
      {"", R"(<access sOffset="0" rule="deny" restriction="truck"/>)", R"(<access sOffset="0" restriction="none"/>)",
       R"(<access sOffset="0" rule="allow" restriction="bus"/><access sOffset="0" rule="allow" restriction="passengerCar"/>)",
       R"(<access sOffset="0" rule="allow" restriction="none"/>)",
       R"(<access sOffset="150" rule="allow" restriction="bus"/>)"})
    EXPECT_EQ(type_with(open), LaneType::driving) << open;
}

TEST_F(ForeignFile, access_that_allows_and_denies_at_one_place_is_said) {
  const auto notes_with = [&](const char* second) {
    return notes_of(
        read(road_of(straight + "<lanes>" +
                     sections("", lane(-1, std::string(R"(<access sOffset="0" rule="allow" restriction="bus"/>)") +
                                               second + R"(<width sOffset="0" a="3" b="0" c="0" d="0"/>)")) +
                     "</lanes>")));
  };
  EXPECT_THAT(notes_with(R"(<access sOffset="9e-7" rule="deny" restriction="truck"/>)"), HasSubstr("at one place"));
  EXPECT_THAT(notes_with(R"(<access sOffset="50" rule="deny" restriction="truck"/>)"), Not(HasSubstr("at one place")));
  EXPECT_EQ(notes_with(R"(<access sOffset="0" rule="allow" restriction="taxi"/>)"), "");
}

TEST_F(ForeignFile, unknown_versions_are_said) {
  const auto notes_with = [&](const std::string& header) {
    return notes_of(read_opendrive(write("<OpenDRIVE>" + header + road_of(straight + two_lanes) + "</OpenDRIVE>")));
  };
  for (const char* known : {"0", "1", "4", "8"})
    EXPECT_EQ(notes_with(std::string("<header revMajor=\"1\" revMinor=\"") + known + "\"/>"), "");
  for (const char* unknown : {"<header/>", R"(<header revMajor="1"/>)", R"(<header revMajor="1" revMinor="seven"/>)",
                              R"(<header revMajor="0" revMinor="8"/>)", R"(<header revMajor="1" revMinor="9"/>)"})
    EXPECT_THAT(notes_with(unknown), HasSubstr("opendrive.version: <header> has revMajor=")) << unknown;
  EXPECT_THAT(notes_with(""), HasSubstr("opendrive.version: the file has no <header>"));
}

TEST_F(ForeignFile, friction_of_0_is_none) {
  const RoadMap map = read(road_of(
      straight + "<lanes>" +
      sections("", lane(-1, R"(<material sOffset="0" surface="0" friction="0.0" roughness="0.0"/>)")) + "</lanes>"));
  EXPECT_EQ(map.roads[0].sections[0].right[0].materials.at(0).friction, 1.0);
  EXPECT_THAT(notes_of(map), HasSubstr("opendrive.friction"));
}

TEST_F(ForeignFile, nothing_is_passed_over_in_silence) {
  const RoadMap map = read(
      road_of(
          straight + R"(<lanes>)" +
          sections("",
                   lane(-1, R"(<width sOffset="0" a="3" b="0" c="0" d="0"/><include file="a"/><include file="b"/>)")) +
          R"(</lanes><signals><signal s="1"/><signal s="2"/></signals><objects><object type="tree" s="1" t="1"><repeat/></object><object type="crosswalk" s="1" t="1" length="4" width="3"><surface/></object></objects><planVeiw/>)") +
      R"(<junction id="5" name=""><surface><CRG/></surface><elevationGrid/></junction><controller id="1"/>)");
  const std::string notes = notes_of(map);
  EXPECT_THAT(notes, HasSubstr("<object/surface> is not read"));
  EXPECT_THAT(
      notes,
      HasSubstr("<lane/include> is not read: what the other file holds is not there; put it into this one (2 times"));
  EXPECT_THAT(notes, HasSubstr("<junction/surface> is not read"));
  EXPECT_THAT(notes, HasSubstr("<junction/elevationGrid> is not read"));
  EXPECT_THAT(notes, HasSubstr("<OpenDRIVE/controller> (1), <objects/object> (1), <signals/signal> (2)"));
  EXPECT_THAT(notes, HasSubstr("look for misspelt names: <road/planVeiw> (1)"));
  EXPECT_EQ(map.notes.size(), 6u) << notes << "one line for each kind";
}

TEST_F(ForeignFile, a_road_has_a_surface_of_its_own) {
  const std::string over = road_of(
      R"(<planView><geometry s="0" x="50" y="-50" hdg="1.5707963267948966" length="100"><line/></geometry></planView>)"
      R"(<elevationProfile><elevation s="0" a="1.4" b="0" c="0" d="0"/></elevationProfile>)" +
          two_lanes,
      "2", "100");
  write("<?xml version=\"1.0\"?><OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/>" + road_of(straight + two_lanes) +
        over + "</OpenDRIVE>");
  rq_map* map = nullptr;
  ASSERT_EQ(rq_load(path_.c_str(), nullptr, &map, nullptr, 0), RQ_OK);
  rq_pose pose;
  EXPECT_EQ(rq_position(map, 1, 50.0, 1.0, &pose), RQ_ROAD);
  EXPECT_NEAR(pose.z, 0.0, 1e-9);
  EXPECT_EQ(rq_position(map, 2, 50.0, 1.0, &pose), RQ_ROAD);
  EXPECT_NEAR(pose.z, 1.4, 1e-9);
  rq_hit hit;
  for (const double guess : {0.0, 1.4}) {
    rq_cursor cursor = RQ_CURSOR_START;
    EXPECT_GT(rq_query(map, &cursor, 50.5, 1.0, guess, RQ_ALL, &hit), 0);
    EXPECT_GT(hit.z, 0.2) << "a wheel stands on both, blended";
    EXPECT_LT(hit.z, 1.2);
    for (const unsigned what : {RQ_ALL | RQ_OWN, RQ_OWN | 0}) {
      rq_cursor at = RQ_CURSOR_START;
      hit.road_id = -1;
      EXPECT_GT(rq_query(map, &at, 50.5, 1.0, guess, what | RQ_POSITION, &hit), 0);
      EXPECT_NEAR(hit.z, hit.road_id == 1 ? 0.0 : 1.4, 1e-6) << "the road's own";
    }
  }
  EXPECT_EQ(rq_note_count(map), 0);
  EXPECT_EQ(rq_note(map, 0), nullptr);
  EXPECT_STREQ(rq_road_text_id(map, 1), "");
  EXPECT_EQ(rq_road_text_id(map, 9), nullptr);
  rq_free(map);
}

std::string lane_of(const std::string& attributes, const std::string& inside = "") {
  return "<lane " + attributes + "><width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/>" + inside + "</lane>";
}

TEST_F(ForeignFile, access_and_direction_stand_for_types_of_lanes) {
  const auto allow = [](const std::string& who) {
    return "<access sOffset=\"0\" rule=\"allow\"><restriction type=\"" + who + "\"/></access>";
  };
  const RoadMap map = read(road_of(
      straight + "<lanes><laneSection s=\"0\"><left>" + lane_of("id=\"1\" type=\"driving\" direction=\"both\"") +
      lane_of("id=\"2\" type=\"biking\" direction=\"both\"") +
      "</left><center><lane id=\"0\" type=\"none\"/></center><right>" +
      lane_of("id=\"-1\" type=\"driving\"", allow("bus") + allow("taxi")) +
      lane_of("id=\"-2\" type=\"driving\"", allow("taxi")) + lane_of("id=\"-3\" type=\"driving\"", allow("bicycle")) +
      lane_of("id=\"-4\" type=\"driving\"", allow("truck")) +
      lane_of("id=\"-5\" type=\"driving\" direction=\"both\"", allow("bus")) +
      lane_of("id=\"-6\" type=\"driving\" advisory=\"outer\" roadWorks=\"false\" direction=\"reversed\"") +
      "</right></laneSection></lanes>"));
  const LaneSection& section = map.roads.at(0).sections.at(0);
  EXPECT_EQ(section.left[0].type, LaneType::bidirectional);
  EXPECT_EQ(section.left[1].type, LaneType::biking);
  const std::vector<LaneType> types = {LaneType::bus,   LaneType::taxi, LaneType::biking,
                                       LaneType::other, LaneType::bus,  LaneType::driving};
  for (std::size_t i = 0; i < types.size(); ++i) EXPECT_EQ(section.right[i].type, types[i]) << i;
  EXPECT_EQ(section.right[0].allowed, (std::vector<std::string>{"bus", "taxi"}));
  EXPECT_TRUE(section.right[5].allowed.empty());
  EXPECT_THAT(notes_of(map), HasSubstr("opendrive.lane_direction: driving lanes have direction=\"reversed\""));
  EXPECT_THAT(notes_of(map), HasSubstr("opendrive.not_read: <lane> has advisory=\"outer\""));
  EXPECT_EQ(notes_of(map).find("roadWorks"), std::string::npos);
}

TEST_F(ForeignFile, a_section_of_a_single_side_leaves_the_other_one) {
  const std::string center = "<center><lane id=\"0\" type=\"none\"/></center>";
  const auto section = [&](const std::string& attributes, const std::string& sides) {
    return "<laneSection " + attributes + ">" + center + sides + "</laneSection>";
  };
  const RoadMap map = read(
      road_of(straight + "<lanes>" +
              section("s=\"0\"", "<left>" + lane_of("id=\"1\" type=\"driving\"") + "</left><right>" +
                                     lane_of("id=\"-1\" type=\"driving\"",
                                             "<width sOffset=\"50\" a=\"3\" b=\"0.01\" c=\"0\" d=\"0\"/>"
                                             "<speed sOffset=\"10\" max=\"+50\" unit=\"km/h\"/>"
                                             "<link><successor id=\"-2\"/></link>") +
                                     "</right>") +
              section("s=\"80\" singleSide=\"true\"", "<left/>") +
              section("s=\"120\" singleSide=\"1\"", "<left>" + lane_of("id=\"1\" type=\"driving\"") + "</left>") +
              section("s=\"160\" singleSide=\"false\"", "<left>" + lane_of("id=\"1\" type=\"driving\"") + "</left>") +
              "</lanes>"));
  const Road& road = map.roads.at(0);
  for (const double s : {20.0, 60.0, 100.0, 150.0})
    EXPECT_NEAR(road_edges(road, s).right_t, -3.0 - 0.01 * std::max(0.0, s - 50.0), 1e-12) << s;
  EXPECT_EQ(road_edges(road, 180.0).right_t, 0.0);
  EXPECT_EQ(road_edges(road, 100.0).left_t, 0.0) << "an empty side is a side";
  EXPECT_EQ(road_edges(road, 130.0).left_t, 3.0);
  EXPECT_NEAR(lane_limit_mps(road, -1, 130.0), 50.0 / 3.6, 1e-12);
  EXPECT_EQ(road.sections[0].right[0].successor, -1);
  EXPECT_EQ(road.sections[1].right[0].predecessor, -1);
  EXPECT_EQ(road.sections[2].right[0].successor, -2) << "behind the end of its last part";
}

TEST_F(ForeignFile, a_road_cut_at_a_bridge_keeps_what_begins_before_the_cut) {
  // One entry behind the cut, one that goes over it, one before: the middle one must stay.
  const RoadMap map = cut_at_structures(
      read(road_of(straight +
                   "<elevationProfile><elevation s=\"0\" a=\"1\" b=\"0\" c=\"0\" d=\"0\"/>"
                   "<elevation s=\"50\" a=\"2\" b=\"0\" c=\"0\" d=\"0\"/>"
                   "<elevation s=\"150\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></elevationProfile>" +
                   two_lanes + "<objects><bridge id=\"b\" s=\"100\" length=\"90\" type=\"steel\"/></objects>")));
  ASSERT_EQ(map.roads.size(), 3u);
  EXPECT_EQ(elevation(map.roads[1], 20.0), 2.0);
  EXPECT_EQ(elevation(map.roads[1], 70.0), 3.0);
}

/// Coefficients of one element: "s a b c d" of each.
std::string coefficients(const std::string& name, const std::vector<std::array<double, 5>>& all) {
  std::string text = "<" + name + ">";
  for (const auto& c : all) {
    text += "<coefficients s=\"" + std::to_string(c[0]) + "\"";
    const char* names[] = {"", "a", "b", "c", "d"};
    for (std::size_t i = 1; i < 5; ++i)
      if (c[i] != 0.0) text += std::string(" ") + names[i] + "=\"" + std::to_string(c[i]) + "\"";
    text += "/>";
  }
  return text + "</" + name + ">";
}

TEST_F(ForeignFile, strips_of_a_cross_section_surface_are_the_surface) {
  const auto file = [&](const std::string& mode) {
    return read(road_of(
        straight + "<lateralProfile><crossSectionSurface>" + coefficients("tOffset", {{0, 0.5, 0.002}}) +
        "<surfaceStrips><strip id=\"1\">" + coefficients("width", {{0, 3.0, 0, 0.0001}}) +
        coefficients("constant", {{0, 0.1, 0.001}}) + coefficients("linear", {{0, -0.02}, {100, -0.04, 0.0002}}) +
        coefficients("quadratic", {{0, 0.001}}) + coefficients("cubic", {{0, 0.0002}}) + "</strip><strip id=\"2\"" +
        mode + ">" + coefficients("constant", {{0, 0.15}}) + coefficients("linear", {{0, 0.05}}) +
        "</strip><strip id=\"-1\">" + coefficients("linear", {{0, 0.03, 0, 0.000001}}) +
        "</strip></surfaceStrips></crossSectionSurface></lateralProfile>" + two_lanes));
  };
  // OpenDRIVE 1.8, 10.5, "Calculation".
  const auto expected = [](double s, double t, bool relative) {
    const double dt = t - (0.5 + 0.002 * s), width = 3.0 + 0.0001 * s * s;
    const double linear = s < 100.0 ? -0.02 : -0.04 + 0.0002 * (s - 100.0);
    const auto inner = [&](double x) { return 0.1 + 0.001 * s + linear * x + 0.001 * x * x + 0.0002 * x * x * x; };
    if (dt <= 0.0) return (0.03 + 1e-6 * s * s) * dt;
    if (dt <= width) return inner(dt);
    return 0.15 + 0.05 * (dt - width) + (relative ? inner(width) : 0.0);
  };
  for (const bool relative : {false, true}) {
    const RoadMap map = file(relative ? " mode=\"relative\"" : "");
    EXPECT_EQ(notes_of(map), "");
    for (double s = 0.0; s <= 200.0; s += 1.7)
      for (double t = -9.0; t < 12.0; t += 0.37) {
        const double dt = t - (0.5 + 0.002 * s), width = 3.0 + 0.0001 * s * s;
        // A step moves across the road: rows are linear in between.
        if (std::abs(dt) < 0.05 || std::abs(dt - width) < 0.6) continue;
        EXPECT_NEAR(shape(map.roads[0], s, t).h, expected(s, t, relative), 3e-4) << s << ", " << t;
      }
  }
}

TEST_F(ForeignFile, strips_that_cannot_be_used_are_said) {
  const std::string strip = "<crossSectionSurface><surfaceStrips><strip id=\"1\">" +
                            coefficients("constant", {{0, 0.5}}) + "</strip><strip id=\"2\"/><strip id=\"3\"/>" +
                            "</surfaceStrips></crossSectionSurface>";
  const RoadMap alone = read(road_of(straight + "<lateralProfile>" + strip + "</lateralProfile>" + two_lanes));
  EXPECT_THAT(notes_of(alone), HasSubstr("a <strip> has the id 3, need 1, 2, -1 or -2"));
  EXPECT_THAT(notes_of(alone), HasSubstr("an outer <strip> is passed over, as the inner one has no <width>"));
  EXPECT_EQ(shape(alone.roads[0], 50.0, 3.0).h, 0.5);
  EXPECT_EQ(shape(alone.roads[0], 50.0, -3.0).h, 0.0) << "a side without strips";
  const RoadMap beside =
      read(road_of(straight + "<lateralProfile><superelevation s=\"0\" a=\"0\" b=\"0\" c=\"0\" d=\"0\"/>" + strip +
                   "<shape s=\"0\" t=\"0\" a=\"2\" b=\"0\" c=\"0\" d=\"0\"/></lateralProfile>" + two_lanes));
  EXPECT_EQ(shape(beside.roads[0], 50.0, 3.0).h, 2.0);
  EXPECT_THAT(notes_of(beside), HasSubstr("<crossSectionSurface> is passed over where a road has <shape>, too"));
  EXPECT_THAT(notes_of(beside), HasSubstr("stands beside <superelevation>, both count"));
}

}  // namespace
}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
// Files that break a rule of OpenDRIVE which bears on links, lanes, limits or paint: each kind is said, with its place.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct LaneText {
  int id = 0;
  double width_m = 3.5;
  std::string link;  ///< what stands in its <link>
  std::string more;  ///< attributes
};

std::string text_of(const LaneText& lane) {
  return "<lane id=\"" + std::to_string(lane.id) + "\" type=\"driving\" " + lane.more + "><link>" + lane.link +
         "</link><width sOffset=\"0\" a=\"" + std::to_string(lane.width_m) + "\" b=\"0\" c=\"0\" d=\"0\"/></lane>";
}

std::string section_of(double s, const std::vector<LaneText>& lanes) {
  std::string left, right;
  for (const LaneText& lane : lanes) (lane.id > 0 ? left : right) += text_of(lane);
  return "<laneSection s=\"" + std::to_string(s) + "\"><left>" + left +
         "</left><center><lane id=\"0\" type=\"none\"/></center><right>" + right + "</right></laneSection>";
}

struct RoadText {
  std::string id = "1";
  double x = 0.0, y = 0.0;
  std::string link, sections, more;
  std::string junction = "-1";
  std::string attributes;
};

/// East, 100 m.
std::string text_of(const RoadText& road) {
  return "<road id=\"" + road.id + "\" length=\"100\" junction=\"" + road.junction + "\" " + road.attributes +
         "><link>" + road.link + "</link><planView><geometry s=\"0\" x=\"" + std::to_string(road.x) + "\" y=\"" +
         std::to_string(road.y) + "\" hdg=\"0\" length=\"100\"><line/></geometry></planView><lanes>" + road.sections +
         "</lanes>" + road.more + "</road>";
}

RoadMap read_text(const std::string& inside) {
  const auto file = std::filesystem::path(testing::TempDir()) /
                    (std::string("defects_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".xodr");
  std::ofstream(file) << "<OpenDRIVE><header revMajor=\"1\" revMinor=\"8\"/>" << inside << "</OpenDRIVE>";
  RoadMap map = read_opendrive(file.string());
  std::filesystem::remove(file);
  return map;
}

/// Empty where nothing of that kind is said.
std::string said(const RoadMap& map, const std::string& code) {
  for (const ReadingNote& note : map.notes)
    if (note.code == code) return note.message + " @" + std::to_string(note.road) + ":" + std::to_string(int(note.s));
  return "";
}

const std::string link_after = R"(<successor elementType="road" elementId="2" contactPoint="start"/>)";
const std::string link_before = R"(<predecessor elementType="road" elementId="1" contactPoint="end"/>)";

TEST(Defects, roads_that_are_linked_but_do_not_meet_are_said) {
  const auto with = [](double x, double y, const std::string& link) {
    return said(read_text(text_of(RoadText{"1", 0.0, 0.0, link, section_of(0, {{-1}})}) +
                          text_of(RoadText{"2", x, y, link_before, section_of(0, {{-1}})})),
                "opendrive.wrong_link");
  };
  EXPECT_EQ(with(100.0, 0.0, link_after), "");
  EXPECT_EQ(with(100.05, 0.0, link_after), "") << "rounded";
  EXPECT_THAT(with(100.0, -3.5, link_after), HasSubstr("do not meet at their contactPoint"));
  EXPECT_THAT(with(100.0, -3.5, link_after), HasSubstr("@1:100"));
  const std::string other_end = R"(<successor elementType="road" elementId="2" contactPoint="end"/>)";
  EXPECT_THAT(with(100.0, 0.0, other_end), HasSubstr("do not meet"));
}

TEST(Defects, lanes_linked_to_what_lies_beside_them_are_said) {
  const auto within = [](int to, double width_m) {
    const std::string link = "<successor id=\"" + std::to_string(to) + "\"/>";
    return said(read_text(text_of(RoadText{"1", 0.0, 0.0, "",
                                           section_of(0, {{-1}, {-2, width_m, link}}) + section_of(40, {{-1}, {-2}})})),
                "opendrive.wrong_link");
  };
  EXPECT_EQ(within(-2, 3.5), "");
  EXPECT_THAT(within(-1, 3.5), HasSubstr("lie beside each other"));
  EXPECT_THAT(within(-1, 3.5), HasSubstr("@1:40"));
  EXPECT_EQ(within(-1, 0.2), "") << "a lane that has narrowed merges";
  // From one road to the next, whose reference line runs the other way: lane -1 goes on as lane 1.
  const auto turned = [](int to) {
    const std::string road_link = R"(<successor elementType="road" elementId="2" contactPoint="end"/>)";
    const std::string link = "<successor id=\"" + std::to_string(to) + "\"/>";
    const std::string second =
        R"(<road id="2" length="100" junction="-1"><planView><geometry s="0" x="200" y="0" hdg="3.14159265358979")"
        R"( length="100"><line/></geometry></planView><lanes>)" +
        section_of(0, {{-1}, {1}}) + "</lanes></road>";
    return said(read_text(text_of(RoadText{"1", 0.0, 0.0, road_link, section_of(0, {{-1, 3.5, link}})}) + second),
                "opendrive.wrong_link");
  };
  EXPECT_EQ(turned(1), "");
  EXPECT_THAT(turned(-1), HasSubstr("lie beside each other"));
}

TEST(Defects, connections_against_the_direction_of_a_lane_are_said) {
  const auto with = [](const std::string& contact, int to, const std::string& attributes) {
    return said(
        read_text(text_of(RoadText{"1", 0.0, 0.0, "", section_of(0, {{-1}, {1}})}) +
                  text_of(RoadText{"5", 100.0, 0.0, "", section_of(0, {{-1}, {1}}), "", "7", attributes}) +
                  R"(<junction id="7"><connection id="0" incomingRoad="1" connectingRoad="5" contactPoint=")" +
                  contact + "\"><laneLink from=\"-1\" to=\"" + std::to_string(to) + "\"/></connection></junction>"),
        "opendrive.wrong_link");
  };
  EXPECT_EQ(with("start", -1, ""), "");
  EXPECT_EQ(with("end", 1, ""), "");
  EXPECT_THAT(with("end", -1, ""), HasSubstr("against its direction"));
  EXPECT_THAT(with("end", -1, ""), HasSubstr("@5:100"));
  EXPECT_THAT(with("start", 1, ""), HasSubstr("against its direction"));
  EXPECT_EQ(with("start", 1, "rule=\"LHT\""), "");
  EXPECT_THAT(with("start", -1, "rule=\"LHT\""), HasSubstr("against its direction"));
}

TEST(Defects, level_lanes_that_go_on_without_it_are_said) {
  const auto with = [](const std::string& level, const std::string& profile) {
    const std::string link = R"(<successor id="-1"/>)";
    return read_text(text_of(RoadText{
        "1", 0.0, 0.0, "", section_of(0, {{-1, 3.5, link, "level=\"true\""}}) + section_of(40, {{-1, 3.5, "", level}}),
        profile}));
  };
  EXPECT_EQ(said(with("level=\"true\"", ""), "opendrive.level"), "");
  EXPECT_THAT(said(with("", ""), "opendrive.level"), HasSubstr("linked to lanes without it"));
  const auto matters = [&](const std::string& profile) {
    for (const ReadingNote& note : with("level=\"false\"", profile).notes)
      if (note.code == "opendrive.level") return note.matters;
    return false;
  };
  EXPECT_FALSE(matters(""));
  EXPECT_TRUE(matters(R"(<lateralProfile><superelevation s="0" a="0.05" b="0" c="0" d="0"/></lateralProfile>)"));
}

TEST(Defects, an_offset_beside_borders_is_said) {
  const auto with = [](double offset_m) {
    return read_text(text_of(RoadText{
        "1", 0.0, 0.0, "",
        "<laneOffset s=\"0\" a=\"" + std::to_string(offset_m) +
            R"(" b="0" c="0" d="0"/><laneSection s="0"><center><lane id="0" type="none"/></center><right>)"
            R"(<lane id="-1" type="driving"><border sOffset="0" a="-3.5" b="0" c="0" d="0"/></lane></right></laneSection>)"}));
  };
  EXPECT_EQ(said(with(0.0), "opendrive.border_offset"), "");
  EXPECT_THAT(said(with(1.0), "opendrive.border_offset"), HasSubstr("@1:0"));
  EXPECT_NEAR(lane_width(with(1.0).roads[0].sections[0].right[0], 10.0), 4.5, 1e-9);
}

TEST(Defects, priorities_without_one_of_both_roads_are_said) {
  const auto with = [](const std::string& priority) {
    return read_text(
        text_of(RoadText{"1", 0.0, 0.0, "", section_of(0, {{-1}})}) +
        text_of(RoadText{"5", 100.0, 0.0, "", section_of(0, {{-1}}), "", "7"}) +
        R"(<junction id="7"><connection id="0" incomingRoad="1" connectingRoad="5" contactPoint="start"/>)" + priority +
        "</junction>");
  };
  const RoadMap good = with(R"(<priority high="1" low="5"/>)");
  EXPECT_EQ(said(good, "opendrive.priority"), "");
  EXPECT_EQ(good.junctions[0].priorities.size(), 1u);
  for (const char* odd : {R"(<priority high="1"/>)", R"(<priority low="5" high=" "/>)", "<priority/>"}) {
    EXPECT_THAT(said(with(odd), "opendrive.priority"), HasSubstr("@5:0")) << odd;
    EXPECT_TRUE(with(odd).junctions[0].priorities.empty()) << odd;
  }
}

TEST(Defects, outlines_of_a_single_corner_give_way_to_the_box) {
  const auto with = [](const std::string& box, const std::string& corners) {
    return read_text(
        text_of(RoadText{"1", 0.0, 0.0, "", section_of(0, {{-1}}),
                         "<objects><object type=\"crosswalk\" s=\"30\" t=\"0\" " + box + "><outlines><outline>" +
                             corners + "</outline></outlines></object></objects>"}));
  };
  const std::string box = R"(length="4" width="7")", corner = R"(<cornerRoad s="30" t="1"/>)",
                    other = R"(<cornerRoad s="34" t="-1"/>)";
  EXPECT_EQ(said(with(box, corner + other), "opendrive.object_outline"), "");
  EXPECT_EQ(said(with(box, ""), "opendrive.object_outline"), "");
  const RoadMap single = with(box, corner);
  EXPECT_THAT(said(single, "opendrive.object_outline"), HasSubstr("single corner"));
  EXPECT_THAT(said(single, "opendrive.object_outline"), HasSubstr("@1:30"));
  EXPECT_TRUE(single.roads[0].objects.at(0).outline.empty());
  EXPECT_THAT(said(with("", ""), "opendrive.object_outline"), HasSubstr("it is not drawn"));
}

TEST(Defects, a_surface_within_an_object_that_is_passed_over_is_said) {
  const auto with = [](const std::string& inside) {
    return said(read_text(text_of(RoadText{
                    "1", 0.0, 0.0, "", section_of(0, {{-1}}),
                    "<objects><object type=\"roadSurface\" s=\"30\" t=\"0\">" + inside + "</object></objects>"})),
                "opendrive.not_read");
  };
  EXPECT_EQ(with("<repeat/>"), "");
  EXPECT_THAT(with(R"(<surface><CRG file="a.crg"/></surface>)"), HasSubstr("OpenCRG file of the object is not laid"));
}

}  // namespace
}  // namespace roadquery

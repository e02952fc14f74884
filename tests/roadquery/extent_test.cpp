// SPDX-License-Identifier: Apache-2.0
// Elements that begin late, have no length or do not fit their road, as writers round and cut them, and empty links
// (docs/notes/trackers.md has the reports).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "roadquery/surface/road_surface.hpp"

namespace roadquery {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string one_lane(int id, const std::string& inside) {
  return "<lane id=\"" + std::to_string(id) + "\" type=\"driving\">" + inside + "</lane>";
}
const std::string wide_lane = R"(<width sOffset="0" a="3.5" b="0" c="0" d="0"/>)";

std::string one_section(double s, const std::string& right) {
  return "<laneSection s=\"" + std::to_string(s) + "\"><center><lane id=\"0\" type=\"none\"/></center><right>" + right +
         "</right></laneSection>";
}

/// Parts of a straight road of 200 m; those that a test does not change are in order.
struct Parts {
  std::string link, elevation, sections = one_section(0.0, one_lane(-1, wide_lane)), length = "200",
                               geometry = R"(<geometry s="0" x="0" y="0" hdg="0" length="200"><line/></geometry>)";
};

class RoadExtent : public testing::Test {
 protected:
  RoadMap read(const Parts& parts) {
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".xodr");
    std::ofstream(path_) << "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/><road length=\"" << parts.length
                         << "\" id=\"1\" junction=\"-1\"><link>" << parts.link << "</link><planView>" << parts.geometry
                         << "</planView><elevationProfile>" << parts.elevation << "</elevationProfile><lanes>"
                         << parts.sections << "</lanes></road></OpenDRIVE>";
    RoadMap map = read_opendrive(path_);
    notes_.clear();
    for (const ReadingNote& note : map.notes) notes_ += note.code + ": " + note.message + "\n";
    return map;
  }
  ~RoadExtent() override { std::filesystem::remove(path_); }
  std::filesystem::path path_;
  std::string notes_;
};

TEST_F(RoadExtent, of_an_ordinary_road_says_nothing) {
  read({.elevation = R"(<elevation s="0" a="7" b="0.1" c="0" d="0"/>)"});
  EXPECT_EQ(notes_, "");
}

TEST_F(RoadExtent, the_first_elevation_holds_from_the_start) {
  const RoadMap map = read({.elevation = R"(<elevation s="50" a="7" b="0.1" c="0" d="0"/>)"});
  EXPECT_NEAR(evaluate(map.roads[0].elevation, 0.0), 2.0, 1e-12) << "as esmini and libOpenDRIVE go on";
  EXPECT_NEAR(evaluate(map.roads[0].elevation, 60.0), 8.0, 1e-12);
  EXPECT_THAT(notes_, HasSubstr("opendrive.begins_late: the first <elevation>"));
}

TEST_F(RoadExtent, the_first_section_and_width_hold_from_the_start) {
  const RoadMap map =
      read({.sections = one_section(0.5, one_lane(-1, R"(<width sOffset="0" a="3" b="0.1" c="0" d="0"/>)") +
                                             one_lane(-2, R"(<width sOffset="2" a="4" b="0" c="0" d="0"/>)"))});
  const LaneSection& first = map.roads[0].sections.at(0);
  EXPECT_EQ(first.s, 0.0);
  EXPECT_NEAR(evaluate(first.right.at(0).width, 0.0), 2.95, 1e-12);
  EXPECT_NEAR(evaluate(first.right.at(0).width, 10.5), 4.0, 1e-12) << "where it was";
  EXPECT_NEAR(evaluate(first.right.at(1).width, 0.0), 4.0, 1e-12);
  EXPECT_THAT(notes_, HasSubstr("the first <laneSection> begins"));
  EXPECT_THAT(notes_, HasSubstr("the first <width> begins"));
}

TEST_F(RoadExtent, sections_without_length_are_left_out_and_linked_through) {
  const auto linked = [](int id, const std::string& before, const std::string& after) {
    return one_lane(id, "<link>" + (before.empty() ? "" : "<predecessor id=\"" + before + "\"/>") +
                            (after.empty() ? "" : "<successor id=\"" + after + "\"/>") + "</link>" + wide_lane);
  };
  const RoadMap map =
      read({.sections = one_section(0.0, linked(-1, "", "-2")) +
                        one_section(100.0, linked(-1, "", "") + linked(-2, "-1", "-3")) +
                        one_section(100.0, linked(-1, "", "") + linked(-2, "", "") + linked(-3, "-2", "-1")) +
                        one_section(200.0, linked(-1, "-3", "-5")) + one_section(260.0, linked(-1, "", ""))});
  const auto& sections = map.roads[0].sections;
  ASSERT_EQ(sections.size(), 2u) << "one of two at 100 m, and those at and behind the end have no length";
  EXPECT_EQ(sections[0].right.at(0).successor, -3);
  EXPECT_EQ(sections[1].right.at(2).predecessor, -1);
  EXPECT_EQ(sections[1].right.at(2).successor, -5) << "into the next road";
  EXPECT_THAT(notes_, HasSubstr("opendrive.no_length: <laneSection> elements"));
}

TEST_F(RoadExtent, geometry_without_length_is_left_out) {
  const RoadMap map =
      read({.geometry = R"(<geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>)"
                        R"(<geometry s="100" x="100" y="0" hdg="0" length="0"><arc curvature="0.1"/></geometry>)"
                        R"(<geometry s="100" x="100" y="0" hdg="0" length="100"><line/></geometry>)"});
  EXPECT_EQ(map.roads[0].plan.size(), 2u);
  EXPECT_THAT(notes_, HasSubstr("opendrive.no_length: <geometry> elements"));
  EXPECT_THAT(notes_, Not(HasSubstr("opendrive.road_length")));
}

TEST_F(RoadExtent, lengths_that_contradict_each_other_are_told) {
  read({.length = "200.5"});
  EXPECT_THAT(notes_, HasSubstr("opendrive.road_length: a road is longer than its <geometry>"));
  read({.length = "150"});
  EXPECT_THAT(notes_, HasSubstr("opendrive.road_length: a road is shorter than its <geometry>"));
  read({.length = "200.004"});
  EXPECT_EQ(notes_, "") << "rounded";
  read({.geometry = R"(<geometry s="0" x="0" y="0" hdg="0" length="90"><line/></geometry>)"
                    R"(<geometry s="100" x="100" y="0" hdg="0" length="100"><line/></geometry>)"});
  EXPECT_THAT(notes_, HasSubstr("opendrive.road_length: <geometry> elements do not follow"));
}

TEST_F(RoadExtent, lanes_without_width_or_narrower_than_nothing_are_told) {
  const RoadMap map = read({.sections = one_section(0.0, one_lane(-1, wide_lane) + one_lane(-2, ""))});
  EXPECT_EQ(evaluate(map.roads[0].sections[0].right.at(1).width, 50.0), 0.0);
  EXPECT_THAT(notes_, HasSubstr("opendrive.no_width"));
  read({.sections = one_section(0.0, one_lane(-1, R"(<width sOffset="0" a="3" b="-0.02" c="0" d="0"/>)"))});
  EXPECT_THAT(notes_, HasSubstr("opendrive.negative_width"));
  read({.sections = one_section(0.0, one_lane(-1, R"(<width sOffset="0" a="0" b="-0.02" c="0.0001" d="0"/>)"))});
  EXPECT_THAT(notes_, HasSubstr("opendrive.negative_width")) << "in between only";
  read({.sections = one_section(0.0, one_lane(-1, R"(<width sOffset="0" a="3" b="-0.015005" c="0" d="0"/>)"))});
  EXPECT_EQ(notes_, "") << "a millimetre past 0 is rounding";
}

TEST_F(RoadExtent, links_that_are_empty_link_to_nothing) {
  for (const std::string attributes : {"", R"( elementType="road" elementId="" contactPoint="start")"}) {
    const RoadMap map = read(
        {.link = "<predecessor" + attributes + "/><successor/>",
         .sections = one_section(0.0, one_lane(-1, "<link><predecessor/><successor id=\"\"/></link>" + wide_lane))});
    EXPECT_EQ(map.roads[0].predecessor.kind, LinkKind::none);
    EXPECT_FALSE(map.roads[0].sections[0].right.at(0).successor);
    EXPECT_THAT(notes_, HasSubstr("opendrive.empty_link"));
  }
}

}  // namespace
}  // namespace roadquery

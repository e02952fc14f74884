// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "paths.hpp"
#include "roadquery/query/road_query.hpp"

namespace roadquery {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;

std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

const std::string arc_file = orthodrive::paths::in_source("tests/roadquery/arc.xodr").string();

/// A temporary file with this text.
class TemporaryXodr {
 public:
  explicit TemporaryXodr(const std::string& text)
      : path_(std::filesystem::temp_directory_path() /
              (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + "_" +
               std::to_string(counter_++) + ".xodr")) {
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~TemporaryXodr() { std::filesystem::remove(path_); }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  static inline int counter_ = 0;
  std::filesystem::path path_;
};

std::string error_of(const std::string& path) {
  try {
    (void)read_opendrive(path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

/// The arc file with one piece of text replaced.
std::string error_with(const std::string& from, const std::string& to) {
  std::string text = slurp(arc_file);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const TemporaryXodr file(text);
  return error_of(file.path());
}

TEST(ReadOpenDrive, holds_what_the_file_says) {
  const RoadMap map = read_opendrive(arc_file);
  EXPECT_EQ(map.name, "arc");
  EXPECT_EQ(map.geo_reference, "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs");
  EXPECT_EQ(map.east, 110.0);
  ASSERT_EQ(map.roads.size(), 1u);
  const Road& road = map.roads[0];
  EXPECT_EQ(road.id, 7);
  EXPECT_EQ(road.name, "Quarter");
  EXPECT_EQ(road.junction, -1);
  EXPECT_EQ(road.driving_side, roadquery::DrivingSide::right);
  EXPECT_EQ(road.predecessor.kind, LinkKind::none);
  EXPECT_EQ(road.successor.kind, LinkKind::road);
  EXPECT_EQ(road.successor.id, 7);
  ASSERT_EQ(road.plan.size(), 1u);
  EXPECT_EQ(std::get<Arc>(road.plan[0].shape).curvature, 0.01);
  EXPECT_NEAR(elevation(road, 100.0), 22.0, 1e-12);
  ASSERT_EQ(road.sections.size(), 1u);
  ASSERT_EQ(road.sections[0].right.size(), 2u);  // sorted outwards although the file is not
  EXPECT_EQ(road.sections[0].right[0].id, -1);
  EXPECT_EQ(road.sections[0].right[0].successor, -1);
  EXPECT_EQ(road.sections[0].right[0].marks.at(0).type, "solid");
  EXPECT_EQ(road.sections[0].right[1].type, LaneType::shoulder);
  EXPECT_EQ(road.sections[0].center.marks.at(0).type, "broken");
  EXPECT_EQ(road.osm_id, "4711");
  EXPECT_EQ(road.highway, "tertiary");
  EXPECT_EQ(road.layer, 1);
  EXPECT_TRUE(road.bridge);
  EXPECT_FALSE(road.tunnel);
}

TEST(ReadOpenDrive, header_offset_moves_the_roads) {
  std::string text = slurp(arc_file);
  text.replace(text.find("</header>"), 9, "<offset x=\"1000\" y=\"2000\" z=\"5\" hdg=\"0\"/></header>");
  const TemporaryXodr file(text);
  const RoadMap map = read_opendrive(file.path());
  EXPECT_EQ(map.roads[0].plan[0].x, 1000.0);
  EXPECT_EQ(map.roads[0].plan[0].y, 2000.0);
  EXPECT_EQ(elevation(map.roads[0], 0.0), 25.0);
  EXPECT_EQ(map.west, 1000.0);
}

TEST(ReadOpenDrive, header_offset_can_be_ignored_or_subtracted) {
  std::string text = slurp(arc_file);
  text.replace(text.find("</header>"), 9, "<offset x=\"1000\" y=\"2000\" z=\"5\" hdg=\"0\"/></header>");
  const TemporaryXodr file(text);
  const RoadMap ignored = read_opendrive(file.path(), HeaderOffset::ignore);
  EXPECT_EQ(ignored.roads[0].plan[0].x, 0.0);
  EXPECT_EQ(elevation(ignored.roads[0], 0.0), 20.0);
  EXPECT_EQ(ignored.header_offset_m, (std::array<double, 3>{1000.0, 2000.0, 5.0}));
  const RoadMap subtracted = read_opendrive(file.path(), HeaderOffset::subtract);
  EXPECT_EQ(subtracted.roads[0].plan[0].y, -2000.0);
  EXPECT_EQ(elevation(subtracted.roads[0], 0.0), 15.0);
}

TEST(ReadOpenDrive, header_offset_with_a_heading_can_be_ignored) {
  std::string text = slurp(arc_file);
  text.replace(text.find("</header>"), 9, "<offset x=\"1000\" y=\"2000\" z=\"5\" hdg=\"0.5\"/></header>");
  const TemporaryXodr file(text);
  EXPECT_EQ(read_opendrive(file.path(), HeaderOffset::ignore).header_offset_hdg, 0.5);
  EXPECT_EQ(read_opendrive(file.path(), HeaderOffset::ignore).roads[0].plan[0].x, 0.0);
  EXPECT_EQ(read_opendrive(file.path()).roads[0].plan[0].hdg, 0.5);
}

TEST(ReadOpenDrive, errors_name_file_line_and_remedy) {
  EXPECT_THAT(error_of("/no/such.xodr"), EndsWith("/no/such.xodr: cannot be opened: No such file or directory"));
  const TemporaryXodr empty(""), text("hello"), other("<?xml version='1.0'?>\n<osm/>"),
      none("<OpenDRIVE>\n</OpenDRIVE>");
  EXPECT_THAT(error_of(empty.path()), EndsWith("line 1: no element found, the file ends too early: get it whole"));
  EXPECT_THAT(error_of(text.path()), EndsWith("line 1: syntax error, this is no XML: mend the file there"));
  EXPECT_THAT(error_of(other.path()), EndsWith("line 2: the root element is <osm>, not <OpenDRIVE>"));
  EXPECT_THAT(error_of(none.path()), EndsWith("no <road> in the file"));
  const TemporaryXodr truncated(slurp(arc_file).substr(0, 700));
  EXPECT_THAT(error_of(truncated.path()), EndsWith("line 12: unclosed token, the file ends too early: get it whole"));

  EXPECT_THAT(error_with("length=\"157.0796326794897\"><arc", "><arc"),
              EndsWith("line 10: <geometry> lacks the attribute length"));
  EXPECT_THAT(error_with("curvature=\"0.01\"", "curvature=\"1/100\""),
              EndsWith("line 10: <arc> has curvature=\"1/100\", which is not a number"));
  EXPECT_THAT(error_with("curvature=\"0.01\"", "curvature=\"nan\""), HasSubstr("which is not a number"));
  EXPECT_THAT(error_with("lane id=\"-2\"", "lane id=\"A7\""),
              HasSubstr("<lane> has id=\"A7\", which is not an integer"));
  EXPECT_THAT(error_with("<arc curvature=\"0.01\"/>", ""), HasSubstr("line 10: <geometry> without a shape"));
  EXPECT_THAT(error_with("<lane id=\"1\"", "<lane id=\"-1\""), HasSubstr("line 15: lane -1 stands under <left>"));
}

TEST(ReadOpenDrive, misplaced_elements_are_passed_over_or_refused) {
  std::string text = slurp(arc_file);
  for (std::size_t at = 0; (at = text.find("planView", at)) != std::string::npos;) text.replace(at, 8, "planVeiw");
  const TemporaryXodr misspelt(text);
  EXPECT_THAT(error_of(misspelt.path()), HasSubstr("road 7 has no <geometry> in a <planView>"));
  EXPECT_THAT(error_with("<laneSection s=\"0\">", "<x><laneSection s=\"0\"></laneSection></x><laneSection s=\"0\">"),
              EndsWith("no error"));
  EXPECT_THAT(error_with("<left>", "<laneSection s=\"0\"/><lanes><laneSection s=\"0\"/></lanes><left>"),
              EndsWith("no error"));
  EXPECT_THAT(error_with("</lane></left>", "<lanes><laneSection s=\"0\"/></lanes><width/></lane></left>"),
              EndsWith("<width> lacks the attribute sOffset"));  // what stands in the lane by mistake is nobody's
  EXPECT_THAT(error_with("</header>",
                         "</header><junction id=\"1\"><a><connection><laneLink from=\"1\" to=\"1\"/>"
                         "</connection></a></junction>"),
              EndsWith("no error"));
  EXPECT_THAT(error_with("lane id=\"-2\"", "lane id=\"-2147483648\""), HasSubstr("a lane has the id -2147483648"));
}

TEST(ReadOpenDrive, roads_without_bounds_are_refused) {
  EXPECT_THAT(error_with("length=\"157.0796326794897\" id", "length=\"1e12\" id"), HasSubstr("longer than 1000 km"));
  const auto query_error_with = [](const std::string& from, const std::string& to) -> std::string {
    std::string text = slurp(arc_file);
    text.replace(text.find(from), from.size(), to);
    const TemporaryXodr file(text);
    try {
      const RoadQuery query(read_opendrive(file.path()));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(query_error_with("curvature=\"0.01\"", "curvature=\"1e300\""), HasSubstr("road 7 turns more than"));
  EXPECT_THAT(query_error_with("x=\"0\" y=\"0\"", "x=\"1e300\" y=\"0\""), HasSubstr("road 7 leaves the area"));
  EXPECT_THAT(query_error_with("a=\"3.5\"", "a=\"1e9\""), HasSubstr("road 7 is wider than 1 km"));
  EXPECT_THAT(query_error_with("<arc curvature=\"0.01\"/>", "<spiral curvStart=\"6e110\" curvEnd=\"0.05\"/>"),
              HasSubstr("road 7 turns more than"));
  EXPECT_THAT(query_error_with("<arc curvature=\"0.01\"/>",
                               "<paramPoly3 pRange=\"arcLength\" aU=\"0\" bU=\"1\" cU=\"0\" dU=\"0.5\" aV=\"0\" "
                               "bV=\"0\" cV=\"0\" dV=\"0.5\"/>"),
              HasSubstr("road 7 has a line more than 100 times as long as it says"));
}

TEST(ReadOpenDrive, other_peoples_files_are_read_and_join_up) {
  const std::string folder = orthodrive::paths::in_source("../shared/data/opendrive/samples/").string();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no sample files at " << folder;
  struct Sample {
    const char* name;
    std::size_t roads, junctions;
  };
  for (const Sample& sample : {Sample{"esmini_fabriksgatan.xodr", 16, 1},
                               Sample{"esmini_multi_intersections.xodr", 63, 5}, Sample{"qc_positive18.xodr", 43, 8}}) {
    const RoadMap map = read_opendrive(folder + sample.name);
    EXPECT_EQ(map.roads.size(), sample.roads) << sample.name;
    EXPECT_EQ(map.junctions.size(), sample.junctions) << sample.name;
    for (const Road& road : map.roads) {
      for (std::size_t i = 1; i < road.plan.size(); ++i) {
        // The writers of these files place each element at the end of the one before: our spirals, arcs and polynomials
        // must end there too.
        const PlanPoint end = evaluate(road.plan[i - 1], road.plan[i - 1].length);
        EXPECT_NEAR(end.x, road.plan[i].x, 2e-5) << sample.name << " road " << road.id;
        EXPECT_NEAR(end.y, road.plan[i].y, 2e-5) << sample.name << " road " << road.id;
      }
    }
  }
}

}  // namespace
}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
// Scenes of roads alone, of chosen roads, and drives along plain centre lines.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/run_tool.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

/// A hilly circle of 300 m without geoReference; without lanes if there are none.
void write_circle(const fs::path& file, const std::string& lanes) {
  write_bytes(file, R"(<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="6"/>
<road id="1" length="314.1592653589793" junction="-1" name="Circle">
<link><predecessor elementType="road" elementId="1" contactPoint="end"/>
<successor elementType="road" elementId="1" contactPoint="start"/></link>
<planView><geometry s="0" x="0" y="0" hdg="0" length="314.1592653589793"><arc curvature="0.02"/></geometry></planView>
<elevationProfile><elevation s="0" a="5" b="0" c="6e-4" d="-2.5464790894703255e-6"/>
<elevation s="157.07963267948966" a="9.935" b="0" c="-6e-4" d="2.5464790894703255e-6"/></elevationProfile>
<lanes><laneSection s="0">)" +
                        lanes +
                        "<center><lane id=\"0\" type=\"none\"/></center></laneSection></lanes></road></OpenDRIVE>");
}

constexpr const char* left_lane =
    R"(<left><lane id="1" type="driving"><width sOffset="0" a="6" b="0" c="0" d="0"/></lane></left>)";

int lines_of(const std::string& text) { return static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

double road_m2(const std::string& summary) {
  const std::size_t end = summary.find(" m2 of road");
  const std::size_t begin = summary.rfind(' ', end - 1);
  return std::stod(summary.substr(begin, end - begin));
}

TEST(Landscape, roads_of_a_file_without_place_are_all_that_a_scene_needs) {
  const Scratch scratch;
  write_circle(scratch / "any.xodr", left_lane);
  std::map<std::string, std::string> first;
  for (const std::string threads : {"1", "3"}) {
    const ToolRun run = run_tool(
        {"--threads", threads, "scene", "--network", scratch / "any.xodr", "--margin", "100", "-o", scratch / "scene"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("scene.local_frame: the roads have no geoReference"));
    EXPECT_NEAR(road_m2(run.err), 314.16 * 6.0 * (47.0 / 50.0), 5.0);
    if (first.empty()) first = snapshot(scratch / "scene");
    EXPECT_EQ(snapshot(scratch / "scene"), first);
  }
  const auto tileset = nlohmann::json::parse(bytes_of(scratch / "scene/tileset.json"));
  const auto origin = tileset["asset"]["extras"]["orthodrive"]["origin"];
  EXPECT_NEAR(origin[0].get<double>(), 0.0, 2.0);
  EXPECT_NEAR(origin[1].get<double>(), 50.0, 2.0);
  EXPECT_GE(origin[2].get<double>(), 4.0);
  EXPECT_LE(origin[2].get<double>(), 10.0);
}

TEST(Landscape, roads_are_chosen_by_their_names_whatever_the_case) {
  const Scratch scratch;
  write_circle(scratch / "any.xodr", left_lane);
  const auto with = [&](const char* name) {
    return run_tool(
        {"scene", "--network", scratch / "any.xodr", "--margin", "20", "--roads", name, "-o", scratch / "scene"});
  };
  const ToolRun circle = with("circle");
  EXPECT_EQ(circle.exit_code, 0) << circle.err;
  EXPECT_NEAR(road_m2(circle.err), 314.16 * 6.0 * (47.0 / 50.0), 5.0);
  EXPECT_EQ(with("circ").exit_code, 2);
}

TEST(Landscape, georeference_that_nobody_understands_is_told_and_does_without) {
  const Scratch scratch;
  write_circle(scratch / "any.xodr", left_lane);
  std::string text = bytes_of(scratch / "any.xodr");
  const std::string header = R"(<header revMajor="1" revMinor="6"/>)";
  text.replace(text.find(header), header.size(),
               "<header revMajor=\"1\" revMinor=\"6\"><geoReference>+lat_0=49 +lon_0=8</geoReference></header>");
  write_bytes(scratch / "any.xodr", text);
  const ToolRun run = run_tool({"scene", "--network", scratch / "any.xodr", "-o", scratch / "scene"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("geoReference \"+lat_0=49 +lon_0=8\" is not understood"));
}

TEST(Landscape, drive_leaves_out_the_track_that_nobody_can_place) {
  const Scratch scratch;
  write_circle(scratch / "any.xodr", left_lane);
  std::string text = bytes_of(scratch / "any.xodr");
  const std::string header = R"(<header revMajor="1" revMinor="6"/>)";
  for (const char* reference :
       {"", "<geoReference>+lat_0=49 +lon_0=8</geoReference>", "<geoReference>LOCAL</geoReference>"}) {
    std::string with = text;
    with.replace(with.find(header), header.size(),
                 "<header revMajor=\"1\" revMinor=\"6\">" + std::string(reference) + "</header>");
    write_bytes(scratch / "with.xodr", with);
    const ToolRun run = run_tool({"drive", "--network", scratch / "with.xodr", "-o", scratch / "drive"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("drive.no_gpx"));
    EXPECT_TRUE(fs::exists(scratch / "drive/report.html"));
    EXPECT_FALSE(fs::exists(scratch / "drive/lap.gpx"));
    fs::remove_all(scratch / "drive");
  }
}

TEST(Landscape, labels_without_a_photo_and_maps_without_a_place_are_refused) {
  const Scratch scratch;
  write_circle(scratch / "any.xodr", left_lane);
  write_bytes(scratch / "map.osm", "<osm/>");
  const Arguments scene = {"--quiet", "scene", "--network", scratch / "any.xodr", "-o", scratch / "scene"};
  const auto with = [&](const char* option, const char* file) {
    Arguments all = scene;
    all.insert(all.end(), {option, scratch / file});
    return run_tool(all);
  };
  const ToolRun labels = with("--labels", "labels.tif");
  EXPECT_EQ(labels.exit_code, 2);
  EXPECT_EQ(lines_of(labels.err), 1) << labels.err;
  EXPECT_THAT(labels.err, HasSubstr("--labels changes nothing without --photo"));
  const ToolRun trees = with("--trees", "map.osm");
  EXPECT_EQ(trees.exit_code, 1);
  EXPECT_EQ(lines_of(trees.err), 1) << trees.err;
  EXPECT_THAT(trees.err, HasSubstr("any.xodr: has no geoReference"));
  EXPECT_FALSE(fs::exists(scratch / "scene"));
}

/// A synthetic site with its true roads as OpenDRIVE.
struct SiteOfRoads {
  Scratch scratch;
  fs::path site = scratch / "site", network = scratch / "roads.xodr";
  SiteOfRoads() {
    EXPECT_EQ(run_tool({"--quiet", "synth", "--seed", "5", "--size", "300", "--gsd", "0.5", "-o", site}).exit_code, 0);
    EXPECT_EQ(run_tool({"--quiet", "network", "--roads", site / "truth/roads.gpkg", "-o", network}).exit_code, 0);
  }
  [[nodiscard]] ToolRun scene(const Arguments& more) const {
    Arguments all = {"scene", "--network", network, "-o", scratch / "scene"};
    all.insert(all.end(), more.begin(), more.end());
    return run_tool(all);
  }
};

TEST(Landscape, photo_and_terrain_each_do_without_the_other) {
  const SiteOfRoads made;
  const Arguments photo = {"--photo", made.site / "ortho.tif"}, dtm = {"--dtm", made.site / "dtm_1m.tif"};
  for (const Arguments& given : {photo, dtm}) {
    const ToolRun run = made.scene(given);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, Not(HasSubstr("scene.local_frame")));
    EXPECT_TRUE(fs::exists(made.scratch / "scene/tileset.json"));
  }
}

TEST(Landscape, roads_without_a_place_lie_where_the_photo_or_terrain_has_their_coordinates) {
  const SiteOfRoads made;
  std::string text = bytes_of(made.network);
  const std::size_t begin = text.find("<geoReference>"), end = text.find("</geoReference>");
  ASSERT_NE(end, std::string::npos);
  write_bytes(made.network, text.erase(begin, end + 15 - begin));
  for (const Arguments& given :
       {Arguments{"--photo", made.site / "ortho.tif"}, Arguments{"--dtm", made.site / "dtm_1m.tif"}}) {
    const ToolRun run = made.scene(given);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("scene.crs_of_ground"));
  }
}

TEST(Landscape, terrain_elsewhere_is_an_error) {
  const SiteOfRoads made;
  std::string text = bytes_of(made.network);
  const std::size_t zone = text.find("+zone=33");
  ASSERT_NE(zone, std::string::npos);
  write_bytes(made.network, text.replace(zone, 8, "+zone=34"));
  const ToolRun run = made.scene({"--dtm", made.site / "dtm_10m.tif"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("dtm_10m.tif: shares no ground with the roads of "));
}

TEST(Landscape, only_chosen_roads_are_cut_into_the_ground) {
  const SiteOfRoads made;
  const Arguments sources = {"--photo", made.site / "ortho.tif", "--dtm", made.site / "dtm_1m.tif"};
  const auto with = [&](const std::string& roads) {
    Arguments all = sources;
    all.insert(all.end(), {"--roads", roads});
    return made.scene(all);
  };
  const ToolRun whole = made.scene(sources);
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  const roadquery::RoadMap map = roadquery::read_opendrive(made.network.string());
  ASSERT_FALSE(map.roads.front().osm_id.empty());
  const ToolRun one = with("way/" + map.roads.front().osm_id);
  ASSERT_EQ(one.exit_code, 0) << one.err;
  EXPECT_LT(road_m2(one.err), 0.8 * road_m2(whole.err));
  EXPECT_GT(road_m2(one.err), 100.0);
  const ToolRun by_id = with(std::to_string(map.roads.front().id));
  EXPECT_EQ(by_id.exit_code, 0) << by_id.err;
  EXPECT_LE(road_m2(by_id.err), road_m2(one.err));
  std::string all_classes;
  std::set<std::string> classes;
  for (const roadquery::Road& road : map.roads)
    if (road.junction < 0 && classes.insert(road.highway).second)
      all_classes += (all_classes.empty() ? "highway/" : ",highway/") + road.highway;
  const ToolRun all = with(all_classes);
  EXPECT_DOUBLE_EQ(road_m2(all.err), road_m2(whole.err));
  for (const char* nobody : {"99999", "way/99999", "highway/motorway", "Nowhere"}) {
    const ToolRun refused = with(nobody);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr(std::string("--roads ") + nobody + ": no road "));
  }
}

TEST(CentreLine, of_a_road_without_lanes_is_driven_and_drawn) {
  const Scratch scratch;
  write_circle(scratch / "line.xodr", "");
  const ToolRun drive = run_tool({"drive", "--network", scratch / "line.xodr", "--bare-width", "8", "--max-lateral",
                                  "5", "-o", scratch / "drive"});
  ASSERT_EQ(drive.exit_code, 0) << drive.err;
  EXPECT_THAT(drive.err, HasSubstr("drive.bare_roads at 0.0, 0.0: 1 roads have no lanes and are 8 m wide"));
  // Every place of the lap lies on the circle and on its profile.
  std::istringstream lap(bytes_of(scratch / "drive/lap.csv"));
  std::string line;
  std::getline(lap, line);
  std::vector<std::string> names;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const std::size_t x = column("x_m"), y = column("y_m"), z = column("z_m");
  ASSERT_LT(std::max({x, y, z}), names.size());
  int rows = 0;
  double low = 1e9, high = -1e9;
  while (std::getline(lap, line)) {
    std::vector<double> values;
    std::istringstream row(line);
    for (std::string value; std::getline(row, value, ',');) values.push_back(std::strtod(value.c_str(), nullptr));
    EXPECT_NEAR(std::hypot(values[x], values[y] - 50.0), 50.0, 0.5);
    low = std::min(low, values[z]), high = std::max(high, values[z]), ++rows;
  }
  EXPECT_GT(rows, 500);
  EXPECT_NEAR(low, 5.0, 0.1);
  EXPECT_NEAR(high, 9.935, 0.1);
  const ToolRun scene =
      run_tool({"scene", "--network", scratch / "line.xodr", "--bare-width", "8", "-o", scratch / "scene"});
  ASSERT_EQ(scene.exit_code, 0) << scene.err;
  EXPECT_NEAR(road_m2(scene.err), 314.16 * 8.0, 5.0);
}

TEST(Landscape, what_cannot_be_driven_is_said_with_its_file) {
  const Scratch scratch;
  const auto write_straight = [&](const std::string& length, const std::string& type) {
    write_bytes(
        scratch / "short.xodr",
        R"(<OpenDRIVE><header revMajor="1" revMinor="6"/><road id="1" junction="-1" length=")" + length +
            R"("><planView><geometry s="0" x="0" y="0" hdg="0" length=")" + length +
            R"("><line/></geometry></planView><lanes><laneSection s="0"><center><lane id="0" type="none"/></center>)" +
            R"(<right><lane id="-1" type=")" + type +
            R"("><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right></laneSection></lanes></road></OpenDRIVE>)");
  };
  const auto line = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {
        "-q", "drive", "--network", (scratch / "short.xodr").string(), "-o", (scratch / "drive").string()};
    words.insert(words.end(), more.begin(), more.end());
    const ToolRun run = run_tool(words);
    EXPECT_EQ(run.exit_code, 1) << run.err;
    EXPECT_EQ(lines_of(run.err), 1) << run.err;
    return run.err;
  };
  const std::string file = (scratch / "short.xodr").string() + ": ";
  write_straight("5", "driving");
  const ToolRun run = run_tool({"drive", "--network", scratch / "short.xodr", "-o", scratch / "drive"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out + run.err, HasSubstr("drive.too_short at 0.0, 0.0: the route is only 5.0 m long"));
  write_straight("50", "sidewalk");
  EXPECT_THAT(line({}), HasSubstr(file + "the road network has no lane that a car can drive on"));
  EXPECT_THAT(line({"--all-roads"}), HasSubstr(file + "the road network has no lane that a car can drive on"));
}

}  // namespace
}  // namespace orthodrive

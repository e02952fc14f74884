// SPDX-License-Identifier: Apache-2.0
// The road networks of whole sites before three readers of OpenDRIVE that others keep: ASAM's checker, CARLA's map and
// SUMO's traffic. tools/setup --peers installs the first two.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>

#include "io/scratch.hpp"
#include "opendrive_peers.hpp"
#include "paths.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;
using roadquery::Lane;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;

const fs::path peers = paths::in_source("build/peers/opendrive/bin");
const fs::path scripts = paths::in_source("tests/built_sites");

class Readers : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    xodr = fs::path(paths::test_sites) / GetParam() / "roads.xodr";
    if (!fs::exists(xodr)) GTEST_SKIP() << "SKIPPED: " << xodr << " was not built, its data is missing";
  }
  fs::path xodr;
  Scratch scratch;
};

ToolRun ask(const char* script, const Arguments& arguments) {
  Arguments command{(peers / "python").string(), (scripts / script).string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_program(command);
}

TEST_P(Readers, asam_checker_finds_no_error) {
  if (!fs::exists(peers / "qc_opendrive")) GTEST_SKIP() << "SKIPPED: no ASAM checker, run tools/setup --peers";
  const ToolRun run = ask("asam_checker.py", {"qc_opendrive", xodr.string(), (scratch / "result.xqar").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
  const json result = json::parse(run.out);
  EXPECT_GE(result.at("completed").get<int>(), 20) << run.out;
  EXPECT_EQ(result.at("errors"), json::array()) << run.out.substr(0, 2000);
}

TEST(AsamChecker, finds_the_error_of_a_broken_file) {
  if (!fs::exists(peers / "qc_opendrive")) GTEST_SKIP() << "SKIPPED: no ASAM checker, run tools/setup --peers";
  const fs::path village = fs::path(paths::test_sites) / "village" / "roads.xodr";
  if (!fs::exists(village)) GTEST_SKIP() << "SKIPPED: " << village << " was not built";
  const Scratch scratch;
  // The second element of a reference line starts somewhere else than where the first ends.
  const std::string text =
      std::regex_replace(bytes_of(village), std::regex("(</geometry>\\s*<geometry [^>]*x=\")([^\"]+)"), "$010",
                         std::regex_constants::format_first_only);
  write_bytes(scratch / "broken.xodr", text);
  const ToolRun run =
      ask("asam_checker.py", {"qc_opendrive", (scratch / "broken.xodr").string(), (scratch / "result.xqar").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
  EXPECT_FALSE(json::parse(run.out).at("errors").empty());
}

TEST_P(Readers, asam_checker_finds_no_error_in_the_scenario_of_the_lap) {
  if (!fs::exists(peers / "qc_openscenario")) GTEST_SKIP() << "SKIPPED: no ASAM checker, run tools/setup --peers";
  const fs::path scenario = xodr.parent_path() / "drive" / "lap.xosc";
  if (!fs::exists(scenario)) GTEST_SKIP() << "SKIPPED: " << GetParam() << " was not driven";
  const std::string lap = bytes_of(scenario);
  const auto check = [&](const std::string& text) {
    write_bytes(scratch / "lap.xosc", text);
    const ToolRun run = ask("asam_checker.py",
                            {"qc_openscenario", (scratch / "lap.xosc").string(), (scratch / "result.xqar").string()});
    EXPECT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
    return json::parse(run.out);
  };
  const json result = check(lap);
  EXPECT_GE(result.at("completed").get<int>(), 15) << result;
  EXPECT_EQ(result.at("errors"), json::array());
  // The test can fail: a word that the schema does not know.
  const std::string broken =
      std::regex_replace(lap, std::regex("followingMode=\"position\""), "followingMode=\"sideways\"");
  EXPECT_NE(check(broken).at("errors"), json::array());
}

/// ASAM's checker knows XSD 1.1, in which the schema of 1.8 is written. It takes ten minutes for the 20 MB of a town.
TEST(AsamChecker, finds_no_error_in_junction_grids_of_1_8) {
  const fs::path xodr = fs::path(paths::test_sites) / "village" / "roads.xodr";
  if (!fs::exists(xodr)) GTEST_SKIP() << "SKIPPED: " << xodr << " was not built";
  const Scratch scratch;
  if (!fs::exists(peers / "qc_opendrive")) GTEST_SKIP() << "SKIPPED: no ASAM checker, run tools/setup --peers";
  const std::string grids = (scratch / "grids.xodr").string();
  const ToolRun made = run_program({paths::tool, "network", "--roads", (xodr.parent_path() / "roads.gpkg").string(),
                                    "-o", grids, "--opendrive", "1.8", "--junction-grids"});
  ASSERT_EQ(made.exit_code, 0) << made.err.substr(0, 2000);
  const std::string text = bytes_of(grids);
  EXPECT_NE(text.find("<elevationGrid"), std::string::npos);
  const ToolRun run = ask("asam_checker.py", {"qc_opendrive", grids, (scratch / "result.xqar").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
  EXPECT_EQ(json::parse(run.out).at("errors"), json::array()) << run.out.substr(0, 2000);
  // The test can fail: a segment that is neither a lane nor a joint.
  write_bytes(scratch / "broken.xodr",
              std::regex_replace(text, std::regex("segment type=\"joint\""), "segment type=\"kerb\"",
                                 std::regex_constants::format_first_only));
  const ToolRun broken =
      ask("asam_checker.py", {"qc_opendrive", (scratch / "broken.xodr").string(), (scratch / "broken.xqar").string()});
  ASSERT_EQ(broken.exit_code, 0) << broken.err.substr(0, 2000);
  EXPECT_FALSE(json::parse(broken.out).at("errors").empty());
}

bool drives_along(const Road& road, const Lane& lane) {
  return (lane.id < 0) == (road.driving_side == roadquery::DrivingSide::right);
}

template <typename F>
void for_driving_lanes(const Road& road, F&& f) {
  for (const auto* side : {&road.sections.front().left, &road.sections.front().right})
    for (const Lane& lane : *side)
      if (lane.type == roadquery::LaneType::driving) f(lane);
}

/// Middle of a lane: t.
double middle_t(const Road& road, const Lane& wanted, double s) {
  double t = roadquery::evaluate(road.lane_offset, s);
  const double side = wanted.id > 0 ? 1.0 : -1.0;
  for (const Lane& lane : wanted.id > 0 ? road.sections.front().left : road.sections.front().right) {
    const double width = roadquery::lane_width(lane, s);
    if (lane.id == wanted.id) return t + side * 0.5 * width;
    t += side * width;
  }
  return t;
}

/// Lanes that one gets into at the end of each lane, as our links have it.
json lane_links(const RoadMap& map) {
  std::map<std::array<int, 3>, std::vector<std::array<int, 2>>> through;  // junction, road, lane -> connecting lanes
  for (const roadquery::Junction& junction : map.junctions)
    for (const roadquery::Connection& connection : junction.connections)
      for (const roadquery::LaneLink& link : connection.lane_links)
        through[{junction.id, connection.incoming_road, link.from}].push_back({connection.connecting_road, link.to});
  json links = json::array();
  for (const Road& road : map.roads)
    for_driving_lanes(road, [&](const Lane& lane) {
      const bool along = drives_along(road, lane);
      const roadquery::RoadLink& next = along ? road.successor : road.predecessor;
      const std::optional<int>& linked = along ? lane.successor : lane.predecessor;
      if (next.kind == LinkKind::junction)
        for (const auto& [to, to_lane] : through[{next.id, road.id, lane.id}])
          links.push_back({road.id, lane.id, to, to_lane});
      else if (next.kind == LinkKind::road && linked)
        links.push_back({road.id, lane.id, next.id, *linked});
    });
  return links;
}

TEST_P(Readers, carla_has_our_lanes_where_they_are_and_linked_as_they_are) {
  if (!fs::exists(peers / "python")) GTEST_SKIP() << "SKIPPED: no CARLA map parser, run tools/setup --peers";
  const RoadMap map = roadquery::read_opendrive(xodr.string());
  json ask_for{{"points", json::array()}, {"links", lane_links(map)}, {"lanes", json::array()}};
  std::size_t lanes = 0;
  for (const Road& road : map.roads)
    for_driving_lanes(road, [&](const Lane& lane) {
      ++lanes;
      ask_for["lanes"].push_back({road.id, lane.id, drives_along(road, lane) ? road.length : 0.0});
      const int steps = std::max(2, static_cast<int>(std::ceil(road.length / 5.0)));
      for (int k = 0; k <= steps; ++k) {
        const double s = std::clamp(road.length * k / steps, 1e-3, road.length - 1e-3), t = middle_t(road, lane, s);
        const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
        ask_for["points"].push_back({road.id, lane.id, s, p.x, p.y, p.z, roadquery::elevation(road, s)});
      }
    });
  std::ofstream(scratch / "ask.json") << ask_for;
  const ToolRun run = ask("carla_map.py", {xodr.string(), (scratch / "ask.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
  const json result = json::parse(run.out);
  RecordProperty("carla", run.out);
  EXPECT_EQ(result.at("points").get<std::size_t>(), ask_for["points"].size());
  EXPECT_EQ(result.at("no_waypoint"), 0);
  EXPECT_LT(result.at("max_xy_m").get<double>(), 0.05) << run.out;
  // CARLA knows the profile of the reference line only: neither superelevation nor shapes.
  EXPECT_LT(result.at("max_line_z_m").get<double>(), 0.05) << run.out;
  EXPECT_EQ(result.at("only_ours"), json::array()) << run.out;
  EXPECT_EQ(result.at("only_carla"), json::array()) << run.out;
  EXPECT_GE(result.at("links").get<std::size_t>(), lanes / 2);
}

/// Towns only: 300 cars are no traffic for a circuit.
class Traffic : public Readers {};

TEST_P(Traffic, sumo_drives_random_trips_without_a_collision_or_a_teleport) {
  setenv("SUMO_HOME", "/usr/share/sumo", 1);
  const std::string net = (scratch / "net.xml").string();
  // Without the option SUMO draws curves of its own between the ends of connecting roads.
  const ToolRun made = run_program({"/usr/bin/netconvert", "--opendrive-files", xodr.string(),
                                    "--opendrive.internal-shapes", "true", "--xml-validation", "never", "-o", net});
  ASSERT_EQ(made.exit_code, 0) << made.err.substr(0, 2000);
  // None is asked. On Kvarnbyn, whose map lacks `oneway`, two cars still meet about once in 1,200 trips
  // (docs/measured/traffic.md): more than one collision in these 1,200 is a new fault.
  const int most_collisions = std::string(GetParam()) == "kvarnbyn" ? 1 : 0;
  int collisions = 0, trips = 0, emergency_brakings = 0;
  std::string events;
  for (const char* seed : {"1", "2", "3", "4"}) {
    const ToolRun run = run_program({"/usr/bin/python3", (scripts / "sumo_trips.py").string(), net,
                                     (scratch / "trips").string(), "--trips", "300", "--seed", seed});
    ASSERT_EQ(run.exit_code, 0) << run.err.substr(0, 2000);
    const json result = json::parse(run.out);
    EXPECT_EQ(result.at("trips"), 300) << run.out;
    EXPECT_EQ(result.at("arrived"), 300) << run.out;
    EXPECT_EQ(result.at("teleports"), 0) << run.out;
    trips += result.at("trips").get<int>();
    emergency_brakings += result.at("emergency_brakings").get<int>();
    collisions += result.at("collisions").get<int>();
    if (!result.at("events").empty()) events += "seed " + std::string(seed) + ": " + run.out + "\n";
  }
  EXPECT_LE(1000 * emergency_brakings, trips) << events;  // one of 1,000 trips at most
  EXPECT_LE(collisions, most_collisions) << events;
  if (collisions > 0) std::cout << "cars met:\n" << events;
}

INSTANTIATE_TEST_SUITE_P(Sites, Readers, testing::Values("village", "circuit", "kvarnbyn"),
                         [](const auto& info) { return std::string(info.param); });

INSTANTIATE_TEST_SUITE_P(Sites, Traffic, testing::Values("village", "kvarnbyn"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace orthodrive

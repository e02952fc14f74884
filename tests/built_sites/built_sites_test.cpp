// SPDX-License-Identifier: Apache-2.0
// What `orthodrive build` made of the village and of Kvarnbyn, before real readers and against the truth.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "opendrive_peers.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

const fs::path sites = paths::test_sites;

json json_of(const Arguments& arguments) {
  const ToolRun run = run_tool(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return json::parse(run.out);
}

class BuiltSite : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    folder = sites / GetParam();
    if (!fs::exists(folder / "run.json"))
      GTEST_SKIP() << "SKIPPED: " << folder << " was not built, its data is missing";
  }
  fs::path folder;
};

TEST_P(BuiltSite, has_every_file_and_a_record_of_every_stage) {
  for (const char* name :
       {"labels.tif", "confidence.tif", "roads.gpkg", "road_graph.geojson", "roads.xodr", "scene/tileset.json",
        "drive/lap.csv", "drive/report.html", "report.html", "findings.geojson"})
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  const json run = json::parse(bytes_of(folder / "run.json"));
  std::vector<std::string> stages;
  for (const json& stage : run.at("stages")) {
    stages.push_back(stage.at("stage"));
    EXPECT_GT(stage.at("seconds").get<double>(), 0.0) << stages.back();
    EXPECT_GT(stage.at("peak_memory_bytes").get<double>(), 1e6) << stages.back();
  }
  EXPECT_EQ(stages, (std::vector<std::string>{"segment", "refine", "elevate", "network", "drive", "scene", "report"}));
  for (const char* role : {"photo", "osm", "dtm", "model"}) EXPECT_FALSE(run.at("inputs").at(role).empty()) << role;
  const json findings = json::parse(bytes_of(folder / "findings.geojson"));
  EXPECT_EQ(findings.at("type"), "FeatureCollection");
}

TEST_P(BuiltSite, road_network_is_valid_and_sumo_finds_every_road) {
  if (!fs::exists(opendrive_schema)) GTEST_SKIP() << "SKIPPED: no OpenDRIVE schema beside the checkout";
  expect_valid_opendrive(folder / "roads.xodr");
  const Scratch scratch;
  expect_sumo_finds_all_roads(folder / "roads.xodr", scratch.folder());
}

TEST_P(BuiltSite, road_network_hangs_together) {
  const json scores = json_of({"evaluate", "network", (folder / "roads.xodr").string(), "--json"});
  // Cross sections are turned about the slope. At a mouth where the banking changes, a connecting road slopes as its
  // lane does, its neighbour as its middle: their edges part by t sin(bank) times the difference (0.02 mm in the
  // village, a millimetre in Kvarnbyn).
  EXPECT_LT(scores.at("max_joint_gap_m").get<double>(), std::string(GetParam()) == "village" ? 1e-4 : 2e-3);
  EXPECT_LT(scores.at("max_gradient_kink").get<double>(), 1e-6);
  EXPECT_GT(scores.at("connected_share").get<double>(), 0.9);
}

TEST_P(BuiltSite, gltf_validator_finds_no_error) {
  const ToolRun run =
      run_program({"/usr/bin/env", "node", paths::in_source("tools/validate_gltf.mjs"), (folder / "scene").string()});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find(" 0 errors"), std::string::npos);
}

TEST_P(BuiltSite, the_lap_was_driven_on_the_road) {
  const json run = json::parse(bytes_of(folder / "run.json"));
  for (const json& stage : run.at("stages"))
    if (stage.at("stage") == "drive") {
      const json& numbers = stage.at("numbers");
      EXPECT_TRUE(numbers.at("finished").get<bool>());
      EXPECT_TRUE(numbers.at("closed").get<bool>());
      EXPECT_GT(numbers.at("length_m").get<double>(), 500.0);
      EXPECT_LT(numbers.at("off_road_share").get<double>(), 0.005);
      // Each of four tyres every millisecond. A lap begins and ends between two steps of the driver, 5 ms apart.
      EXPECT_GE(numbers.at("tyre_queries").get<double>(), 4000.0 * (numbers.at("lap_time_s").get<double>() - 0.005));
    }
}

INSTANTIATE_TEST_SUITE_P(Sites, BuiltSite, testing::Values("village", "kvarnbyn"),
                         [](const auto& info) { return std::string(info.param); });

// The numbers of issue 2: 1 km2 at 0.2 m/px.
TEST(Village, roads_are_better_than_the_input_by_the_margin_asked_for) {
  const fs::path truth = sites / "village_site" / "truth";
  const json input =
      json_of({"evaluate", "roads", (sites / "village_site" / "roads.osm").string(), truth.string(), "--json"});
  const json result =
      json_of({"evaluate", "site", (sites / "village").string(), "--truth", truth.string(), "--json"}).at("roads");
  EXPECT_GE(result.at("surface_iou").get<double>(), input.at("surface_iou").get<double>() + 0.10);
  EXPECT_LE(result.at("offset_m").at("mean_abs").get<double>(),
            0.5 * input.at("offset_m").at("mean_abs").get<double>());
  EXPECT_GT(result.at("matched_share").get<double>(), 0.99);
}

TEST(Village, heights_follow_the_true_road) {
  const fs::path truth = sites / "village_site" / "truth";
  const json heights =
      json_of({"evaluate", "site", (sites / "village").string(), "--truth", truth.string(), "--json"}).at("heights");
  EXPECT_LT(heights.at("z_m").at("mean_abs").get<double>(), 0.03);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// `--json` and `plan`.

#include <sstream>

#include "faults/small_site.hpp"

namespace orthodrive {
namespace {
using nlohmann::json;
namespace fs = std::filesystem;

TEST(JsonLog, is_an_object_a_line_with_progress_of_each_stage) {
  const SmallBuild small;
  small.forget_from("segment");
  const ToolRun run = small.build({"--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::istringstream in(run.err);
  std::set<std::string> stages, with_progress;
  std::string last_time;
  for (std::string line; std::getline(in, line);) {
    const json entry = json::parse(line, nullptr, false);
    ASSERT_TRUE(entry.is_object()) << line;
    EXPECT_EQ(entry.at("level"), "info");
    EXPECT_EQ(entry.at("time").get<std::string>().size(), std::string("2026-01-31T12:00:00.123Z").size());
    EXPECT_GE(entry.at("time").get<std::string>(), last_time);
    last_time = entry.at("time");
    stages.insert(entry.at("stage"));
    EXPECT_NE(entry.contains("message"), entry.contains("progress")) << line;
    if (!entry.contains("progress")) continue;
    with_progress.insert(entry.at("stage"));
    EXPECT_GE(entry.at("progress"), 0.0);
    EXPECT_LE(entry.at("progress"), 1.0);
    EXPECT_EQ(entry.contains("rate_per_s"), entry.contains("remaining_s"));
  }
  for (const char* stage : {"segment", "refine", "elevate", "network", "scene", "drive"})
    EXPECT_TRUE(stages.contains(stage)) << stage;
  EXPECT_GE(with_progress.size(), 4u);
}

TEST(JsonLog, an_error_is_an_object_too) {
  const ToolRun run = run_tool({"--json", "build", "nowhere.toml", "-o", "nowhere"});
  EXPECT_EQ(run.exit_code, 1);
  const json entry = json::parse(run.err, nullptr, false);
  ASSERT_TRUE(entry.is_object()) << run.err;
  EXPECT_EQ(entry.at("level"), "error");
  EXPECT_THAT(entry.at("message").get<std::string>(), testing::HasSubstr("nowhere.toml"));
}

/// Within a factor of two of a number that was measured.
void expect_near(double estimated, double measured, const std::string& what) {
  EXPECT_GT(estimated, measured / 2) << what;
  EXPECT_LT(estimated, measured * 2) << what;
}

/// What run.json of builds on the machine of the cost table said (docs/build.md): sums of seconds, MB, MB. A plan made
/// on a machine of half that speed says twice the seconds.
TEST(Plan, estimates_the_builds_that_were_measured) {
  struct Measured {
    const char* site;
    double seconds, memory_mb, disk_mb, segment_s, scene_s;
  };
  const Scratch scratch;
  std::vector<Measured> sites;
  const fs::path village = scratch / "village";  // its roads, and a photo of as many pixels
  ASSERT_EQ(run_tool({"-q", "synth", "--preset", "village", "--seed", "7", "--gsd", "1", "-o", village}).exit_code, 0);
  write_bytes(village / "photo.vrt",
              "<VRTDataset rasterXSize=\"5000\" rasterYSize=\"5000\"><SRS>EPSG:32633</SRS><GeoTransform>460000,0.2,0,"
              "5271000,0,-0.2</GeoTransform><VRTRasterBand dataType=\"Byte\" band=\"1\"/></VRTDataset>");
  const std::string village_file = village / "site.toml", kvarnbyn_file = paths::in_source("sites/kvarnbyn.toml");
  sites.push_back({village_file.c_str(), 14.3, 1387, 31, 4.5, 4.9});
  if (fs::exists(paths::in_source("../shared/data/kvarnbyn/ortho.jpg")))
    sites.push_back({kvarnbyn_file.c_str(), 26.4, 1231, 82, 5.9, 8.2});
  else
    GTEST_LOG_(WARNING) << "no ../shared/data: Kvarnbyn is left out";
  for (const Measured& m : sites) {
    Arguments plan_site{"--threads", "2", "plan", m.site, "--json"};
    if (m.site == village_file) plan_site.insert(plan_site.end(), {"--set", "sources.photo=photo.vrt"});
    const ToolRun run = run_tool(plan_site);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json plan = json::parse(run.out);
    const double speed = plan.at("speed");
    expect_near(speed * plan.at("seconds").get<double>(), m.seconds, std::string(m.site) + ": seconds");
    expect_near(plan.at("memory_mb"), m.memory_mb, std::string(m.site) + ": memory");
    expect_near(plan.at("disk_mb"), m.disk_mb, std::string(m.site) + ": disk");
    for (const json& stage : plan.at("stages")) {
      if (stage.at("stage") == "segment")
        expect_near(speed * stage.at("seconds").get<double>(), m.segment_s, "segment");
      if (stage.at("stage") == "scene") expect_near(speed * stage.at("seconds").get<double>(), m.scene_s, "scene");
    }
  }
}

TEST(Plan, says_how_large_the_site_is_and_opens_nothing_for_writing) {
  const SmallBuild small;
  const auto before = snapshot(small.folder());
  const ToolRun table = run_tool({"plan", small.site() / "site.toml"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, testing::HasSubstr("0.04 km2, 0.2 million pixels"));
  EXPECT_EQ(lines_of(table.out), 11u) << table.out;
  EXPECT_TRUE(snapshot(small.folder()) == before);
  const ToolRun wrong = run_tool({"plan", small.site() / "site.toml", "--set", "sources.photo=nowhere.tif"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.err, testing::HasSubstr("nowhere.tif"));
}

}  // namespace
}  // namespace orthodrive

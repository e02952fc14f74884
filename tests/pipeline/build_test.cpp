// SPDX-License-Identifier: Apache-2.0
// `orthodrive build` as a whole, on a small village: same bytes, resuming, bad input.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/run_tool.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/raster/raster_io.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

class Build : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "orthodrive-build-XXXXXX").string();
    folder = mkdtemp(pattern.data());
    ASSERT_EQ(
        run_tool({"synth", "--seed", "3", "--size", "300", "--gsd", "0.4", "-o", (folder / "site").string()}).exit_code,
        0);
    const ToolRun first = build("first", {"--threads", "1"});
    ASSERT_EQ(first.exit_code, 0) << first.err;
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  static ToolRun build(const std::string& out, Arguments more = {}) {
    Arguments arguments{"build", (folder / "site" / "site.toml").string(), "-o", (folder / out).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments);
  }
  /// Content of all results by their name in the folder. Times differ from run to run.
  static std::map<std::string, std::string> results(const std::string& out) {
    std::map<std::string, std::string> files;
    for (const auto& [path, bytes] : snapshot(folder / out)) {
      const std::string name = fs::relative(path, folder / out).string();
      if (name != "run.json" && name.find("report.html") == std::string::npos && name.rfind(".orthodrive/", 0) != 0)
        files[name] = bytes;
    }
    return files;
  }
  static std::vector<std::string> skipped_stages(const std::string& out) {
    std::vector<std::string> names;
    const json run = json::parse(bytes_of(folder / out / "run.json"));
    for (const json& stage : run.at("stages"))
      if (stage.at("skipped").get<bool>()) names.push_back(stage.at("stage"));
    return names;
  }
  static fs::path folder;
};
fs::path Build::folder;

TEST_F(Build, two_threads_give_the_bytes_of_one) {
  ASSERT_EQ(build("second", {"--threads", "2"}).exit_code, 0);
  const auto one = results("first"), two = results("second");
  ASSERT_GT(one.size(), 7u);
  ASSERT_EQ(one.size(), two.size());
  for (const auto& [name, bytes] : one) EXPECT_TRUE(two.at(name) == bytes) << name;
}

TEST_F(Build, goes_on_where_it_was_and_repeats_only_what_changed) {
  fs::copy(folder / "first", folder / "again", fs::copy_options::recursive);
  const auto before = results("again");
  ASSERT_EQ(build("again").exit_code, 0);
  EXPECT_EQ(skipped_stages("again"),
            (std::vector<std::string>{"segment", "refine", "elevate", "network", "drive", "scene"}));

  fs::remove(folder / "again" / ".orthodrive" / "elevate.json");  // as after a kill in that stage
  fs::remove(folder / "again" / "roads.gpkg");
  ASSERT_EQ(build("again").exit_code, 0);
  EXPECT_EQ(skipped_stages("again"), (std::vector<std::string>{"segment", "refine", "network", "drive", "scene"}));
  EXPECT_TRUE(results("again") == before);

  ASSERT_EQ(build("again", {"--set", "elevate.sampling=bilinear"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("again"), (std::vector<std::string>{"segment", "refine"}));
}

/// Columns [first, end) of a photo, by another exposure.
void write_part(const fs::path& file, const Photo& whole, int first, int end, double gain) {
  Photo part{whole.crs,
             {whole.frame.world_from_pixel(first, 0).x, whole.frame.north_m, whole.frame.gsd_m, end - first,
              whole.frame.height},
             Raster<std::uint8_t>(end - first, whole.frame.height, 3),
             Raster<std::uint8_t>(end - first, whole.frame.height, 1, 1)};
  for (int row = 0; row < part.rgb.height; ++row)
    for (int col = 0; col < part.rgb.width; ++col)
      for (int c = 0; c < 3; ++c)
        part.rgb.at(col, row, c) =
            static_cast<std::uint8_t>(std::min(255.0, gain * whole.rgb.at(first + col, row, c) + 0.5));
  io::write_photo(file, part);
}

TEST_F(Build, several_photos_are_seen_as_one_and_each_of_them_counts) {
  const fs::path site = folder / "site", two = folder / "two";
  const Photo whole = io::read_photo_native(site / "ortho.tif");
  const int width = whole.frame.width;
  write_part(site / "west.tif", whole, 0, width * 6 / 10, 1.0);
  write_part(site / "east.tif", whole, width * 4 / 10, width, 0.85);
  const Arguments both{"--set", "sources.photo=['west.tif', 'east.tif']"};
  Arguments explain = both;
  explain.emplace_back("--explain");
  fs::copy(folder / "first", two, fs::copy_options::recursive);
  ASSERT_EQ(build("two", both).exit_code, 0);
  const LabelMap one = io::read_labels(folder / "first/labels.tif"), labels = io::read_labels(two / "labels.tif");
  ASSERT_EQ(labels.frame, one.frame);
  std::size_t same = 0;
  for (std::size_t i = 0; i < one.labels.data.size(); ++i) same += one.labels.data[i] == labels.labels.data[i] ? 1 : 0;
  EXPECT_GT(static_cast<double>(same), 0.97 * static_cast<double>(one.labels.data.size()));

  ASSERT_EQ(build("two", both).exit_code, 0);
  EXPECT_EQ(skipped_stages("two").size(), 6u);
  write_part(site / "east.tif", whole, width * 4 / 10, width, 0.8);
  const std::string why = build("two", explain).out;
  EXPECT_THAT(why, testing::ContainsRegex("segment +runs: source photo: [^\n]*east.tif has other content"));
  EXPECT_THAT(why, testing::ContainsRegex("scene +runs: source photo: [^\n]*east.tif has other content"));
  EXPECT_THAT(build("two", {"--set", "sources.photo=['east.tif', 'west.tif']", "--explain"}).out,
              testing::ContainsRegex("segment +runs: source photo: "));

  // The stages by themselves take several photos, too.
  const fs::path out = folder / "by_photos";
  for (const Arguments& command :
       {Arguments{"segment", site / "west.tif", site / "east.tif", "-o", out / "labels.tif"},
        Arguments{"scene", "--network", two / "roads.xodr", "--photo", site / "west.tif", "--photo", site / "east.tif",
                  "--dtm", site / "dtm_1m.tif", "-o", out / "scene"}}) {
    const ToolRun run = run_tool(command);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  EXPECT_NEAR(io::read_labels(out / "labels.tif").frame.bounds().width(), whole.frame.bounds().width(), 2.0);
  EXPECT_TRUE(fs::exists(out / "scene/tileset.json"));
}

TEST_F(Build, where_one_drives_left_the_network_does) {
  fs::copy(folder / "first", folder / "left", fs::copy_options::recursive);
  ASSERT_EQ(build("left", {"--set", "refine.driving_side=left"}).exit_code, 0);
  EXPECT_THAT(bytes_of(folder / "left/roads.xodr"), testing::HasSubstr("rule=\"LHT\""));
  EXPECT_THAT(bytes_of(folder / "first/roads.xodr"), testing::Not(testing::HasSubstr("rule=\"LHT\"")));
}

/// Both call the same unit of a stage.
TEST_F(Build, a_command_on_files_of_a_build_gives_the_bytes_of_the_build) {
  const fs::path first = folder / "first", out = folder / "by_command";
  const json site = json::parse(bytes_of(first / "run.json")).at("site");
  for (const Arguments& command :
       {Arguments{"network", "--roads", first / "roads.gpkg", "--name", site.at("name"), "-o", out / "roads.xodr"},
        Arguments{"drive", "--network", first / "roads.xodr", "--route", site.at("route"), "-o", out / "drive"}}) {
    const ToolRun run = run_tool(command);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  for (const char* file : {"roads.xodr", "drive/lap.csv"})
    EXPECT_TRUE(bytes_of(out / file) == bytes_of(first / file)) << file;
}

TEST_F(Build, the_reference_s_refinement_gives_other_roads_for_each_set_of_weights) {
  const auto refined = [](const Arguments& method) {
    const std::string roads = folder / "refined.gpkg";
    Arguments arguments{
        "-q", "refine", "--osm", folder / "site/roads.osm", "--labels", folder / "site/truth/labels.tif", "-o", roads};
    arguments.insert(arguments.end(), method.begin(), method.end());
    const ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const ToolRun score =
        run_tool({"evaluate", "roads", roads, folder / "site/truth", "--before", folder / "site/roads.osm", "--json"});
    EXPECT_EQ(score.exit_code, 0) << score.err;
    return json::parse(score.out);
  };
  const json ours = refined({}), set_1 = refined({"--method", "nlo", "--weights", "1"}),
             set_2 = refined({"--method", "nlo", "--weights", "2"}), both = refined({"--method", "nlo"});
  const auto error_m = [](const json& score) { return score["offset_m"]["mean_abs"].get<double>(); };
  EXPECT_LT(set_2["width_variance_m2"], set_1["width_variance_m2"]) << "set 2 is the smooth one";
  EXPECT_NE(error_m(both), error_m(set_1));
  EXPECT_NE(error_m(both), error_m(set_2));
  EXPECT_LT(error_m(ours), std::min({error_m(set_1), error_m(set_2), error_m(both)}));
  EXPECT_LT(ours["moved_away"]["share_by_more_than_0_3_m"], 0.1);
}

TEST_F(Build, refines_with_the_weights_that_the_site_names) {
  fs::copy(folder / "first", folder / "weighted", fs::copy_options::recursive);
  write_bytes(folder / "site" / "weights.toml",
              "search_offset_m = 0.01\nmap_shift_m = 0.05\nway_shift_m = 0.05\nnode_shift_m = 0.05\n"
              "misplaced_sigmas = 100.0\n");
  ASSERT_EQ(build("weighted", {"--set", "refine.weights=weights.toml"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("weighted"), std::vector<std::string>{"segment"});
  const auto offset_m = [](const char* out) {
    const json run = json::parse(bytes_of(folder / out / "run.json"));
    return run.at("stages").at(1).at("numbers").at("mean_abs_offset_m").get<double>();
  };
  EXPECT_LT(offset_m("weighted"), 0.5 * offset_m("first")) << "these weights hold the roads where OSM has them";
}

TEST_F(Build, the_crf_decides_the_labels_where_a_site_asks_for_it) {
  fs::copy(folder / "first", folder / "crf", fs::copy_options::recursive);
  ASSERT_EQ(build("crf", {"--set", "segment.crf=true"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("crf"), std::vector<std::string>{}) << "all that follows from other labels";
  const LabelMap without = io::read_labels(folder / "first" / "labels.tif"),
                 with = io::read_labels(folder / "crf" / "labels.tif");
  ASSERT_EQ(with.labels.data.size(), without.labels.data.size());
  std::size_t changed = 0;
  for (std::size_t i = 0; i < with.labels.data.size(); ++i)
    changed += with.labels.data[i] != without.labels.data[i] ? 1 : 0;
  EXPECT_GT(changed, 0u);
  EXPECT_LT(changed, with.labels.data.size() / 10) << "it smooths, no more";
}

TEST_F(Build, labels_see_the_map_where_the_model_does_and_move_roads) {
  fs::copy(folder / "first", folder / "blind", fs::copy_options::recursive);
  const fs::path sees_no_map = paths::in_source("models/training/two_towns.safetensors");
  ASSERT_EQ(build("blind", {"--set", "segment.model=" + sees_no_map.string()}).exit_code, 0);
  EXPECT_NE(bytes_of(folder / "blind" / "labels.tif"), bytes_of(folder / "first" / "labels.tif"));
  EXPECT_NE(bytes_of(folder / "blind" / "roads.xodr"), bytes_of(folder / "first" / "roads.xodr"));
  const auto rows = [](const char* out) {
    const std::string text = bytes_of(folder / out / ".orthodrive" / "alignment.csv");
    return std::ranges::count(text, '\n') - 1;
  };
  EXPECT_EQ(rows("blind"), 0);
  EXPECT_GT(rows("first"), 100);
}

/// The village has four cells, which is too few to learn from: labels are as without.
TEST_F(Build, tells_what_became_of_an_adaptation) {
  if (!paths::has_part("train")) GTEST_SKIP() << "SKIPPED: the part train is not built (tools/setup --parts)";
  fs::copy(folder / "first", folder / "adapted", fs::copy_options::recursive);
  ASSERT_EQ(build("adapted", {"--set", "segment.adapt=true"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("adapted"), (std::vector<std::string>{"refine", "elevate", "network", "drive", "scene"}))
      << "their inputs came out as before";
  EXPECT_EQ(bytes_of(folder / "adapted" / "labels.tif"), bytes_of(folder / "first" / "labels.tif"));
  const std::string findings = bytes_of(folder / "adapted" / "findings.geojson");
  EXPECT_THAT(findings, testing::HasSubstr("segment.not_adapted"));
  EXPECT_THAT(bytes_of(folder / "adapted" / "report.html"), testing::HasSubstr("cells with roads to learn from"));
  const json run = json::parse(bytes_of(folder / "adapted" / "run.json"));
  EXPECT_EQ(run.at("stages").at(0).at("numbers").at("adapt").at("kept"), false);
  EXPECT_EQ(run.at("inputs").at("osm").size(), 1u) << "once, though two stages read it";
}

TEST_F(Build, a_source_of_the_same_name_in_another_folder_is_another_source) {
  fs::copy(folder / "first", folder / "moved", fs::copy_options::recursive);
  fs::create_directories(folder / "site" / "other");
  const fs::path copy = folder / "site" / "other" / "dtm_1m.tif";
  fs::copy_file(folder / "site" / "dtm_1m.tif", copy);
  ASSERT_EQ(build("moved", {"--set", "sources.dtm=['other/dtm_1m.tif', 'dtm_1m.tif']"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("moved"), (std::vector<std::string>{"segment", "refine", "network", "drive"}))
      << "the heights are the same";
}

/// A drive from corner to corner of the village's area, in one go.
std::string gpx_of_drive(Vec2 from, Vec2 to) {
  const CoordinateTransform lonlat_from_site(Crs{"EPSG:32633"}, Crs{"EPSG:4326"});
  std::string text = "<gpx version=\"1.1\"><trk><trkseg>\n";
  constexpr int points = 60;
  for (int i = 0; i <= points; ++i) {
    const Vec2 p = lonlat_from_site.target_from_source(from + (to - from) * (i / static_cast<double>(points)));
    text += "<trkpt lat=\"" + std::to_string(p.y) + "\" lon=\"" + std::to_string(p.x) + "\"/>\n";
  }
  return text + "</trkseg></trk></gpx>\n";
}

TEST_F(Build, paths_that_only_gpx_tracks_know_reach_the_network_of_roads) {
  fs::copy(folder / "first", folder / "driven", fs::copy_options::recursive);
  const fs::path gpx = folder / "site" / "drive.gpx";
  std::ofstream(gpx) << gpx_of_drive({460005, 5270005}, {460295, 5270295});
  ASSERT_EQ(build("driven", {"--set", "sources.gpx='drive.gpx'"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("driven"), std::vector<std::string>{"segment"});
  EXPECT_THAT(bytes_of(folder / "driven" / "findings.geojson"), testing::HasSubstr("refine.path_from_gpx"));
  EXPECT_THAT(bytes_of(folder / "driven" / "roads.xodr"), testing::HasSubstr("code=\"osm_id\" value=\"-1\""));
  ASSERT_EQ(build("driven", {"--set", "sources.gpx='drive.gpx'"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("driven").size(), 6u);
  std::ofstream(gpx) << gpx_of_drive({460005, 5270295}, {460295, 5270005});
  ASSERT_EQ(build("driven", {"--set", "sources.gpx='drive.gpx'"}).exit_code, 0);
  EXPECT_EQ(skipped_stages("driven"), std::vector<std::string>{"segment"}) << "another drive under the same name";

  const fs::path roads = folder / "driven.gpkg", labels = folder / "site/truth/labels.tif",
                 osm = folder / "site/roads.osm";
  const Arguments refine{"refine", "--osm", osm, "--labels", labels, "-o", roads, "--gpx", gpx};
  Arguments twice = refine, nlo = refine;
  twice.insert(twice.end(), {"--gpx", gpx});
  const ToolRun once = run_tool(refine), both = run_tool(twice);
  EXPECT_EQ(once.exit_code, 0);
  EXPECT_THAT(once.err, testing::HasSubstr("of 1 recording"));
  EXPECT_THAT(both.err, testing::HasSubstr("of 2 recording"));
  nlo.insert(nlo.end(), {"--method", "nlo"});
  EXPECT_EQ(run_tool(nlo).exit_code, 2);
}

TEST_F(Build, bad_sources_are_one_line_and_leave_the_result_untouched) {
  const auto before = snapshot(folder / "first");
  for (const auto& [change, named] :
       std::vector<std::pair<std::string, std::string>>{{"sources.photo=nowhere.tif", "nowhere.tif"},
                                                        {"sources.osm=nowhere.osm", "nowhere.osm"},
                                                        {"sources.dtm=nowhere.tif", "nowhere.tif"},
                                                        {"sources.gpx=nowhere.gpx", "nowhere.gpx"},
                                                        {"sources.gpx=roads.osm", "roads.osm"},
                                                        {"segment.model=nowhere", "nowhere"},
                                                        {"refine.weights=nowhere.toml", "nowhere.toml"},
                                                        {"area.bounds=[0, 0, 100, 100]", "roads.osm"}}) {
    const ToolRun run = build("first", {"--set", change, "--quiet"});
    EXPECT_EQ(run.exit_code, 1) << change;
    EXPECT_THAT(run.err, testing::HasSubstr(named)) << change;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_TRUE(snapshot(folder / "first") == before) << change;
  }
}

}  // namespace
}  // namespace orthodrive

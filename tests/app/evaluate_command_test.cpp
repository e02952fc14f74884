// SPDX-License-Identifier: Apache-2.0
// The command: what it accepts as truth, and what it prints. Files are written by the tool itself (synth) or by hand.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/run_tool.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

/// One synthetic site for all tests.
class EvaluateCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("orthodrive-evaluate-" + std::to_string(getpid()));
    const ToolRun made = run_tool({"synth", "--seed", "5", "--size", "300", "--gsd", "0.5", "-o", path("site")});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  static ToolRun evaluate(Arguments arguments) {
    arguments.insert(arguments.begin(), "evaluate");
    return run_tool(arguments);
  }
  static Json json(Arguments arguments) {
    arguments.push_back("--json");
    const ToolRun run = evaluate(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "");
    return Json::parse(run.out, nullptr, false);
  }
  static std::string path(const std::string& name) { return (folder_ / name).string(); }

  static inline fs::path folder_;
};

TEST_F(EvaluateCommand, truth_scores_itself_perfectly_as_a_whole_site) {
  fs::create_directories(path("built"));
  for (const char* name : {"labels.tif", "roads.gpkg"})
    fs::copy_file(path("site/truth/") + name, path("built/") + name, fs::copy_options::overwrite_existing);
  ASSERT_EQ(run_tool({"network", "--roads", path("site/truth/roads.gpkg"), "-o", path("built/roads.xodr")}).exit_code,
            0);
  const Json scores = json({"site", path("built"), "--truth", path("site/truth")});
  EXPECT_EQ(scores["labels"]["pixel_accuracy"], 1.0);
  EXPECT_EQ(scores["labels"]["iou"]["road"], 1.0);
  EXPECT_GT(scores["roads"]["surface_iou"], 0.999);
  EXPECT_LT(scores["roads"]["offset_m"]["p95"], 1e-6);
  EXPECT_GT(scores["roads"]["width_m"]["n"], 100);
  EXPECT_LT(scores["heights"]["z_m"]["mean_abs"], 1e-6);
  EXPECT_GT(scores["heights"]["gradient_energy"], 0.0);
  EXPECT_GT(scores["network"]["length_m"], 100.0);
  EXPECT_LT(scores["network"]["max_joint_gap_m"], 0.01);
  EXPECT_TRUE(scores["network"]["elements"].contains("line"));
}

TEST_F(EvaluateCommand, raw_osm_is_the_baseline) {
  const Json scores = json({"roads", path("site/roads.osm"), path("site/truth")});
  EXPECT_LT(scores["surface_iou"], 0.85);
  EXPECT_GT(scores["offset_m"]["mean_abs"], 1.0) << "synth moves OSM by 1.4 to 3.6 m in any direction";
  EXPECT_LT(scores["offset_m"]["p95"], 3.7);
  EXPECT_TRUE(scores["sigma_coverage"]["1"].is_null()) << "OSM states no sigma";
}

TEST_F(EvaluateCommand, roads_before_picture_and_layers) {
  const std::string roads = path("site/truth/roads.gpkg"), truth = path("site/truth"), osm = path("site/roads.osm");
  const Json scores = json({"roads", roads, truth, "--before", osm, "--overlay", path("errors.png"), "--photo",
                            path("site/ortho.tif"), "--layers", path("errors.gpkg")});
  EXPECT_LT(scores["moved_away"]["share"], 1e-6) << "the truth is nowhere further away";
  EXPECT_GT(scores["moved_away"]["n"], 50);
  EXPECT_TRUE(scores["width_variance_m2"].is_number());
  EXPECT_TRUE(scores["largest_curvature_jump"]["per_m"].is_number());
  EXPECT_EQ(bytes_of(path("errors.png")).substr(1, 3), "PNG");
  const std::string layers = bytes_of(path("errors.gpkg"));
  for (const char* name : {"false_positive", "false_negative", "truth_lines", "truth_samples", "offset_before_m"})
    EXPECT_NE(layers.find(name), std::string::npos) << name;
  const Json back = json({"roads", osm, truth, "--before", roads});
  EXPECT_GT(back["moved_away"]["share_by_more_than_0_3_m"], 0.5) << "OSM moved away from the truth";
  EXPECT_EQ(evaluate({"roads", roads, truth, "--photo", path("site/ortho.tif")}).exit_code, 2)
      << "--overlay is missing";
}

TEST_F(EvaluateCommand, polygons_alone_are_enough) {
  const Json roads = json({"roads", path("site/truth/roads.gpkg"), path("site/truth/surface.geojson")});
  EXPECT_GT(roads["surface_iou"], 0.99);
  EXPECT_EQ(roads["offset_m"]["n"], 0);
  EXPECT_TRUE(roads["offset_m"]["bias"].is_null());
  const Json labels = json({"labels", path("site/truth/labels.tif"), path("site/truth/surface.geojson")});
  EXPECT_GT(labels["road_iou"], 0.8) << "crowns hide some road";
  EXPECT_FALSE(labels.contains("mean_iou"));
}

TEST_F(EvaluateCommand, polygons_with_classes_and_what_to_ignore) {
  Json site = Json::parse(bytes_of(path("site/truth/surface.geojson")));
  Json& first = site["features"][0];
  first["properties"]["class"] = "road";
  write_bytes(path("classes.geojson"), Json{{"type", "FeatureCollection"}, {"features", {first}}}.dump());
  const Json scores = json({"labels", path("site/truth/labels.tif"), path("classes.geojson")});
  EXPECT_GT(scores["truth_nodata"], scores["pixels"]) << "only the polygon is truth";
  EXPECT_GT(scores["iou"]["road"], 0.5);
  const Json nothing =
      json({"labels", path("site/truth/labels.tif"), path("classes.geojson"), "--ignore", path("classes.geojson")});
  EXPECT_EQ(nothing["pixels"], 0);
  EXPECT_TRUE(nothing["pixel_accuracy"].is_null());
}

TEST_F(EvaluateCommand, labels_without_a_common_class_are_refused_unless_merged) {
  Json site = Json::parse(bytes_of(path("site/truth/surface.geojson")));
  site["features"][0]["properties"]["class"] = "asphalt";
  write_bytes(path("others.geojson"), Json{{"type", "FeatureCollection"}, {"features", {site["features"][0]}}}.dump());
  const ToolRun run = evaluate({"labels", path("site/truth/labels.tif"), path("others.geojson")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("has none of the classes of"), std::string::npos) << run.err;
  write_bytes(path("asphalt.toml"), "asphalt = \"road\"\n");
  const Json merged =
      json({"labels", path("site/truth/labels.tif"), path("others.geojson"), "--merge", path("asphalt.toml")});
  EXPECT_GT(merged["pixel_accuracy"], 0.5);
}

TEST_F(EvaluateCommand, page_and_merge_table_of_the_command_line) {
  const std::string truth = path("site/truth/labels.tif");
  write_bytes(path("merge.toml"), "grass = \"ground\"\nparking = \"paved\"\n");
  const Json scores = json({"labels", truth, truth, "--merge", path("merge.toml"), "--html", path("page"), "--photo",
                            path("site/ortho.tif")});
  EXPECT_EQ(scores["mean_iou"], 1.0);
  EXPECT_TRUE(scores["iou"].contains("paved"));
  EXPECT_FALSE(scores["iou"].contains("grass"));
  const std::string page = bytes_of(path("page/labels.html"));
  EXPECT_NE(page.find("None: every label is right."), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,"), std::string::npos);
  EXPECT_EQ(evaluate({"labels", truth, truth, "--photo", path("site/ortho.tif")}).exit_code, 2) << "--html is missing";
}

TEST_F(EvaluateCommand, terrain_is_truth_for_heights) {
  const Json scores = json({"heights", path("site/truth/roads.gpkg"), path("site/truth/dtm_1m.tif")});
  EXPECT_LT(scores["z_m"]["mean_abs"], 0.05);
  EXPECT_GT(scores["compared_share"], 0.95);
}

TEST_F(EvaluateCommand, table_for_people) {
  const ToolRun run = evaluate({"roads", path("site/roads.osm"), path("site/truth")});
  EXPECT_NE(run.out.find("surface_iou"), std::string::npos);
  EXPECT_NE(run.out.find("p95"), std::string::npos);
}

TEST_F(EvaluateCommand, bad_input_is_one_line_and_exit_code_1) {
  const std::string truth = path("site/truth"), roads = path("site/truth/roads.gpkg"), none = path("none");
  const Arguments bad[] = {{"labels", none, truth},
                           {"roads", roads, none},
                           {"roads", path("site/truth/surface.geojson"), truth},
                           {"heights", roads, none},
                           {"network", path("site/site.toml")},
                           {"network", none},
                           {"site", none, "--truth", truth},
                           {"roads", path("site/roads.osm"), truth, "--area", none},
                           {"roads", roads, truth, "--before", none},
                           {"roads", roads, truth, "--overlay", path("errors.png"), "--photo", none},
                           {"labels", truth + "/labels.tif", truth, "--merge", none},
                           {"labels", truth + "/labels.tif", truth, "--confidence", none},
                           {"labels", truth + "/labels.tif", truth, "--html", path("page"), "--photo", none}};
  for (const Arguments& arguments : bad) {
    const ToolRun run = evaluate(arguments);
    EXPECT_EQ(run.exit_code, 1) << arguments[0] << " " << arguments[1];
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  EXPECT_EQ(evaluate({}).exit_code, 2);
  EXPECT_EQ(evaluate({"labels"}).exit_code, 2);
}

}  // namespace
}  // namespace orthodrive

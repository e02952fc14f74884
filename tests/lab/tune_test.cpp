// SPDX-License-Identifier: Apache-2.0
// Tuning from files to weights, on scenes small enough to refine in no time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/run_tool.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/osm_writer.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/lab/tuning/tune_refine.hpp"
#include "orthodrive/pipeline/files/refine_files.hpp"
#include "refine/road_scene.hpp"

namespace orthodrive {
namespace {

using namespace test;
using testing::HasSubstr;

/// A winding road of 200 m whose OSM line lies `shift_m` beside it.
RoadScene winding_road(double shift_m) {
  RoadScene scene = make_scene(240.0);
  add_truth(scene, trace(200.0, [](double s) { return at(20.0 + s, 120.0 + 12.0 * std::sin(s / 40.0)); }), 7.0);
  const auto offset = [=](double s) { return shift_m * (1.0 + 0.3 * std::sin(s / 25.0)); };
  add_way(scene, 1, map_line(scene.truth[0].line, {.offset_m = offset}, 5.5));
  return scene;
}

OsmData osm_of(const RoadNetwork& roads) {
  OsmData osm{roads.crs, {}, {}};
  for (const RoadPath& path : roads.paths) {
    OsmWay& way = osm.ways.emplace_back(OsmWay{path.osm_id, {}, {{"highway", path.highway}}});
    for (const RoadNode& node : path.nodes) {
      osm.nodes.push_back({static_cast<std::int64_t>(osm.nodes.size() + 1), node.p});
      way.nodes.push_back(osm.nodes.back().id);
    }
  }
  return osm;
}

/// Polygon (id) and centre line (of) of each true road.
std::vector<io::Feature> truth_of(const RoadScene& scene) {
  std::vector<io::Feature> features;
  for (const TrueRoad& road : scene.truth) {
    const std::vector<double> half(road.line.size(), 0.5 * road.width_m);
    const std::string id = std::to_string(features.size());
    features.push_back({.polygons = {{strip_ring(road.line, half, half), {}}}, .tags = {{"id", id}}});
    features.push_back({.lines = {road.line}, .tags = {{"of", id}}});
  }
  return features;
}

void write_scene(const std::filesystem::path& folder, const RoadScene& scene) {
  std::filesystem::create_directories(folder);
  io::write_labels(folder / "labels.tif", scene.labels);
  io::write_osm(folder / "roads.osm", osm_of(scene.osm));
  io::write_geojson(folder / "truth.geojson", truth_of(scene), scene.osm.crs);
}

std::string entry(const std::string& name, const std::string& more = "") {
  return "[[site]]\nname = '" + name + "'\nlabels = '" + name + "/labels.tif'\nosm = '" + name +
         "/roads.osm'\ntruth = '" + name + "/truth.geojson'\n" + more;
}

/// Keeps every road where OSM has it, whatever the labels say.
RefineWeights stubborn() {
  return {.evidence = 0.5, .map_shift_m = 0.15, .way_shift_m = 0.1, .node_shift_m = 0.1, .search_offset_m = 0.02};
}

Polygon box(double west, double south, double east, double north) {
  return {{at(west, south), at(east, south), at(east, north), at(west, north)}, {}};
}

TEST(Tune, a_bad_start_is_improved_and_threads_change_nothing) {
  const Scratch scratch;
  write_scene(scratch / "left", winding_road(2.5));
  write_scene(scratch / "right", winding_road(-2.0));
  write_bytes(scratch / "sites.toml", entry("left") + entry("right"));
  const TuneSites sites = read_tune_sites(scratch / "sites.toml");
  ASSERT_EQ(sites.sites.size(), 2u);
  const TuneResult one = tune_refine(sites, {.start = stubborn(), .trials = 25, .threads = 1});

  EXPECT_GT(one.sites[0].start.offset_m, 1.5) << "the start is bad";
  EXPECT_NEAR(one.sites[0].start.offset_m, one.sites[0].osm.offset_m, 0.5) << "as it hardly moves the road";
  EXPECT_LT(one.sites[0].tuned.loss_m, 0.5 * one.sites[0].start.loss_m);
  EXPECT_LT(one.sites[1].tuned.loss_m, 0.5 * one.sites[1].start.loss_m);
  EXPECT_NEAR(0.5 * (one.sites[0].tuned.loss_m + one.sites[1].tuned.loss_m), one.search.all.training.tuned_m, 1e-12);
  EXPECT_TRUE(tuning_helps(one)) << verdict(one);
  EXPECT_GT(one.search.held_out_gain_m(), 0.5);
  EXPECT_THAT(verdict(one), HasSubstr("m on held-out sites"));
  EXPECT_THAT(verdict(one), Not(HasSubstr("Warning")));
  const ScoreJson json = to_json(one);
  EXPECT_EQ(json["folds"][0]["held_out"]["sites"], ScoreJson::array({"left"}));
  EXPECT_NEAR(json["overfitting_m"], json["training_gain_m"].get<double>() - json["held_out_gain_m"].get<double>(),
              2e-4);

  const TuneResult two = tune_refine(sites, {.start = stubborn(), .trials = 25, .threads = 2});
  EXPECT_EQ(json.dump(), to_json(two).dump());
  EXPECT_EQ(to_table(one), to_table(two));

  write_bytes(scratch / "weights.toml", to_weights_file(one));
  EXPECT_EQ(refine_weights_toml(read_refine_weights(scratch / "weights.toml")),
            refine_weights_toml(one.search.all.weights));
}

TEST(Tune, without_a_gain_the_shipped_weights_should_stay) {
  const Scratch scratch;
  write_scene(scratch / "left", winding_road(2.5));
  write_scene(scratch / "right", winding_road(-2.0));
  write_bytes(scratch / "sites.toml", entry("left") + entry("right"));
  const TuneResult result = tune_refine(read_tune_sites(scratch / "sites.toml"), {.trials = 0});
  EXPECT_FALSE(tuning_helps(result));
  EXPECT_THAT(verdict(result), HasSubstr("the shipped weights should stay"));
  EXPECT_TRUE(to_json(result)["overfitting_percent"].is_null());
}

TEST(Tune, each_polygon_of_the_area_is_a_site_with_the_roads_near_it) {
  const Scratch scratch;
  RoadScene scene = make_scene(600.0);
  add_truth(scene, straight(at(20, 100), at(580, 100)), 6.0);
  add_truth(scene, straight(at(20, 500), at(580, 500)), 8.0);
  add_way(scene, 1, map_line(scene.truth[0].line, {}, 5.5));
  add_way(scene, 2, map_line(scene.truth[1].line, {}, 5.5));
  write_scene(scratch / "s", scene);
  write_scene(scratch / "t", winding_road(1.0));
  std::vector<io::Feature> pieces;
  for (const auto& [name, area] :
       {std::pair{"south", box(100, 60, 200, 140)}, std::pair{"north", box(100, 460, 200, 540)},
        std::pair{"another photo's", box(900, 60, 1000, 140)}, std::pair{"half outside", box(550, 60, 650, 140)},
        std::pair{"no road", box(100, 280, 120, 320)}})
    pieces.push_back({.polygons = {area}, .tags = {{"piece", name}}});
  io::write_geojson(scratch / "area.geojson", pieces, scene.osm.crs);
  write_bytes(scratch / "sites.toml", entry("s", "area = 'area.geojson'\npieces = true\nfold = 'S'\n") + entry("t"));

  const TuneSites sites = read_tune_sites(scratch / "sites.toml");
  ASSERT_EQ(sites.sites.size(), 3u);
  const TuneSite &south = sites.sites[0], &north = sites.sites[1], &whole = sites.sites[2];
  EXPECT_EQ(south.name, "s/south");
  EXPECT_EQ(south.fold, "S");
  EXPECT_EQ(whole.fold, "t") << "its name";
  EXPECT_EQ(north.evidence, south.evidence);
  EXPECT_EQ(whole.evidence, 1u);
  ASSERT_EQ(south.osm.paths.size(), 1u) << "the other road is 320 m away";
  EXPECT_EQ(south.osm.paths[0].osm_id, 1);
  EXPECT_NEAR(length_m(centerline(south.osm.paths[0])), 560.0, 0.1) << "whole ways";
  ASSERT_EQ(north.osm.paths.size(), 1u);
  EXPECT_EQ(north.osm.paths[0].osm_id, 2);
  EXPECT_EQ(south.truth.lines.size(), 1u);
  const double osm_width_m = south.osm.paths[0].nodes[0].width_m;
  EXPECT_NEAR(road_loss(south.osm, south).width_m, std::abs(osm_width_m - 6.0), 0.02);
  EXPECT_NEAR(road_loss(north.osm, north).width_m, std::abs(osm_width_m - 8.0), 0.02);
}

/// A site whose truth is a straight road of 100 m and 8 m width.
TuneSite straight_truth() {
  TuneSite site{.name = "straight"};
  site.truth.surfaces.push_back({"1", {box(0, -4, 100, 4)}});
  site.truth.lines.push_back({"1", {at(0, 0), at(100, 0)}, {}});
  return site;
}
RoadNetwork straight_road(double to_x, double y, double width_m) {
  RoadPath path;
  path.highway = "residential";
  path.nodes = {{.p = at(0, y), .width_m = width_m}, {.p = at(to_x, y), .width_m = width_m}};
  return {.crs = {"EPSG:32633"}, .paths = {path}};
}

TEST(RoadLoss, is_what_one_finds_by_hand) {
  const TuneSite site = straight_truth();
  const RoadLoss beside = road_loss(straight_road(100.0, 1.0, 6.0), site);
  EXPECT_NEAR(beside.offset_m, 1.0, 1e-9);
  EXPECT_NEAR(beside.width_m, 2.0, 1e-9);
  EXPECT_NEAR(beside.surface_iou, 0.75, 1e-6) << "-2 to 4 of -4 to 4";
  EXPECT_EQ(beside.unmatched_share, 0.0);
  EXPECT_NEAR(beside.loss_m, 1.0 + 0.5 * 2.0 + 0.25, 1e-6);

  const RoadLoss half = road_loss(straight_road(50.0, 1.0, 8.0), site);
  EXPECT_NEAR(half.unmatched_share, 0.5, 1e-9);
  EXPECT_NEAR(half.offset_m, 0.5 * 1.0 + 0.5 * 8.0, 1e-9) << "a lost road counts as one 8 m away";
  EXPECT_NEAR(half.width_m, 0.0, 1e-9);

  const RoadLoss far = road_loss(straight_road(100.0, 12.0, 8.0), site),
                 lost = road_loss(straight_road(100.0, 40.0, 8.0), site);
  EXPECT_EQ(far.offset_m, 8.0);
  EXPECT_EQ(far.offset_m, lost.offset_m) << "nothing is gained by losing a road";
}

TEST(RoadLoss, leaves_out_what_the_truth_cannot_tell) {
  TuneSite lines_only = straight_truth();
  lines_only.truth.surfaces.clear();
  const RoadLoss loss = road_loss(straight_road(100.0, 1.0, 6.0), lines_only);
  EXPECT_NEAR(loss.loss_m, 1.0, 1e-9);
  TuneSite no_lines = straight_truth();
  no_lines.truth.lines.clear();
  EXPECT_TRUE(std::isnan(road_loss(straight_road(100.0, 1.0, 6.0), no_lines).loss_m));
}

TEST(Tune, mistakes_in_the_file_are_told_with_their_line) {
  const Scratch scratch;
  write_scene(scratch / "a", winding_road(1.0));
  io::write_geojson(scratch / "away.geojson", {{.polygons = {box(5000, 0, 5100, 100)}}}, {"EPSG:32633"});
  const auto told = [&](const std::string& text) {
    write_bytes(scratch / "sites.toml", text);
    return message_of<InputError>([&] { (void)read_tune_sites(scratch / "sites.toml"); });
  };
  EXPECT_THAT(told(""), HasSubstr("no [[site]]"));
  EXPECT_THAT(told("[[site]\n"), HasSubstr("sites.toml:1"));
  EXPECT_THAT(told(entry("a", "wieghts = 1\n")), AllOf(HasSubstr("sites.toml:6"), HasSubstr("'wieghts' is not known")));
  EXPECT_THAT(told("tirals = 1\n" + entry("a")), AllOf(HasSubstr("sites.toml:1"), HasSubstr("tirals")));
  EXPECT_THAT(told("[[site]]\nname = 'a'\nosm = 'a/roads.osm'\n"), HasSubstr("'labels' is missing"));
  EXPECT_THAT(told(entry("a") + entry("gone")), AllOf(HasSubstr("sites.toml:6"), HasSubstr("gone/labels.tif")));
  EXPECT_THAT(told(entry("a", "ignore = 'none.geojson'\n")), HasSubstr("none.geojson"));
  EXPECT_THAT(told(entry("a") + entry("a")), HasSubstr("'a' is there already"));
  EXPECT_THAT(told(entry("a", "pieces = true\n")), HasSubstr("'pieces' needs 'area'"));
  EXPECT_THAT(told(entry("a", "pieces = 'yes'\narea = 'away.geojson'\n")), HasSubstr("'pieces' must be true or false"));
  EXPECT_THAT(told(entry("a", "fold = ''\n")), HasSubstr("must not be empty"));
  for (const char* pieces : {"", "pieces = true\n"})
    EXPECT_THAT(told(entry("a", std::string("area = 'away.geojson'\n") + pieces)), HasSubstr("site 'a': no place"));
  EXPECT_THAT(message_of<InputError>([&] { (void)read_tune_sites(scratch / "none.toml"); }), HasSubstr("none.toml"));
}

TEST(RefineWeightsFile, what_it_does_not_name_is_shipped_and_mistakes_are_told) {
  const Scratch scratch;
  const std::filesystem::path file = scratch / "weights.toml";
  write_bytes(file, "# tuned\nangle = 33\nway_shift_m = 2.5e0\n");
  const RefineWeights weights = read_refine_weights(file);
  EXPECT_EQ(weights.angle, 33.0);
  EXPECT_EQ(weights.way_shift_m, 2.5);
  EXPECT_EQ(weights.curvature, RefineWeights{}.curvature);

  RefineWeights odd;
  odd.evidence = 1.0 / 3.0, odd.search_step = 1.25e-7;
  write_bytes(file, refine_weights_toml(odd));
  EXPECT_EQ(read_refine_weights(file).evidence, odd.evidence) << "all digits";
  EXPECT_EQ(read_refine_weights(file).search_step, odd.search_step);

  const auto told = [&](const std::string& text) {
    write_bytes(file, text);
    return message_of<InputError>([&] { (void)read_refine_weights(file); });
  };
  EXPECT_THAT(told("angle = 1\nangel = 1\n"), AllOf(HasSubstr("weights.toml:2"), HasSubstr("'angel' is not known")));
  EXPECT_THAT(told("\nwidth = 'wide'\n"), AllOf(HasSubstr("weights.toml:2"), HasSubstr("'width' must be a number")));
  for (const char* value : {"0", "-1", "nan", "inf"})
    EXPECT_THAT(told(std::string("offset = ") + value), HasSubstr("'offset' must be a number above 0"));
  EXPECT_THAT(told("offset"), HasSubstr("weights.toml:1"));
  std::filesystem::remove(file);
  EXPECT_THAT(message_of<InputError>([&] { (void)read_refine_weights(file); }), HasSubstr("no such file"));
}

TEST(TuneCommand, writes_weights_that_refine_takes) {
  const Scratch scratch;
  write_scene(scratch / "left", winding_road(2.5));
  write_scene(scratch / "right", winding_road(-2.0));
  write_bytes(scratch / "sites.toml", entry("left") + entry("right"));
  const std::string out = scratch / "tuned";
  const ToolRun tune = run_tool({"tune", scratch / "sites.toml", "-o", out, "--trials", "4"});
  ASSERT_EQ(tune.exit_code, 0) << tune.err;
  EXPECT_EQ(tune.err, "");
  EXPECT_THAT(tune.out, HasSubstr("Tuned weights gain"));
  const auto report = nlohmann::json::parse(bytes_of(scratch / "tuned/report.json"));
  EXPECT_EQ(report["trials"], 4);
  EXPECT_THAT(tune.out, HasSubstr(report["verdict"].get<std::string>()));

  const ToolRun no_folder = run_tool({"tune", scratch / "sites.toml", "-o", scratch / "sites.toml", "--trials", "0"});
  EXPECT_EQ(no_folder.exit_code, 2);
  EXPECT_THAT(no_folder.err, HasSubstr("cannot make this folder"));

  const auto refined = [&](const Arguments& more) {
    Arguments arguments{"-q",       "refine",
                        "--osm",    scratch / "left/roads.osm",
                        "--labels", scratch / "left/labels.tif",
                        "-o",       scratch / "roads.gpkg"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun run = run_tool(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return bytes_of(scratch / "roads.gpkg");
  };
  write_bytes(scratch / "shipped.toml", refine_weights_toml({}));
  write_bytes(scratch / "stubborn.toml", refine_weights_toml(stubborn()));
  const std::string without = refined({});
  EXPECT_NE(refined({"--weights-file", out + "/weights.toml"}), "");
  EXPECT_TRUE(refined({"--weights-file", scratch / "shipped.toml"}) == without);
  EXPECT_FALSE(refined({"--weights-file", scratch / "stubborn.toml"}) == without);
  const ToolRun nlo =
      run_tool({"refine", "--osm", scratch / "left/roads.osm", "--labels", scratch / "left/labels.tif", "-o",
                scratch / "roads.gpkg", "--method", "nlo", "--weights-file", scratch / "shipped.toml"});
  EXPECT_EQ(nlo.exit_code, 2);
  EXPECT_THAT(nlo.err, HasSubstr("--weights-file"));
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// The sub-command as users run it: files, not structs.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "orthodrive/core/hash.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

class SynthCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(paths::tool)) GTEST_SKIP() << "the tool is not built: " << paths::tool;
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] int run(const std::string& arguments) const { return run_synth("--size 200 --gsd 0.5 " + arguments); }
  /// What goes to stderr is in folder_ / "stderr".
  [[nodiscard]] int run_synth(const std::string& arguments) const {
    const std::string command =
        std::string(paths::tool) + " -q synth " + arguments + " 2>" + (folder_ / "stderr").string();
    return WEXITSTATUS(std::system(command.c_str()));
  }
  /// A circle of 80 m with 100 rows; `width` is that of its right half.
  [[nodiscard]] std::string write_track(const std::string& width) const {
    std::ofstream file(folder_ / "track.csv");
    file << "# utm33_e,utm33_n,w_tr_right_m,w_tr_left_m\n";
    for (int i = 0; i < 100; ++i)
      file << std::fixed << 480000.0 + 80.0 * std::cos(0.0628318531 * i) << ','
           << 5230000.0 + 80.0 * std::sin(0.0628318531 * i) << ',' << width << ",6\n";
    return (folder_ / "track.csv").string();
  }
  [[nodiscard]] std::map<std::string, std::string> hashes(const std::string& name) const {
    std::map<std::string, std::string> result;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / name))
      if (entry.is_regular_file())
        result[fs::relative(entry.path(), folder_ / name).string()] = hash_file(entry.path());
    return result;
  }
  fs::path folder_ = fs::temp_directory_path() / ("orthodrive_synth_test_" + std::to_string(getpid()));
};

TEST_F(SynthCommand, same_seed_same_files) {
  ASSERT_EQ(run("--seed 3 --threads 1 -o " + (folder_ / "a").string()), 0);
  ASSERT_EQ(run("--seed 3 --threads 2 -o " + (folder_ / "b").string()), 0);
  const auto a = hashes("a");
  EXPECT_EQ(a, hashes("b"));
  for (const char* name :
       {"site.toml", "ortho.tif", "roads.osm", "dtm_1m.tif", "dtm_10m.tif", "truth/labels.tif", "truth/roads.gpkg",
        "truth/surface.geojson", "truth/centrelines.geojson", "truth/dtm_1m.tif"})
    EXPECT_TRUE(a.contains(name)) << name;
}

TEST_F(SynthCommand, files_read_back_as_one_site) {
  ASSERT_EQ(run("--seed 4 -o " + folder_.string()), 0);
  const Photo photo = io::read_photo_native(folder_ / "ortho.tif");
  const LabelMap labels = io::read_labels(folder_ / "truth/labels.tif");
  EXPECT_EQ(photo.frame, labels.frame);
  const Box2 box = photo.frame.bounds();
  EXPECT_EQ(box.width(), 200.0);
  const SiteFrame site{
      photo.crs,
      {{{box.min_x, box.min_y}, {box.max_x, box.min_y}, {box.max_x, box.max_y}, {box.min_x, box.max_y}}, {}}};
  for (const char* name : {"dtm_1m.tif", "dtm_10m.tif"}) {
    const std::array dtm{io::read_dtm(folder_ / name, site)};
    EXPECT_EQ(io::coverage(dtm, site), 1.0) << name;
  }
  RoadNetwork osm = io::read_osm_roads(folder_ / "roads.osm", site),
              truth = io::read_roads(folder_ / "truth/roads.gpkg");
  for (RoadNetwork* roads : {&osm, &truth}) std::ranges::stable_sort(roads->paths, {}, &RoadPath::osm_id);
  ASSERT_EQ(osm.paths.size(), truth.paths.size());
  for (std::size_t i = 0; i < osm.paths.size(); ++i) {
    EXPECT_EQ(osm.paths[i].osm_id, truth.paths[i].osm_id);
    EXPECT_EQ(osm.paths[i].highway, truth.paths[i].highway);
    EXPECT_EQ(osm.paths[i].bridge, truth.paths[i].bridge);
  }
}

TEST_F(SynthCommand, a_junction_has_no_route_to_drive) {
  ASSERT_EQ(run_synth("--preset junction --size 500 --gsd 2 -o " + (folder_ / "j").string()), 0);
  std::ifstream file(folder_ / "j/site.toml");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(text.find("[drive]"), std::string::npos);
  EXPECT_NE(text.find("Junction 7"), std::string::npos);
}

TEST_F(SynthCommand, a_track_becomes_a_site) {
  ASSERT_EQ(run_synth("--from-track " + write_track("5") + " --gsd 0.5 -o " + (folder_ / "t").string()), 0);
  const RoadNetwork truth = io::read_roads(folder_ / "t/truth/roads.gpkg");
  ASSERT_EQ(truth.paths.size(), 1u);
  EXPECT_EQ(truth.paths[0].highway, "raceway");
  // Counter-clockwise: right is outside, so the middle lies 0.5 m inside the surveyed line.
  EXPECT_NEAR(truth.paths[0].nodes.back().s_m, 2.0 * 3.14159265 * 79.5, 0.05);
  EXPECT_NEAR(truth.paths[0].nodes[40].width_m, 11.0, 0.01);
}

TEST_F(SynthCommand, a_bad_track_ends_with_one_line_and_writes_nothing) {
  const auto refused = [&](const std::string& arguments) {
    EXPECT_EQ(run_synth(arguments + " -o " + (folder_ / "x").string()), 1);
    std::ifstream file(folder_ / "stderr");
    const std::string text(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    EXPECT_FALSE(fs::exists(folder_ / "x"));
  };
  refused("--from-track " + write_track("0"));
  refused("--from-track " + (folder_ / "missing.csv").string());
  refused("--from-track " + write_track("5") + " --track-osm " + (folder_ / "missing.osm").string());
  refused("--from-track " + write_track("5") + " --track-heights " + (folder_ / "track.csv").string());
  EXPECT_EQ(run("--from-track " + write_track("5") + " -o " + (folder_ / "x").string()), 2);  // --size
  EXPECT_EQ(run_synth("--track-osm a.osm -o " + (folder_ / "x").string()), 2);
}

TEST_F(SynthCommand, wrong_options_end_with_exit_code_2) {
  EXPECT_EQ(run("--preset moon -o " + (folder_ / "x").string()), 2);
  EXPECT_EQ(run("--gsd -1 -o " + (folder_ / "x").string()), 2);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

}  // namespace
}  // namespace orthodrive

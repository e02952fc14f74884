// The sub-command as users run it: files, not structs.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "orthodrive/core/hash.hpp"
#include "orthodrive/io/raster_io.hpp"
#include "orthodrive/io/vector_io.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

class SynthCommand : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(ORTHODRIVE_TOOL)) GTEST_SKIP() << "the tool is not built: " << ORTHODRIVE_TOOL;
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] int run(const std::string& arguments) const {
    const std::string command =
        std::string(ORTHODRIVE_TOOL) + " -q synth --size 200 --gsd 0.5 " + arguments + " 2>/dev/null";
    return WEXITSTATUS(std::system(command.c_str()));
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
  const RoadNetwork osm = io::read_osm_roads(folder_ / "roads.osm", site),
                    truth = io::read_roads(folder_ / "truth/roads.gpkg");
  ASSERT_EQ(osm.paths.size(), truth.paths.size());
  for (std::size_t i = 0; i < osm.paths.size(); ++i) {
    EXPECT_EQ(osm.paths[i].osm_id, truth.paths[i].osm_id);
    EXPECT_EQ(osm.paths[i].highway, truth.paths[i].highway);
    EXPECT_EQ(osm.paths[i].bridge, truth.paths[i].bridge);
  }
}

TEST_F(SynthCommand, wrong_options_end_with_exit_code_2) {
  EXPECT_EQ(run("--preset moon -o " + (folder_ / "x").string()), 2);
  EXPECT_EQ(run("--gsd -1 -o " + (folder_ / "x").string()), 2);
  EXPECT_FALSE(fs::exists(folder_ / "x"));
}

}  // namespace
}  // namespace orthodrive

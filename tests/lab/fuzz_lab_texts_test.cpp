// SPDX-License-Identifier: Apache-2.0
// Descriptions that people write for the laboratory: experiments, tracks.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fuzz/expect_survives.hpp"
#include "orthodrive/lab/training/experiment.hpp"
#include "orthodrive/synth/plan/track_table.hpp"

namespace orthodrive::fuzz {
namespace {
namespace fs = std::filesystem;

const std::string experiment = R"(network = "n.toml"
weights = ["a.safetensors", "b.caffemodel"]
[train]
steps = 100
solver = "sgd"
turn = "quarters"
class_weights = [1.0, 2.0]
[crf]
steps = 10
[[stage]]
stride = 32
steps = 50
[[map]]
name = "m"
photo = "p.tif"
bbox_wgs84 = [15.0, 50.0, 15.1, 50.1]
background = ["ground"]
[[map.paint]]
file = "a.osm"
where = { building = ["yes"] }
classes = ["road"]
[[images]]
name = "i"
images = "a"
labels = "b"
[[images.palette]]
color = [255, 0, 0]
classes = ["road"]
[[raster]]
name = "r"
folder = "v"
mapping = { a = ["road"], b = [] }
)";

const std::string track = [] {
  std::string text = "# w_tr_right_m,w_tr_left_m,utm33_e,utm33_n\n";
  for (int i = 0; i < 24; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 24;
    text +=
        fmt::format("5.5,6.0,{:.2f},{:.2f}\n", 478000.0 + 100.0 * std::cos(angle), 5229000.0 + 90.0 * std::sin(angle));
  }
  return text;
}();

const std::string heights = "lon,lat,elev_m\n14.76,47.21,680\n14.77,47.22,690.5\n14.75,47.22,700\n14.76,47.23,660\n";

TEST(FuzzLabTexts, experiment_toml) {
  expect_survives("a.toml", experiment, [](const fs::path& file) { (void)parse_experiment(bytes_of(file), file); });
}
TEST(FuzzLabTexts, track_table) {
  expect_survives("a.csv", track,
                  [](const fs::path& file) { (void)synth::parse_track(bytes_of(file), file.string()); });
}
TEST(FuzzLabTexts, height_table) {
  expect_survives("a.csv", heights,
                  [](const fs::path& file) { (void)synth::parse_heights(bytes_of(file), file.string()); });
}

}  // namespace
}  // namespace orthodrive::fuzz

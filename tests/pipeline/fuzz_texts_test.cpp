// SPDX-License-Identifier: Apache-2.0
// Descriptions that people write: TOML, tables, JSON.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "fuzz/expect_survives.hpp"
#include "orthodrive/io/osm/area_reader.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"
#include "orthodrive/model/site_area.hpp"
#include "orthodrive/nets/model_metadata.hpp"
#include "orthodrive/pipeline/files/network_spec.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "orthodrive/pipeline/training/experiment.hpp"
#include "orthodrive/synth/plan/track_table.hpp"

namespace orthodrive::fuzz {
namespace {
namespace fs = std::filesystem;

const std::string class_table = R"(name = "t"
[[class]]
name = "a"
color = [1, 2, 3]
role = "road"
[[class]]
name = "b"
color = [4, 5, 6]
role = "ground"
cost_false_negative = 0.2
)";

const std::string network_spec = R"(trunk = "vgg16"
stride = 8
decoder = "fcn"
gsd_m = 0.2
finest_gsd_m = 0.1
classes = "../classes/c.toml"
)";

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

TEST(FuzzTexts, class_table_toml) {
  expect_survives("a.toml", class_table, [](const fs::path& file) { (void)parse_class_table(bytes_of(file), file); });
}
TEST(FuzzTexts, network_toml) {
  expect_survives("a.toml", network_spec, [](const fs::path& file) { (void)parse_network_spec(bytes_of(file), file); });
}
TEST(FuzzTexts, experiment_toml) {
  expect_survives("a.toml", experiment, [](const fs::path& file) { (void)parse_experiment(bytes_of(file), file); });
}

const std::string site = R"(name = "K"
[area]
crs = "auto"
polygon = [[12.0, 57.0], [12.1, 57.0], [12.05, 57.1], [12.0, 57.0]]
[sources]
photo = "p.tif"
osm = ["r.osm"]
dtm = ["a.tif", "b.tif"]
gpx = "t.gpx"
[segment]
crf = true
[refine]
driving_side = "left"
[network]
crg = ["way/7"]
opendrive = "1.8"
weather = "wet"
[drive]
route = "auto"
[attribution]
text = ["a", "b"]
[truth]
dir = "truth"
)";

TEST(FuzzTexts, site_toml) {
  expect_survives("a.toml", site, [](const fs::path& file) { (void)read_site(file); });
}
TEST(FuzzTexts, area_geojson) {
  const std::string sample =
      R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon",)"
      R"("coordinates":[[[[12.0,57.0],[12.1,57.0],[12.05,57.1],[12.0,57.0]]]]}}]})";
  expect_survives("a.geojson", sample, [](const fs::path& file) {
    for (const Polygon& polygon : io::read_areas(file)) (void)site_frame_of(polygon);
  });
}

TEST(FuzzTexts, track_table) {
  expect_survives("a.csv", track,
                  [](const fs::path& file) { (void)synth::parse_track(bytes_of(file), file.string()); });
}
TEST(FuzzTexts, height_table) {
  expect_survives("a.csv", heights,
                  [](const fs::path& file) { (void)synth::parse_heights(bytes_of(file), file.string()); });
}
TEST(FuzzTexts, model_metadata) {
  const std::string classes = format_model_metadata({"vgg16-8s", default_class_table(), 0.5}).at("classes");
  expect_survives("a.json", classes, [](const fs::path& file) {
    const std::map<std::string, std::string> items{
        {"architecture", "vgg16-8s"}, {"gsd_m", "0.5"}, {"classes", bytes_of(file)}};
    (void)parse_model_metadata(items, file.string());
    (void)class_table_from_json(bytes_of(file));
  });
}

}  // namespace
}  // namespace orthodrive::fuzz

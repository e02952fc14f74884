// SPDX-License-Identifier: Apache-2.0
// Descriptions that people write: TOML, tables, JSON.

#include <gtest/gtest.h>

#include <map>

#include "fuzz/expect_survives.hpp"
#include "orthodrive/io/osm/area_reader.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"
#include "orthodrive/model/site_area.hpp"
#include "orthodrive/nets/model_metadata.hpp"
#include "orthodrive/pipeline/files/network_spec.hpp"
#include "orthodrive/pipeline/sources/site.hpp"

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

TEST(FuzzTexts, class_table_toml) {
  expect_survives("a.toml", class_table, [](const fs::path& file) { (void)parse_class_table(bytes_of(file), file); });
}
TEST(FuzzTexts, network_toml) {
  expect_survives("a.toml", network_spec, [](const fs::path& file) { (void)parse_network_spec(bytes_of(file), file); });
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

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "orthodrive/core/error.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* small = R"(network = "networks/small.toml"
weights = ["weights.safetensors", "vgg.caffemodel"]
[train]
steps = 20
learning_rate = 2e-3
[[map]]
name = "town"
photo = "town/ortho.tif"
bbox_wgs84 = [1.0, 2.0, 3.0, 4.0]
background = ["ground", "grass"]
  [[map.paint]]
  file = "town/roads.osm"
  highways = ["service"]
  classes = ["road"]
  merge_over = ["parking"]
  [[map.paint]]
  file = "town/green.geojson"
  where = { t = ["wood", "park"] }
)";

TEST(Experiment, paths_are_relative_to_the_file) {
  const Experiment e = parse_experiment(small, "models/x.toml");
  EXPECT_EQ(e.network, "models/networks/small.toml");
  EXPECT_EQ(e.weights, (std::vector<std::filesystem::path>{"models/weights.safetensors", "models/vgg.caffemodel"}));
  ASSERT_EQ(e.maps.size(), 1u);
  EXPECT_EQ(e.maps[0].photo, "models/town/ortho.tif");
  EXPECT_EQ(e.maps[0].area_lonlat, (Box2{1.0, 2.0, 3.0, 4.0}));
  EXPECT_FALSE(e.maps[0].held_out_lonlat);
  ASSERT_EQ(e.maps[0].rules.size(), 2u);
  EXPECT_EQ(e.maps[0].rules[0].merge_over, std::vector<std::string>{"parking"});
  EXPECT_EQ(e.maps[0].rules[1].where.at("t"), (std::vector<std::string>{"wood", "park"}));
  EXPECT_EQ(e.train.steps, 20);
  EXPECT_DOUBLE_EQ(e.train.learning_rate, 2e-3);
}

TEST(Experiment, mistakes_are_named_with_their_line) {
  const auto parse = [](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return [text] { static_cast<void>(parse_experiment(text, "x.toml")); };
  };
  EXPECT_THAT(parse(small, "steps = 20", "stepps = 20"),
              ThrowsMessage<InputError>(HasSubstr("x.toml:4: 'stepps' is not known here")));
  EXPECT_THAT(parse(small, "steps = 20", "steps = \"many\""),
              ThrowsMessage<InputError>(HasSubstr("'steps' must be a number")));
  EXPECT_THAT(parse(small, "steps = 20", "steps = = 20"), ThrowsMessage<InputError>(HasSubstr("x.toml:4")));
  EXPECT_THAT(parse(small, "name = \"town\"", ""), ThrowsMessage<InputError>(HasSubstr("'name' is missing")));
  for (const char* name :
       {"../town", "/tmp/town", "a/b", ".town", "", "a\\\\b", "a\\u0007"})  // previews would lie elsewhere
    EXPECT_THAT(parse(small, "name = \"town\"", "name = \"" + std::string(name) + "\""),
                ThrowsMessage<InputError>(HasSubstr("'name' is used as the name of a file")))
        << name;
  EXPECT_THAT(parse(small, "3.0, 4.0]", "3.0]"),
              ThrowsMessage<InputError>(HasSubstr("must be [west, south, east, north]")));
}

TEST(Experiment, presets_stages_mappings_and_truth) {
  const Experiment e = parse_experiment(R"(network = "n.toml"
[train]
preset = "reference"
steps = 300
[[stage]]
stride = 32
steps = 100
[[stage]]
stride = 8
steps = 200
[[raster]]
name = "other"
photo = "a.tif"
labels = "b.tif"
mapping = { track = ["road"], curb = ["road", "ground"], snow = [] }
[[raster]]
name = "village"
folder = "village-1"
held_out = true
[[polygons]]
name = "hand-made"
photo = "a.tif"
polygons = "truth.geojson"
pieces = ["k1"]
)",
                                        "m/x.toml");
  EXPECT_EQ(e.train.solver, Solver::sgd);
  EXPECT_TRUE(e.train.sum_loss);
  EXPECT_EQ(e.train.crop_px, 450);
  EXPECT_EQ(e.train.label_px, 256);
  EXPECT_EQ(e.train.batch, 1);
  EXPECT_DOUBLE_EQ(e.train.learning_rate, 1e-10);
  EXPECT_DOUBLE_EQ(e.train.momentum, 0.99);
  EXPECT_EQ(e.train.steps, 300) << "the file's own keys go over the preset";
  ASSERT_EQ(e.stages.size(), 2u);
  EXPECT_EQ(e.stages[1].stride, 8);
  ASSERT_EQ(e.rasters.size(), 2u);
  EXPECT_EQ(e.rasters[0].mapping.at("curb"), (std::vector<std::string>{"road", "ground"}));
  EXPECT_TRUE(e.rasters[0].mapping.at("snow").empty());
  EXPECT_EQ(e.rasters[1].labels, "m/village-1/truth/labels.tif");
  EXPECT_TRUE(e.rasters[1].held_out);
  ASSERT_EQ(e.polygons.size(), 1u);
  EXPECT_FALSE(e.polygons[0].held_out);
  EXPECT_EQ(e.polygons[0].pieces, std::vector<std::string>{"k1"});
  EXPECT_THROW(static_cast<void>(parse_experiment("network = \"n\"\n[train]\npreset = \"other\"\n", "x")), InputError);
  EXPECT_THROW(static_cast<void>(parse_experiment("network = \"n\"\n[train]\nsteps = 0\n", "x")), InputError);
}

TEST(Experiment, what_is_left_out_is_held_out_as_a_whole) {
  const std::string text = R"(network = "n.toml"
leave_out = ["town", "photos", "painted"]
[train]
domain = 0.5
average_from_step = 7
[[map]]
name = "town"
photo = "a.tif"
bbox_wgs84 = [1.0, 2.0, 3.0, 4.0]
held_out_bbox_wgs84 = [3.0, 2.0, 4.0, 4.0]
background = ["ground"]
[[images]]
name = "photos"
images = "i"
labels = "l"
held_out = ["a"]
palette = [{ color = [0, 0, 0], classes = [] }]
[[images]]
name = "others"
images = "i"
labels = "l"
held_out = ["a"]
palette = [{ color = [0, 0, 0], classes = [] }]
[[polygons]]
name = "painted"
photo = "a.tif"
polygons = "p.geojson"
)";
  Experiment e = parse_experiment(text, "m/x.toml");
  EXPECT_DOUBLE_EQ(e.train.augmentation.domain, 0.5);
  EXPECT_EQ(e.train.average_from_step, 7);
  leave_out_data(e, "x.toml");
  EXPECT_EQ(e.maps[0].use.weight, 0.0) << "no crops, but its held-out box is measured";
  EXPECT_TRUE(e.maps[0].held_out_lonlat);
  EXPECT_EQ(e.images[0].held_out, std::vector<std::string>{"*"});
  EXPECT_EQ(e.images[1].held_out, std::vector<std::string>{"a"});
  EXPECT_TRUE(e.polygons[0].held_out);
  e.leave_out = {"twon"};
  EXPECT_THAT([&] { leave_out_data(e, "x.toml"); },
              ThrowsMessage<InputError>(HasSubstr("x.toml: leave_out names 'twon'")));
  EXPECT_THROW(static_cast<void>(parse_experiment("network = \"n\"\n[train]\ndomain = 1.5\n", "x")), InputError);
}

TEST(Experiment, grid_of_the_crf_is_read_and_checked) {
  const auto with = [](const std::string& crf) {
    return parse_experiment(std::string(small) + "[crf]\n" + crf, "x.toml").crf;
  };
  const CrfExperiment crf = with(
      "theta_alpha_px = [3, 40.5]\ntheta_beta = [7]\nappearance_weight = [0, 1.5]\ntheta_gamma_px = [1]\n"
      "smoothness_weight = []\nfewer_iterations = [1]\niterations = 5\n");
  EXPECT_EQ(crf.search.theta_alpha_px, (std::vector<double>{3.0, 40.5}));
  EXPECT_EQ(crf.search.theta_beta, std::vector<double>{7.0});
  EXPECT_EQ(crf.search.appearance_weight, (std::vector<float>{0.0F, 1.5F}));
  EXPECT_TRUE(crf.search.smoothness_weight.empty());
  EXPECT_EQ(crf.search.fewer_iterations, std::vector<int>{1});
  EXPECT_EQ(crf.search.iterations, 5);
  for (const char* wrong : {"theta_beta = [0]", "theta_gamma_px = []", "theta_alpha_px = [1001]"})
    EXPECT_THAT([&] { (void)with(wrong); }, ThrowsMessage<InputError>(HasSubstr("widths must be from 0.1 to 1000")));
  EXPECT_THAT([&] { (void)with("appearance_weight = [-1]"); },
              ThrowsMessage<InputError>(HasSubstr("weights must be from 0 to 1000")));
}

TEST(Experiment, classes_by_name) {
  EXPECT_EQ(class_set({"road", "parking"}, default_class_table(), "x"), 0b110);
  EXPECT_EQ(class_set({}, default_class_table(), "x"), unknown_class);
  EXPECT_THROW(static_cast<void>(class_set({"raod"}, default_class_table(), "x")), InputError);
}

TEST(Experiment, the_shipped_one_parses) {
  const std::filesystem::path file = paths::in_source("models/default.toml");
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  const Experiment e = parse_experiment(text.str(), file);
  EXPECT_GE(e.maps.size(), 2u);
  for (const MapData& map : e.maps) {
    for (const PaintRule& rule : map.rules) {
      EXPECT_NO_THROW(static_cast<void>(class_set(rule.classes, default_class_table(), map.name)));
    }
  }
}

}  // namespace
}  // namespace orthodrive

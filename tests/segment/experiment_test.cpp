#include "orthodrive/segment/experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* small = R"(trunk = "weights.safetensors"
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
  EXPECT_EQ(e.trunk, "models/weights.safetensors");
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
              ThrowsMessage<InputError>(HasSubstr("x.toml:3: 'stepps' is not known here")));
  EXPECT_THAT(parse(small, "steps = 20", "steps = \"many\""),
              ThrowsMessage<InputError>(HasSubstr("'steps' must be a number")));
  EXPECT_THAT(parse(small, "steps = 20", "steps = = 20"), ThrowsMessage<InputError>(HasSubstr("x.toml:3")));
  EXPECT_THAT(parse(small, "name = \"town\"", ""), ThrowsMessage<InputError>(HasSubstr("'name' is missing")));
  EXPECT_THAT(parse(small, "3.0, 4.0]", "3.0]"),
              ThrowsMessage<InputError>(HasSubstr("must be [west, south, east, north]")));
}

TEST(Experiment, classes_by_name) {
  EXPECT_EQ(class_set({"road", "parking"}, default_class_table(), "x"), 0b110);
  EXPECT_EQ(class_set({}, default_class_table(), "x"), unknown_class);
  EXPECT_THROW(static_cast<void>(class_set({"raod"}, default_class_table(), "x")), InputError);
}

TEST(Experiment, the_shipped_one_parses) {
  const std::filesystem::path file = ORTHODRIVE_SOURCE_DIR "/models/default.toml";
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

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/training/packed_scenes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "io/temporary_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

template <typename T>
Raster<T> counting(int width, int height, int channels, std::size_t modulus) {
  Raster<T> raster(width, height, channels);
  for (std::size_t i = 0; i < raster.data.size(); ++i) raster.data[i] = static_cast<T>(i % modulus);
  return raster;
}

PackedScenes small_data() {
  PackedScenes data;
  data.scenes.push_back(
      {.name = "Pardubice \"west\", ž",
       .rgb = counting<std::uint8_t>(5, 3, 3, 251),
       .allowed = counting<ClassSet>(5, 3, 1, 4),
       .gsd_m = 1.0 / 3.0,
       .weight = 0.1,
       .min_zoom = 0.7,
       .max_zoom = 1.9,
       .from_step = 123456789012,
       .map = {{{{0.1, -2.5}, {3.0, 1.0 / 3.0}}, 2.25}, {{{7.0, 8.0}, {9.0, 10.0}, {11.0, 1e5}}, 0.0}}});
  // Every set of eight classes: the table is full. Larger than one piece of the writer.
  data.scenes.push_back({.name = "all sets",
                         .rgb = counting<std::uint8_t>(400, 700, 3, 256),
                         .allowed = counting<ClassSet>(400, 700, 1, 256)});
  data.scenes.push_back({.name = "nothing known",
                         .rgb = Raster<std::uint8_t>(2, 2, 3, 9),
                         .allowed = Raster<ClassSet>(2, 2, 1, unknown_class)});
  data.scenes.push_back({.name = "empty", .rgb = Raster<std::uint8_t>(0, 0, 3), .allowed = Raster<ClassSet>(0, 0)});
  // The highest class alone: the sign bit of I64 once a set has 64 bits.
  data.scenes.push_back(
      {.name = "last class",
       .rgb = Raster<std::uint8_t>(1, 1, 3, 1),
       .allowed = Raster<ClassSet>(1, 1, 1, static_cast<ClassSet>(ClassSet{1} << (8 * sizeof(ClassSet) - 1)))});
  ValidationScene held_out{.name = "held out"};
  held_out.photo.crs.definition = "EPSG:32633";
  held_out.photo.frame = {.west_m = 559000.1, .north_m = 5542000.7, .gsd_m = 0.5, .width = 4, .height = 2};
  held_out.photo.rgb = counting<std::uint8_t>(4, 2, 3, 17);
  held_out.photo.valid = counting<std::uint8_t>(4, 2, 1, 2);
  held_out.allowed = counting<ClassSet>(4, 2, 1, 3);
  held_out.map = std::vector<RoadLine>{{{{1.0, 1.5}, {2.0, 1.5}}, 3.0}};
  data.validation = {held_out, held_out};  // scenes of one name count together
  data.metadata = {{"experiment", "[train]\nsteps = 5 # é\n"}, {"classes", "{}"}};
  return data;
}

std::string packed_bytes(const PackedScenes& data) {
  std::ostringstream out;
  write_packed_scenes(out, data);
  return std::move(out).str();
}

template <typename T>
void expect_same(const Raster<T>& a, const Raster<T>& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_TRUE(a.data == b.data);
}

TEST(PackedScenes, write_read_gives_the_same) {
  const PackedScenes data = small_data();
  const TemporaryFile file(packed_bytes(data));
  const PackedScenes back = read_packed_scenes(file.path());
  EXPECT_EQ(back.metadata, data.metadata);
  ASSERT_EQ(back.scenes.size(), data.scenes.size());
  for (std::size_t i = 0; i < data.scenes.size(); ++i) {
    const TrainingScene &a = back.scenes[i], &b = data.scenes[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.gsd_m, b.gsd_m);
    EXPECT_EQ(a.weight, b.weight);
    EXPECT_EQ(a.min_zoom, b.min_zoom);
    EXPECT_EQ(a.max_zoom, b.max_zoom);
    EXPECT_EQ(a.from_step, b.from_step);
    ASSERT_EQ(a.map.size(), b.map.size());
    for (std::size_t k = 0; k < a.map.size(); ++k) {
      EXPECT_EQ(a.map[k].points, b.map[k].points);
      EXPECT_EQ(a.map[k].half_width, b.map[k].half_width);
    }
    expect_same(a.rgb, b.rgb);
    expect_same(a.allowed, b.allowed);
  }
  ASSERT_EQ(back.validation.size(), 2u);
  for (const ValidationScene& scene : back.validation) {
    EXPECT_EQ(scene.name, "held out");
    EXPECT_EQ(scene.photo.crs, data.validation[0].photo.crs);
    EXPECT_EQ(scene.photo.frame, data.validation[0].photo.frame);
    expect_same(scene.photo.rgb, data.validation[0].photo.rgb);
    expect_same(scene.photo.valid, data.validation[0].photo.valid);
    expect_same(scene.allowed, data.validation[0].allowed);
  }
  EXPECT_EQ(packed_bytes(back), packed_bytes(data));
}

TEST(PackedScenes, a_label_takes_one_byte) {
  const TemporaryFile file(packed_bytes(small_data()));
  SafetensorsReader reader(file.path());
  EXPECT_EQ(reader.place("scene/1/allowed", TensorType::u8).size(), 400u * 700u);
  EXPECT_EQ(reader.place("scene/1/sets", TensorType::i64).shape, std::vector<std::int64_t>{256});
}

// Only sets of more than eight bits can be so many.
TEST(PackedScenes, more_than_256_sets_are_stored_as_they_are) {
  if constexpr (sizeof(ClassSet) == 1) {
    GTEST_SKIP() << "a set has eight bits";
  } else {
    PackedScenes data;
    data.scenes.push_back({.rgb = Raster<std::uint8_t>(257, 600, 3), .allowed = counting<ClassSet>(257, 600, 1, 257)});
    const TemporaryFile file(packed_bytes(data));
    EXPECT_FALSE(SafetensorsReader(file.path()).tensors().contains("scene/0/sets"));
    expect_same(read_packed_scenes(file.path()).scenes.at(0).allowed, data.scenes[0].allowed);
  }
}

TEST(PackedScenes, nothing_is_a_data_set_too) {
  const TemporaryFile file(packed_bytes({}));
  EXPECT_TRUE(read_packed_scenes(file.path()).scenes.empty());
}

TEST(PackedScenes, rasters_of_different_size_are_not_written) {
  const auto refused = [](const auto& spoil) {
    PackedScenes data = small_data();
    spoil(data);
    std::ostringstream out;
    EXPECT_THROW(write_packed_scenes(out, data), Error);
    EXPECT_TRUE(out.str().empty());
  };
  refused([](PackedScenes& data) { data.scenes[0].allowed = Raster<ClassSet>(3, 5); });
  refused([](PackedScenes& data) { data.scenes[0].rgb = Raster<std::uint8_t>(5, 3, 1); });
  refused([](PackedScenes& data) { data.scenes[0].allowed.data.pop_back(); });
  refused([](PackedScenes& data) { data.validation[1].photo.valid = {}; });
}

TEST(PackedScenes, every_truncation_is_an_input_error) {
  PackedScenes data = small_data();
  data.scenes.erase(data.scenes.begin() + 1);  // the large one
  const std::string bytes = packed_bytes(data);
  for (std::size_t length = 0; length < bytes.size(); length += 7) {
    const TemporaryFile file(std::string_view(bytes).substr(0, length));
    EXPECT_THROW(static_cast<void>(read_packed_scenes(file.path())), InputError) << length;
  }
}

/// A file with one scene of 2 x 1 pixels, of which the test spoils something.
struct RawFile {
  std::string version = "1";
  std::string scenes =
      R"([{"part":"train","name":"a","gsd_m":0.5,"weight":1,"min_zoom":1,"max_zoom":1,"from_step":0}])";
  TensorSpec rgb{"scene/0/rgb", TensorType::u8, {1, 2, 3}};
  TensorSpec allowed{"scene/0/allowed", TensorType::u8, {1, 2}};
  std::vector<std::uint8_t> labels{1, 0};
  std::vector<std::int64_t> sets{0, 1};

  void read() const {
    std::ostringstream out;
    SafetensorsWriter writer(
        out, {{"packed_scenes", version}, {"scenes", scenes}},
        {rgb, allowed, {"scene/0/sets", TensorType::i64, {static_cast<std::int64_t>(sets.size())}}});
    writer.write(rgb.name, std::vector<std::byte>(byte_count(rgb)));
    writer.write(allowed.name, std::as_bytes(std::span(labels)));
    writer.write("scene/0/sets", std::as_bytes(std::span(sets)));
    writer.finish();
    const TemporaryFile file(out.str());
    static_cast<void>(read_packed_scenes(file.path()));
  }
};

TEST(PackedScenes, damaged_contents_name_the_scene) {
  EXPECT_NO_THROW(RawFile{}.read());
  const auto message = [](const char* text) { return ThrowsMessage<InputError>(HasSubstr(text)); };
  const auto spoilt = [](const auto& spoil) {
    return [spoil] {
      RawFile file;
      spoil(file);
      file.read();
    };
  };
  EXPECT_THAT(spoilt([](RawFile& f) { f.labels = {1, 2}; }), message("scene 0: a label points outside"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.sets = {}; }), message("scene 0: a label points outside"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.allowed.shape = {2, 1}; }), message("not of the size of the photo"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.rgb.shape = {1, 2, 4}; }), message("H x W x 3"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.rgb.shape = {6}; }), message("H x W x 3"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.rgb.shape = {0, 1LL << 40, 3}; }), message("H x W x 3"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.rgb.name = "scene/1/rgb"; }), message("has no tensor 'scene/0/rgb'"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.version = "2"; }), message("format 2"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.scenes = "[{]"; }), message("description"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.scenes = "{\"a\":1}"; }), message("description"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.scenes = R"([{"part":"train"}])"; }), message("description"));
  EXPECT_THAT(spoilt([](RawFile& f) { f.scenes = R"([{"part":"test"}])"; }), message("unknown part 'test'"));
  if constexpr (sizeof(ClassSet) == 1) {
    EXPECT_THAT(spoilt([](RawFile& f) { f.sets = {0, 256}; }), message("more than 8 classes"));
  }
}

TEST(PackedScenes, a_model_file_is_told_apart) {
  TensorFile model;
  model.tensors["head/kernel"] = {{1}, {1.0F}, TensorType::f32};
  const TemporaryFile file(format_safetensors(model));
  EXPECT_THAT([&] { static_cast<void>(read_packed_scenes(file.path())); },
              ThrowsMessage<InputError>(HasSubstr("train --pack")));
}

}  // namespace
}  // namespace orthodrive

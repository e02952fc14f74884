// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/road_forest.hpp"

#include <gtest/gtest.h>

#include "baselines/photo_scene.hpp"
#include "orthodrive/baselines/edge_distance.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

using namespace test;

const RoadForestOptions small_forest{.trees = 20, .max_samples = 2000, .threads = 1};

RoadForests trained() {
  static const RoadForests forests = [] {
    const RoadScene scene = make_photo_scene(200.0);
    const Photo photo = paint_photo(scene.labels, 1);
    return train_road_forests(std::vector{sample_of(scene.labels, photo)}, small_forest);
  }();
  return forests;
}

/// Mean of a raster over the pixels of one class, 0..1.
double mean_over(const Raster<std::uint8_t>& raster, const LabelMap& labels, std::uint8_t label) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < raster.data.size(); ++i)
    if (labels.labels.data[i] == label) sum += raster.data[i] / 255.0, count += 1.0;
  return sum / count;
}

TEST(RoadForest, road_is_told_from_grass_and_trees) {
  RoadScene scene = make_scene(150.0, 0.4);
  add_truth(scene, straight(at(5, 30), at(140, 120)), 6.0);
  paint_disc(scene.labels, at(40, 110), 15.0, label_vegetation);
  const Photo photo = paint_photo(scene.labels, 2);
  const auto p = predict_road_forests(trained(), source_of(photo), pixels_of(photo.frame));
  EXPECT_GT(mean_over(p.road, scene.labels, label_road), 0.85);
  EXPECT_LT(mean_over(p.road, scene.labels, label_grass), 0.08);
  EXPECT_LT(mean_over(p.road, scene.labels, label_vegetation), 0.08);
  EXPECT_LT(mean_over(p.context, scene.labels, label_road), 0.15);
  EXPECT_GT(mean_over(p.context, scene.labels, label_grass), 0.9);
}

/// Grey pavements beside a road, a little lighter than the road but both as uneven as the difference, in a lot of
/// grass.
struct PavedScene {
  LabelMap labels;  // label_ground: pavement
  Photo photo;
};
PavedScene make_paved_scene(std::uint64_t seed) {
  RoadScene scene = make_scene(300.0, 0.4);
  paint(scene.labels, {at(0, 144), at(300, 144), at(300, 156), at(0, 156)}, label_ground);
  paint(scene.labels, {at(0, 147), at(300, 147), at(300, 153), at(0, 153)}, label_road);
  PavedScene paved{scene.labels, paint_photo(scene.labels, seed)};
  Random random(seed + 100);
  std::vector<double> patches;  // 3 x 3 m each, of its own brightness
  for (int i = 0; i < 101 * 101; ++i) patches.push_back(random.normal());
  for (int y = 0; y < paved.photo.frame.height; ++y)
    for (int x = 0; x < paved.photo.frame.width; ++x) {
      const std::uint8_t label = paved.labels.labels.at(x, y);
      if (label == label_grass) continue;
      const double patch =
          patches[static_cast<std::size_t>(101 * static_cast<int>(y * 0.4 / 3.0) + static_cast<int>(x * 0.4 / 3.0))];
      const double grey = (label == label_road ? 118.0 : 130.0) + 8.0 * patch + 4.0 * random.normal();
      for (int k = 0; k < 3; ++k) paved.photo.rgb.at(x, y, k) = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
    }
  return paved;
}

TEST(RoadForest, a_pavement_is_told_from_the_road_though_most_of_the_map_is_grass) {
  const PavedScene learned = make_paved_scene(21), seen = make_paved_scene(22);
  const auto road_on_pavement = [&](double near_share) {
    RoadForestOptions options = small_forest;
    options.near_share = near_share;
    const RoadForests forests = train_road_forests(std::vector{sample_of(learned.labels, learned.photo)}, options);
    const auto p = predict_road_forests(forests, source_of(seen.photo), pixels_of(seen.photo.frame));
    EXPECT_GT(mean_over(p.road, seen.labels, label_road), 0.6);
    return mean_over(p.road, seen.labels, label_ground);
  };
  const double half = road_on_pavement(0.5), few = road_on_pavement(0.08);
  std::printf("road on pavement: %.2f, drawn with all else %.2f\n", half, few);
  EXPECT_LT(half, 0.2);
  EXPECT_GT(few, half + 0.06);
}

TEST(RoadForest, parking_and_missing_labels_teach_nothing) {
  RoadScene scene = make_scene(20.0, 0.5);
  paint(scene.labels, {at(0, 0), at(10, 0), at(10, 10), at(0, 10)}, label_parking);
  paint(scene.labels, {at(10, 0), at(20, 0), at(20, 10), at(10, 10)}, label_road);
  paint(scene.labels, {at(0, 10), at(10, 10), at(10, 20), at(0, 20)}, label_nodata);
  const GridFrame fine{scene.labels.frame.west_m, scene.labels.frame.north_m, 0.25, 100, 80};  // 5 m more to the east
  const auto mask = road_mask(scene.labels, fine);
  const auto is = [&](int x, int y) { return static_cast<RoadMask>(mask.at(x, y)); };
  EXPECT_EQ(is(39, 41), RoadMask::unknown);  // parking
  EXPECT_EQ(is(41, 41), RoadMask::road);
  EXPECT_EQ(is(39, 38), RoadMask::unknown);  // nodata
  EXPECT_EQ(is(41, 38), RoadMask::context);  // grass
  EXPECT_EQ(is(81, 41), RoadMask::unknown);  // beyond the labels
}

TEST(RoadForest, a_pixel_is_the_same_in_every_box_and_for_any_thread_count) {
  const RoadScene scene = make_photo_scene(240.0);  // 600 pixels: tiles of 512 end inside
  const Photo photo = paint_photo(scene.labels, 3);
  const PixelBox part{470, 250, 100, 90};
  const auto all = predict_road_forests(trained(), source_of(photo), pixels_of(photo.frame), 2);
  const auto some = predict_road_forests(trained(), source_of(photo), part, 1);
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      ASSERT_EQ(some.road.at(x, y), all.road.at(470 + x, 250 + y)) << x << " " << y;
      ASSERT_EQ(some.context.at(x, y), all.context.at(470 + x, 250 + y));
    }
}

TEST(RoadForest, pixels_without_a_photo_are_not_valid_and_change_little) {
  const RoadScene scene = make_photo_scene(200.0);
  Photo photo = paint_photo(scene.labels, 4);
  const auto whole = predict_road_forests(trained(), source_of(photo), pixels_of(photo.frame));
  for (int y = 0; y < photo.frame.height; ++y)
    for (int x = 0; x < 200; ++x) {
      photo.valid.at(x, y) = 0;
      for (int k = 0; k < 3; ++k) photo.rgb.at(x, y, k) = 0;
    }
  const auto p =
      predict_road_forests(trained(), source_of(photo), {-50, 0, photo.frame.width + 50, photo.frame.height});
  int changed = 0, pixels = 0;
  for (int y = 0; y < photo.frame.height; ++y) {
    EXPECT_EQ(p.valid.at(10, y), 0);  // beyond the frame
    EXPECT_EQ(p.valid.at(240, y), 0);
    EXPECT_EQ(p.valid.at(260, y), 1);
    for (int x = 200; x < photo.frame.width; ++x)
      ++pixels, changed += std::abs(p.road.at(50 + x, y) - whole.road.at(x, y)) > 100;
  }
  EXPECT_LT(changed, 0.02 * pixels);
}

TEST(RoadForest, saved_text_loads_as_the_same_forests) {
  const std::string text = save_road_forests(trained());
  const RoadForests loaded = load_road_forests(text);
  EXPECT_EQ(save_road_forests(loaded), text);
  const RoadScene scene = make_photo_scene(100.0);
  const Photo photo = paint_photo(scene.labels, 5);
  const auto a = predict_road_forests(trained(), source_of(photo), pixels_of(photo.frame));
  const auto b = predict_road_forests(loaded, source_of(photo), pixels_of(photo.frame));
  EXPECT_EQ(a.road.data, b.road.data);
  EXPECT_EQ(a.context.data, b.context.data);
}

TEST(RoadForest, texts_that_hold_no_forests_are_refused) {
  EXPECT_THROW((void)load_road_forests(""), InputError);
  EXPECT_THROW((void)load_road_forests("no yaml: ["), InputError);
  EXPECT_THROW((void)load_road_forests("%YAML:1.0\n---\nx: 1\n"), InputError);
  const std::string text = save_road_forests(trained());
  EXPECT_THROW((void)load_road_forests(text.substr(0, text.size() / 3)), InputError);
  const auto broken = [&](const std::string& key, const std::string& value) {
    std::string changed = text;
    const std::size_t from = changed.find(key + ":");
    EXPECT_NE(from, std::string::npos) << key;
    return changed.replace(from, changed.find('\n', from) - from, key + ": " + value);
  };
  EXPECT_NO_THROW((void)load_road_forests(broken("texture_m", "5.")));
  for (const auto& [key, value] : {std::pair{"superpixel_size_m", "-2."},
                                   {"superpixel_iterations", "2000000000"},
                                   {"texture_m", "1e9"},
                                   {"coarsest_gsd_m", ".Nan"},
                                   {"finest_gsd_m", "50."},
                                   {"class_labels", "[ 0, 2 ]"},
                                   {"is_classifier", "0"},
                                   {"orthodrive_road_forests", "99"}})
    EXPECT_THROW((void)load_road_forests(broken(key, value)), InputError) << key;
}

TEST(RoadForest, training_does_not_depend_on_threads_but_on_the_seed) {
  const RoadScene scene = make_photo_scene(240.0);
  const std::vector samples{sample_of(scene.labels, paint_photo(scene.labels, 6))};
  RoadForestOptions options{.trees = 5, .max_samples = 300, .threads = 1};
  const std::string one = save_road_forests(train_road_forests(samples, options));
  options.threads = 2;
  EXPECT_EQ(save_road_forests(train_road_forests(samples, options)), one);
  options.seed = 2;
  EXPECT_NE(save_road_forests(train_road_forests(samples, options)), one);
}

TEST(RoadForest, wrong_samples_and_photos_are_refused) {
  const RoadScene scene = make_photo_scene(80.0);
  const Photo photo = paint_photo(scene.labels, 7);
  const RoadForestSample good = sample_of(scene.labels, photo);
  const auto train = [](const RoadForestSample& sample) {
    (void)train_road_forests(std::vector{sample}, small_forest);
  };
  RoadForestSample bad = good;
  bad.mask = Raster<std::uint8_t>(3, 3);
  EXPECT_THROW(train(bad), OptionError);
  bad = good, bad.gsd_m = 0.0;
  EXPECT_THROW(train(bad), OptionError);
  bad = good, bad.mask.data.assign(bad.mask.data.size(), static_cast<std::uint8_t>(RoadMask::context));
  EXPECT_THROW(train(bad), OptionError);  // no road
  Photo coarse = photo;
  coarse.frame.gsd_m = 1.0;
  EXPECT_THROW((void)predict_road_forests(trained(), source_of(coarse), pixels_of(coarse.frame)), OptionError);
}

/// Grey left of column 60, lighter by `step` from there on.
Raster<std::uint8_t> step_photo(int step) {
  Raster<std::uint8_t> rgb(120, 40, 3, 100);
  for (int y = 0; y < 40; ++y)
    for (int x = 60; x < 120; ++x)
      for (int k = 0; k < 3; ++k) rgb.at(x, y, k) = static_cast<std::uint8_t>(100 + step);
  return rgb;
}

TEST(EdgeDistance, grows_with_the_distance_to_an_edge_up_to_the_cap) {
  const auto d = edge_distance(step_photo(100), {}, 0.2);
  EXPECT_LE(std::min(d.at(59, 20), d.at(60, 20)), 0);
  for (const int away : {3, 6, 9}) EXPECT_NEAR(d.at(60 + away, 20) / 255.0 * 2.0, 0.2 * away, 0.21) << away;
  EXPECT_EQ(d.at(20, 20), 255);
  EXPECT_EQ(d.at(110, 20), 255);
}

TEST(EdgeDistance, an_edge_that_fewer_thresholds_see_attracts_less) {
  const auto nearest = [](int step) {
    const auto d = edge_distance(step_photo(step), {}, 0.2);
    return std::min(d.at(59, 20), d.at(60, 20));
  };
  EXPECT_EQ(nearest(2), 255);  // seen by none
  EXPECT_GT(nearest(22), 60);
  EXPECT_LT(nearest(22), 200);
  EXPECT_EQ(nearest(100), 0);  // seen by all
}

TEST(EdgeDistance, the_border_of_nodata_is_no_edge) {
  Raster<std::uint8_t> rgb = step_photo(100), valid(120, 40, 1, 1);
  for (int y = 0; y < 40; ++y)
    for (int x = 60; x < 120; ++x) valid.at(x, y) = 0;
  const auto d = edge_distance(rgb, valid, 0.2);
  for (int x = 0; x < 60; ++x) EXPECT_EQ(d.at(x, 20), 255) << x;
}

TEST(EdgeDistance, a_pixel_is_the_same_in_every_box) {
  const RoadScene scene = make_photo_scene(240.0);
  const Photo photo = paint_photo(scene.labels, 8);
  const PixelBox part{480, 260, 80, 70};
  const auto all = edge_distance(source_of(photo), pixels_of(photo.frame)),
             some = edge_distance(source_of(photo), part);
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) ASSERT_EQ(some.at(x, y), all.at(480 + x, 260 + y));
}

TEST(EdgeDistance, senseless_options_are_refused) {
  EXPECT_THROW((void)edge_distance(step_photo(9), {}, 0.2, {.thresholds = {}}), OptionError);
  EXPECT_THROW((void)edge_distance(step_photo(9), {}, 0.2, {.cap_m = 0.0}), OptionError);
}

}  // namespace
}  // namespace orthodrive

#include "orthodrive/segment/train_network.hpp"

#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/segment/make_network.hpp"
#include "orthodrive/segment/net_surgery.hpp"
#include "orthodrive/segment/resample_photo.hpp"
#include "segment/shipped_model.hpp"

namespace orthodrive {
namespace {

/// A bright square (class 1) on dark ground (class 0), with a strip where either may be.
TrainingScene toy_scene() {
  TrainingScene scene{
      .name = "toy", .rgb = Raster<std::uint8_t>(96, 96, 3, 60), .allowed = Raster<ClassSet>(96, 96, 1, only(0))};
  for (int row = 30; row < 66; ++row) {
    for (int col = 30; col < 66; ++col) {
      for (int c = 0; c < 3; ++c) scene.rgb.at(col, row, c) = 200;
      scene.allowed.at(col, row) = only(1);
    }
    scene.allowed.at(29, row) = only(0) | only(1);
  }
  return scene;
}

ModelMetadata default_metadata() { return {"mobilenetv2-s16-fpn2", default_class_table(), 0.5}; }

/// The shipped trunk with a decoder that knows nothing yet.
TensorFile fresh_weights() {
  TensorFile trunk = shipped_tensors();
  std::erase_if(trunk.tensors, [](const auto& t) {
    return t.first.starts_with("context") || t.first.starts_with("merge") || t.first.starts_with("head");
  });
  const std::vector<WeightsSource> sources{{"default", trunk}};
  return start_weights(make_network("mobilenetv2-s16-fpn2", 8), sources, 1).file;
}

TrainOptions toy_options() {
  return {.steps = 8,
          .warmup_steps = 2,
          .decay_from_step = 6,
          .learning_rate = 3e-3,
          .freeze_norm_from_step = 6,
          .batch = 2,
          .crop_px = 64,
          .threads = 1};
}

Trainer toy_trainer() {
  return {fresh_weights(), "default", default_metadata(), toy_options()};
}

TEST(Trainer, a_few_steps_lower_the_loss) {
  TrainOptions options = toy_options();
  options.steps = 20, options.decay_from_step = 20;
  options.freeze_norm_from_step = 100;  // the running statistics of a new decoder need longer than this
  Trainer trainer(fresh_weights(), "default", default_metadata(), options);
  const std::vector<TrainingScene> scenes{toy_scene()};
  const double first = trainer.advance(scenes);
  double last = 0.0;
  while (trainer.step() < 20) last = trainer.advance(scenes);
  EXPECT_GT(first, 1.5) << "eight classes, untrained decoder";
  EXPECT_LT(last, 0.7 * first);
}

TEST(Trainer, jaccard_weight_adds_to_the_loss_and_changes_the_step) {
  const std::vector<TrainingScene> scenes{toy_scene()};
  const auto run = [&](double weight) {
    TrainOptions options = toy_options();
    options.jaccard_weight = weight;
    Trainer trainer(fresh_weights(), "default", default_metadata(), options);
    const double loss = trainer.advance(scenes);
    static_cast<void>(trainer.advance(scenes));
    return std::pair(loss, trainer.model_file().tensors.at("head/kernel").values);
  };
  const auto [without, weights_without] = run(0.0);
  const auto [half, weights_half] = run(0.5);
  const auto [full, weights_full] = run(1.0);
  // Eight classes of equal probability, two of them in the scene: an IoU of an eighth and less.
  EXPECT_GT(full - without, 0.7);
  EXPECT_LT(full - without, 1.0);
  EXPECT_NEAR(half - without, 0.5 * (full - without), 1e-6);
  EXPECT_NE(weights_full, weights_without);
}

TEST(Trainer, resumed_run_gives_the_same_weights) {
  const std::vector<TrainingScene> scenes{toy_scene()};
  Trainer straight = toy_trainer();
  for (int i = 0; i < 6; ++i) static_cast<void>(straight.advance(scenes));
  Trainer killed = toy_trainer();
  for (int i = 0; i < 3; ++i) static_cast<void>(killed.advance(scenes));
  const std::string saved = format_safetensors(killed.checkpoint());
  Trainer resumed = toy_trainer();
  resumed.restore(parse_safetensors(saved, "checkpoint"), "checkpoint");
  EXPECT_EQ(resumed.step(), 3);
  for (int i = 0; i < 3; ++i) static_cast<void>(resumed.advance(scenes));
  EXPECT_EQ(format_safetensors(resumed.checkpoint()), format_safetensors(straight.checkpoint()));
}

TEST(Trainer, its_model_file_loads_and_a_model_is_no_checkpoint) {
  Trainer trainer = toy_trainer();
  const std::string bytes = format_safetensors(trainer.model_file());
  EXPECT_LT(bytes.size(), 4u << 20);
  EXPECT_EQ(load_model(bytes, "m").classes.name, "orthodrive-8");
  EXPECT_THROW(trainer.restore(parse_safetensors(bytes, "m"), "m"), InputError);
}

TEST(Trainer, learning_rate_rises_stays_and_falls) {
  Trainer trainer = toy_trainer();
  EXPECT_NEAR(trainer.learning_rate(), 1.5e-3, 1e-12);
  const std::vector<TrainingScene> scenes{toy_scene()};
  std::vector<double> rates;
  while (trainer.step() < 8) {
    rates.push_back(trainer.learning_rate());
    static_cast<void>(trainer.advance(scenes));
  }
  EXPECT_NEAR(rates[1], 3e-3, 1e-12);
  EXPECT_NEAR(rates[5], 3e-3, 1e-12);
  EXPECT_NEAR(rates[7], 1.5e-3, 1e-12);
  EXPECT_NEAR(trainer.learning_rate(), 0.0, 1e-12);
}

TEST(Trainer, refuses_impossible_options) {
  TrainOptions odd = toy_options();
  odd.crop_px = 100;
  EXPECT_THROW(Trainer(fresh_weights(), "default", default_metadata(), odd), OptionError);
  TrainOptions weights = toy_options();
  weights.class_weights = {1.0F, 1.0F};
  EXPECT_THROW(Trainer(fresh_weights(), "default", default_metadata(), weights), OptionError);
}

TEST(DrawCrop, repeats_for_a_seed_and_keeps_labels_with_their_pixels) {
  TrainingScene scene = toy_scene();
  const Crop a = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, 7),
             b = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, 7);
  EXPECT_EQ(a.rgb.data, b.rgb.data);
  EXPECT_EQ(a.allowed.data, b.allowed.data);
  EXPECT_NE(a.rgb.data, draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, 8).rgb.data);
  // Wherever the crop was taken, bright pixels are the square: compare in the middle of the two colours.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Crop crop = draw_crop(scene, {.size_px = 64, .gsd_m = 0.5}, seed);
    double bright = 0.0, dark = 0.0, bright_count = 0.0, dark_count = 0.0;
    for (std::size_t i = 0; i < crop.allowed.data.size(); ++i) {
      if (crop.allowed.data[i] == only(1)) bright += crop.rgb.data[3 * i], bright_count += 1.0;
      if (crop.allowed.data[i] == only(0)) dark += crop.rgb.data[3 * i], dark_count += 1.0;
    }
    if (bright_count < 50.0 || dark_count < 50.0) continue;
    EXPECT_GT(bright / bright_count, dark / dark_count + 60.0) << seed;
  }
}

TEST(DrawScene, follows_weights_and_first_steps) {
  std::vector<TrainingScene> scenes(3, TrainingScene{});
  scenes[0].weight = 3.0, scenes[1].weight = 1.0, scenes[2].weight = 100.0, scenes[2].from_step = 50;
  int counts[3] = {0, 0, 0};
  for (std::uint64_t seed = 0; seed < 4000; ++seed) ++counts[draw_scene(scenes, 49, seed)];
  EXPECT_EQ(counts[2], 0);
  EXPECT_NEAR(counts[0], 3000, 120);
  int late = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) late += draw_scene(scenes, 50, seed) == 2 ? 1 : 0;
  EXPECT_GT(late, 85);
  EXPECT_THROW(static_cast<void>(draw_scene({}, 0, 1)), OptionError);
}

}  // namespace
}  // namespace orthodrive

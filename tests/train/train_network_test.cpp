// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/train_network.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "nets/shipped_model.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/net_surgery.hpp"
#include "orthodrive/segment/resample_photo.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"
#include "train/toy_scene.hpp"

namespace orthodrive {
namespace {

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

Trainer toy_trainer() { return {fresh_weights(), "default", default_metadata(), toy_options()}; }

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

/// What reads the map learns; all else, running statistics too, stays as it was.
TEST(Trainer, map_only_leaves_the_rest_as_it_is) {
  ModelMetadata metadata = default_metadata();
  metadata.architecture += "-map";
  const std::vector<WeightsSource> sources{{"fresh", fresh_weights()}};
  const TensorFile start = start_weights(make_network(metadata.architecture, 8), sources, 1).file;
  TrainOptions options = toy_options();
  options.steps = 40, options.decay_from_step = 40, options.freeze_norm_from_step = 100;
  options.map_only = true;
  options.kept_crf = reference_crf(8);
  Trainer trainer(start, "fresh", metadata, options);
  const std::vector<TrainingScene> scenes{toy_scene()};
  double first = 0.0, last = 0.0;
  for (int i = 0; i < 40; ++i) (i < 10 ? first : last) += trainer.advance(scenes) * (i < 10 || i >= 30 ? 1.0 : 0.0);
  EXPECT_LT(last, first - 1.0);  // of ten steps each
  const TensorFile end = trainer.weights();
  int changed = 0;
  for (const auto& [name, tensor] : start.tensors) {
    const bool of_map = name.starts_with("map_") || name.starts_with("align_") || name.starts_with("classes_");
    const bool same = end.tensors.at(name).values == tensor.values;
    if (!of_map) EXPECT_TRUE(same) << name;
    changed += of_map && !same;
  }
  EXPECT_GT(changed, 30);
  EXPECT_TRUE(read_crf(trainer.model_file(), 8, "model"));
  options.map_only = false;
  Trainer classes(start, "fresh", metadata, options);
  static_cast<void>(classes.advance(scenes));
  EXPECT_EQ(classes.weights().tensors.at("align_out/kernel").values, start.tensors.at("align_out/kernel").values);
  EXPECT_NE(classes.weights().tensors.at("head/kernel").values, start.tensors.at("head/kernel").values);
}

/// As the reference trains it (sec. 2.4): the network's learning rate is 0 and the CRF learns all the same.
TEST(Trainer, crf_learns_on_a_frozen_network) {
  TrainOptions options = toy_options();
  options.learning_rate = 0.0, options.freeze_norm_from_step = 0, options.warmup_steps = 1;
  options.crf = CrfTraining{reference_crf(8), 0.1, 0.0};
  Trainer trainer(fresh_weights(), "fresh", default_metadata(), options);
  const std::vector<TrainingScene> scenes{toy_scene()};
  for (int i = 0; i < 3; ++i) static_cast<void>(trainer.advance(scenes));
  const TensorFile start = fresh_weights(), end = trainer.weights();
  for (const auto& [name, tensor] : start.tensors) EXPECT_TRUE(end.tensors.at(name).values == tensor.values) << name;
  const std::optional<CrfModel> learned = read_crf(trainer.model_file(), 8, "model");
  ASSERT_TRUE(learned);
  for (std::size_t c = 0; c < 8; ++c) {
    const double ratio = learned->parameters.appearance_weight[c] / options.crf->start.parameters.appearance_weight[c];
    EXPECT_TRUE(std::isfinite(ratio) && std::abs(std::log(ratio)) < 0.4) << "at most a tenth a step: " << ratio;
  }
  EXPECT_NE(learned->parameters.appearance_weight, options.crf->start.parameters.appearance_weight);
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

TEST(Trainer, model_is_the_mean_of_the_last_weights_also_when_resumed) {
  const std::vector<TrainingScene> scenes{toy_scene()};
  TrainOptions options = toy_options();
  Trainer plain(fresh_weights(), "default", default_metadata(), options);
  options.average_from_step = 2;
  const auto averaging = [&] { return Trainer(fresh_weights(), "default", default_metadata(), options); };
  Trainer averaged = averaging();
  std::vector<TensorFile> weights;  // after each step
  for (int i = 0; i < 5; ++i) {
    static_cast<void>(plain.advance(scenes));
    weights.push_back(plain.weights());
    if (averaged.step() == 4) {  // killed in the middle of the mean
      const std::string saved = format_safetensors(averaged.checkpoint());
      averaged = averaging();
      averaged.restore(parse_safetensors(saved, "checkpoint"), "checkpoint");
    }
    static_cast<void>(averaged.advance(scenes));
    if (i == 1) EXPECT_EQ(format_safetensors(averaged.model_file()), format_safetensors(plain.model_file()));
  }
  for (const auto& [name, mean] : averaged.weights().tensors) {
    for (std::size_t i = 0; i < mean.values.size(); i += 7) {
      const double sum = static_cast<double>(weights[2].tensors.at(name).values[i]) +
                         weights[3].tensors.at(name).values[i] + weights[4].tensors.at(name).values[i];
      ASSERT_NEAR(mean.values[i], sum / 3.0, 1e-6 * (1.0 + std::abs(sum))) << name;
    }
  }
  EXPECT_NE(averaged.weights().tensors.at("head/kernel").values, weights[4].tensors.at("head/kernel").values);
}

TEST(Trainer, its_model_file_loads_and_a_model_is_no_checkpoint) {
  Trainer trainer = toy_trainer();
  const std::string bytes = format_safetensors(trainer.model_file());
  EXPECT_LT(bytes.size(), 4u << 20);
  EXPECT_EQ(load_model(parse_safetensors(bytes, "m"), "m").classes.name, "orthodrive-8");
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

TEST(MeasureModel, labels_a_photo_as_prediction_does) {
  // Half a metre of the model, photo of 0.1 m: labels of 0.2 m. What the model says, taken for the truth, is all right.
  const int size = 400;
  ValidationScene scene{
      "fine",
      {{}, {0.0, 40.0, 0.1, size, size}, Raster<std::uint8_t>(size, size, 3), Raster<std::uint8_t>(size, size, 1, 1)},
      Raster<ClassSet>(size, size)};
  Random random(5);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col)
      for (int c = 0; c < 3; ++c)
        scene.photo.rgb.at(col, row, c) = static_cast<std::uint8_t>((col / 80 + row / 100) % 2 * 90 + random.below(60));
  const LabelMap labels = segment_mosaic(scene.photo, shipped_model(), {.crf = shipped_model().crf}).labels;
  ASSERT_EQ(labels.frame.gsd_m, 0.2);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col) scene.allowed.at(col, row) = only(labels.labels.at(col / 2, row / 2));
  const HeldOutScore score = measure_model(shipped_model(), {scene}, 1).at("fine");
  EXPECT_DOUBLE_EQ(score.labels.pixel_accuracy(), 1.0);
  EXPECT_EQ(score.is_road, score.said_road);
  EXPECT_LE(score.stated_road, static_cast<double>(score.said_road));
}

TEST(MeasureModel, measures_a_model_that_sees_the_map_with_one_and_without) {
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2-map", 8);
  TensorFile file = start_weights(graph, {}, 3).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)
    if (name.starts_with("head") || name.starts_with("classes_out"))
      for (float& v : tensor.values) v = static_cast<float>(random.normal());
  file.metadata = format_model_metadata({graph.architecture, default_class_table(), 0.5, 0.5});
  const SegmentModel model = load_model(file, "random");
  const TrainingScene toy = toy_scene();
  ValidationScene scene{"toy",
                        {{}, {0.0, 48.0, 0.5, 96, 96}, toy.rgb, Raster<std::uint8_t>(96, 96, 1, 1)},
                        Raster<ClassSet>(96, 96, 1, only(0))};
  for (int row = 40; row < 56; ++row)
    for (int col = 0; col < 96; ++col) scene.allowed.at(col, row) = road_classes(model.classes);
  const auto drawn = measure_model(model, {scene}, 1);
  ASSERT_EQ(drawn.size(), 2U);
  EXPECT_NE(drawn.at("toy with map").labels.pixel_accuracy(), drawn.at("toy").labels.pixel_accuracy());
  scene.map = std::vector<RoadLine>{};
  const auto empty = measure_model(model, {scene}, 1);
  EXPECT_EQ(empty.at("toy with map").labels.pixel_accuracy(), drawn.at("toy").labels.pixel_accuracy());
}

TEST(MeasureModel, takes_several_classes_of_roads_together) {
  ClassTable classes = default_class_table();
  classes.classes[5].role = Role::road;  // grass, say
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 8);
  TensorFile file = start_weights(graph, {}, 3).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)
    if (name.starts_with("head") || name.starts_with("classes_out"))
      for (float& v : tensor.values) v = static_cast<float>(random.normal());
  file.metadata = format_model_metadata({graph.architecture, classes, 0.5, 0.5});
  const SegmentModel model = load_model(file, "random");
  EXPECT_EQ(road_classes(classes), only(1) | only(5));
  ValidationScene scene{"toy",
                        {{}, {0.0, 48.0, 0.5, 96, 96}, toy_scene().rgb, Raster<std::uint8_t>(96, 96, 1, 1)},
                        Raster<ClassSet>(96, 96, 1, only(0))};
  for (std::size_t i = 0; i < scene.allowed.data.size(); ++i)  // nothing known, not road, one of them, either, or not
    scene.allowed.data[i] =
        std::array{unknown_class, only(0) | only(3), only(1), only(5), only(1) | only(5), only(1) | only(2)}[i % 6];
  const SegmentResult result = segment_mosaic(scene.photo, model, {.threads = 1});
  int both = 0, any = 0;
  for (std::size_t i = 0; i < scene.allowed.data.size(); ++i) {
    const bool said = result.labels.labels.data[i] == 1 || result.labels.labels.data[i] == 5;
    const bool is = i % 6 >= 2 && i % 6 <= 4;
    if (i % 6 == 0 || i % 6 == 5) continue;
    both += said && is ? 1 : 0, any += said || is ? 1 : 0;
  }
  ASSERT_GT(both, 0);
  ASSERT_LT(both, any);
  EXPECT_DOUBLE_EQ(measure_model(model, {scene}, 1).at("toy").roads.iou(1), static_cast<double>(both) / any);
}

TEST(Trainer, refuses_impossible_options) {
  TrainOptions odd = toy_options();
  odd.crop_px = 100;
  EXPECT_THROW(Trainer(fresh_weights(), "default", default_metadata(), odd), OptionError);
  TrainOptions weights = toy_options();
  weights.class_weights = {1.0F, 1.0F};
  EXPECT_THROW(Trainer(fresh_weights(), "default", default_metadata(), weights), OptionError);
}

}  // namespace
}  // namespace orthodrive

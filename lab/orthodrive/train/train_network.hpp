// SPDX-License-Identifier: Apache-2.0
#pragma once
// Training: AdamW on random crops with weak labels.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/rasters/tensor_file.hpp"
#include "orthodrive/nets/model_metadata.hpp"
#include "orthodrive/segment/segment_model.hpp"
#include "orthodrive/train/disturbed_map.hpp"
#include "orthodrive/train/search_crf.hpp"
#include "orthodrive/train/train_options.hpp"
#include "orthodrive/train/training_scene.hpp"

namespace orthodrive {

struct ValidationScene {
  std::string name;
  Photo photo;
  Raster<ClassSet> allowed;                  ///< on the photo's grid
  std::optional<std::vector<RoadLine>> map;  ///< in the photo's pixels; none: drawn from `allowed` (disturbed_map.hpp)
};

/// One row of the log.
struct TrainReport {
  std::int64_t step = 0;
  double learning_rate = 0.0, loss = 0.0;
  double seconds = 0.0;                                      ///< since this process began training
  std::optional<double> road_iou, mean_iou, pixel_accuracy;  ///< where validated
  std::string validation;                                    ///< name of the validation set, or "mean" of all
  std::string stage;                                         ///< architecture in training
};

/// The best validation so far.
struct BestScore {
  std::int64_t step = -1;
  double mean_iou = -1.0;  ///< mean over the validation sets
  int validations_since = 0;
};

/// The network in training and the optimizer's state.
class Trainer {
 public:
  /// `start`: weights of all layers (net_surgery.hpp); `source` names them in messages. metadata.architecture names the
  /// network. Throws OptionError for options that do not fit it.
  Trainer(const TensorFile& start, const std::string& source, const ModelMetadata& metadata, TrainOptions options);
  ~Trainer();
  Trainer(Trainer&&) noexcept;
  Trainer& operator=(Trainer&&) noexcept;

  [[nodiscard]] std::int64_t step() const;
  /// Before the first step, where starting weights are random: gives features unit size over the first batch
  /// (scale_start.hpp).
  void scale_start(const std::vector<TrainingScene>& scenes);
  /// One step; returns its loss. Throws Error when the loss is no number; the weights are then as before the step.
  double advance(const std::vector<TrainingScene>& scenes);
  /// Everything needed to go on, F32. Throws Error when a weight is no number or beyond half precision.
  [[nodiscard]] TensorFile checkpoint() const;
  /// Throws InputError when it is of another network or incomplete; nothing has changed then.
  void restore(const TensorFile& checkpoint, const std::string& source);
  /// The model file: kernels F16, with metadata; the mean of the weights where it has begun. Throws as checkpoint().
  [[nodiscard]] TensorFile model_file() const;
  [[nodiscard]] TensorFile weights() const;    ///< F32, to start another network from; the mean as in model_file()
  [[nodiscard]] double learning_rate() const;  ///< at the present step
  [[nodiscard]] const ModelMetadata& metadata() const;
  [[nodiscard]] std::optional<CrfModel> crf() const;  ///< as learned so far
  /// Crops as training draws them, with -log p of the network as it predicts.
  [[nodiscard]] std::vector<CrfSample> crf_samples(const std::vector<TrainingScene>& scenes, int count) const;
  BestScore best;  ///< kept in checkpoints

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Median frequency balancing over pixels with one known class, between 1/8 and 8; scenes count by their weight.
[[nodiscard]] std::vector<float> balanced_class_weights(const std::vector<TrainingScene>& scenes, std::size_t classes);

/// What a model says of held-out data.
struct HeldOutScore {
  explicit HeldOutScore(int class_count) : labels(class_count) {}
  LabelScore labels;
  LabelScore roads{2};  ///< 1: classes with role road taken together
  /// Of the pixels labelled road of which it is known whether they are: how many, how many of them are, and the sum of
  /// the road probabilities stated there. A calibrated model states in the mean the share that is right.
  std::int64_t said_road = 0, is_road = 0;
  double stated_road = 0.0;
};
/// Scores by name; scenes of one name count together. A photo is labelled as prediction does: one finer than the
/// model's scale gets finer labels. A model that sees a map is measured without one and, as "NAME with map", with the
/// scene's.
[[nodiscard]] std::map<std::string, HeldOutScore> measure_model(const SegmentModel& model,
                                                                const std::vector<ValidationScene>& scenes,
                                                                int threads = 0);
/// Those with role road. Throws OptionError when there is none.
[[nodiscard]] ClassSet road_classes(const ClassTable& classes);
/// Classes of what a map may show.
[[nodiscard]] MapClasses map_classes(const ClassTable& classes);

struct TrainHooks {
  std::function<void(const TrainReport&)> report;  ///< every 10 steps and after each validation
  std::function<void(const Trainer&)> checkpoint;  ///< after each validation round and at the end
  std::function<void(const Trainer&)> best;        ///< after a validation with the best mean IoU so far
};

/// Trains until options.steps or the early stop, validating on the way.
void train_network(Trainer& trainer, const TrainOptions& options, const std::vector<TrainingScene>& scenes,
                   const std::vector<ValidationScene>& validation, const TrainHooks& hooks, Monitor* monitor = nullptr);

}  // namespace orthodrive

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
#include "orthodrive/model/rasters.hpp"
#include "orthodrive/segment/model_metadata.hpp"
#include "orthodrive/segment/safetensors.hpp"
#include "orthodrive/segment/segment_model.hpp"
#include "orthodrive/segment/training_scene.hpp"

namespace orthodrive {

/// The learning rate rises linearly over `warmup_steps`, stays, and falls as a half cosine to 0 from `decay_from_step`
/// to `steps`. So a run can be prolonged before its decay begins without changing what it has done so far.
struct TrainOptions {
  std::int64_t steps = 2000, warmup_steps = 100, decay_from_step = 1500;
  double learning_rate = 1e-3;
  double trunk_rate_factor = 0.5;             ///< the ImageNet weights move slower
  double weight_decay = 1e-4;                 ///< decoupled (Loshchilov and Hutter, 2019), kernels only
  std::int64_t freeze_norm_from_step = 1500;  ///< from here batch norm uses its running statistics, as prediction does
  int batch = 4, crop_px = 384;
  std::vector<float> class_weights = std::vector<float>(8, 1.0F);
  float set_weight = 1.0F;  ///< of pixels with several allowed classes
  std::uint64_t seed = 1;
  std::int64_t validate_every = 200;  ///< steps; 0 = only at the end
  int threads = 0;                    ///< results repeat for the same number only: sums run in parallel
};

struct ValidationScene {
  std::string name;
  Photo photo;
  Raster<ClassSet> allowed;  ///< on the photo's grid, which has the model's scale
};

/// One row of the log.
struct TrainReport {
  std::int64_t step = 0;
  double learning_rate = 0.0, loss = 0.0;
  double seconds = 0.0;                                      ///< since this process began training
  std::optional<double> road_iou, mean_iou, pixel_accuracy;  ///< where validated
  std::string validation;
};

/// The network in training and the optimizer's state.
class Trainer {
 public:
  /// `trunk`: ImageNet weights by their Keras names; `source` names the file in messages.
  Trainer(const TensorFile& trunk, const std::string& source, const ModelMetadata& metadata, TrainOptions options);
  ~Trainer();
  Trainer(Trainer&&) noexcept;
  Trainer& operator=(Trainer&&) noexcept;

  [[nodiscard]] std::int64_t step() const;
  /// One step; returns its loss.
  double advance(const std::vector<TrainingScene>& scenes);
  /// Everything needed to go on, F32.
  [[nodiscard]] TensorFile checkpoint() const;
  void restore(const TensorFile& checkpoint, const std::string& source);
  /// The model file: kernels F16, with metadata.
  [[nodiscard]] TensorFile model_file() const;
  [[nodiscard]] double learning_rate() const;  ///< at the present step

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Scores by name; scenes of one name count together. The scenes must have the model's scale.
[[nodiscard]] std::map<std::string, LabelScore> measure_model(const SegmentModel& model,
                                                              const std::vector<ValidationScene>& scenes,
                                                              int threads = 0);
/// Label of the class with role road. Throws OptionError when there is none.
[[nodiscard]] int road_label(const ClassTable& classes);

struct TrainHooks {
  std::function<void(const TrainReport&)> report;  ///< every 10 steps and after each validation
  std::function<void(const Trainer&)> checkpoint;  ///< after each validation round and at the end
};

/// Trains until options.steps, validating on the way.
void train_network(Trainer& trainer, const TrainOptions& options, const std::vector<TrainingScene>& scenes,
                   const std::vector<ValidationScene>& validation, const TrainHooks& hooks, Monitor* monitor = nullptr);

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a network is trained. Descriptions of trainings are read where there is no libtorch: nothing here needs it.

#include <cstdint>
#include <optional>
#include <vector>

#include "orthodrive/crf/crf_model.hpp"
#include "orthodrive/train/training_scene.hpp"

namespace orthodrive {

enum class Solver {
  adamw,  ///< Loshchilov and Hutter, 2019, on the weighted mean of the loss
  sgd     ///< with momentum, Caffe's update rule
};

/// Learning the CRF's weights together with the network's. Weights are learned as logarithms of their ratio to the
/// start and the compatibility as difference to it, so that one rate fits values of any size; both are drawn back to
/// the start.
struct CrfTraining {
  CrfModel start;
  double learning_rate = 0.02;  ///< relative change a step, at the peak of the schedule
  double shrinkage = 0.05;      ///< decoupled decay towards the start, times the rate a step
  bool unary = false;           ///< the unary compatibility (thesis eq. 2.19) is learned, too
};

/// The learning rate rises linearly over `warmup_steps`, stays, and falls as a half cosine to 0 from `decay_from_step`
/// to `steps`. So a run can be prolonged before its decay begins without changing what it has done so far.
struct TrainOptions {
  std::int64_t steps = 2000, warmup_steps = 100, decay_from_step = 1500;
  Solver solver = Solver::adamw;
  double learning_rate = 1e-3;
  double momentum = 0.9;                      ///< sgd only
  double trunk_rate_factor = 0.5;             ///< layers that ImageNet weights exist for move slower
  double weight_decay = 1e-4;                 ///< decoupled from the rate's adaption in adamw; kernels only
  bool sum_loss = false;                      ///< the reference's unnormalised loss, summed over pixels
  std::int64_t freeze_norm_from_step = 1500;  ///< from here batch norm uses its running statistics, as prediction does
  std::int64_t average_from_step = -1;        ///< the model is the mean of the weights from here on; -1: the last ones
  int batch = 4;
  int crop_px = 384;  ///< edge of what the network sees
  int label_px = 0;   ///< edge of the centre that is learned from; 0: all of the crop that gets scores
  Augmentation augmentation;
  std::vector<float> class_weights;  ///< empty: all 1
  bool balance_classes = false;      ///< class_weights by median frequency instead (Eigen and Fergus, 2015)
  float set_weight = 1.0F;           ///< of pixels with several allowed classes
  double jaccard_weight = 0.0;       ///< of jaccard_loss beside allowed_class_loss; network only
  bool map_only = false;             ///< of a network that sees a map learns what reads it alone, on maps of
                                     ///< disturbed_map.hpp: alignments, and what the map adds to the classes
  std::optional<CrfModel> kept_crf;  ///< with it: the CRF of the weights it starts from, which still fits
  std::uint64_t seed = 1;
  std::int64_t validate_every = 200;  ///< steps; 0 = only at the end, -1 = never
  int early_stop_after = 0;           ///< validations without a better mean IoU; 0 = never
  int threads = 0;                    ///< results repeat for the same number only: sums run in parallel
  std::optional<CrfTraining> crf;     ///< learn a CRF on top, end to end
  bool cuda = false;                  ///< train on the GPU; throws OptionError where libtorch has none
};

/// Solver and learning rates of the reference: SGD, batch 1, rate 1e-10 on a summed loss, momentum 0.99, weight decay
/// 5e-4, tiles of 256 px within 450 px, mirrored and turned by quarters.
[[nodiscard]] TrainOptions reference_train_options();

}  // namespace orthodrive

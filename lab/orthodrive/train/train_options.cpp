// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/train_options.hpp"

namespace orthodrive {

TrainOptions reference_train_options() {
  return {.steps = 50000,
          .warmup_steps = 0,
          .decay_from_step = 50000,
          .solver = Solver::sgd,
          .learning_rate = 1e-10,
          .momentum = 0.99,
          .trunk_rate_factor = 1.0,
          .weight_decay = 5e-4,
          .sum_loss = true,
          .batch = 1,
          .crop_px = 450,
          .label_px = 256,
          .augmentation =
              {.turn = Augmentation::Turn::quarters, .zoom = false, .colors = false, .blur = false, .noise = false},
          .validate_every = 1000};
}

}  // namespace orthodrive

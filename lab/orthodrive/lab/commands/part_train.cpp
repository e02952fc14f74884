// SPDX-License-Identifier: Apache-2.0
// What the part "train" gives out.

#include "orthodrive/lab/training/parts.hpp"
#include "orthodrive/pipeline/stages/adapt_part.hpp"
#include "orthodrive/train/adapt_model.hpp"

extern "C" const orthodrive::TrainPart* orthodrive_part_train() {
  static constexpr orthodrive::TrainPart functions{
      .prepare_training_folder = orthodrive::prepare_training_folder,
      .run_training = orthodrive::run_training,
      .measure_model = orthodrive::measure_model,
      .map_classes = orthodrive::map_classes,
  };
  return &functions;
}

extern "C" const orthodrive::AdaptPart* orthodrive_part_adapt() {
  static constexpr orthodrive::AdaptPart functions{
      .require_adaptable = orthodrive::require_adaptable,
      .adapt_model = orthodrive::adapt_model,
  };
  return &functions;
}

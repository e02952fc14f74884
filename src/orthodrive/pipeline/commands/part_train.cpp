// SPDX-License-Identifier: Apache-2.0
// What the part "train" gives out.

#include "orthodrive/pipeline/training/parts.hpp"

extern "C" const orthodrive::TrainPart* orthodrive_part_train() {
  static constexpr orthodrive::TrainPart functions{
      .prepare_training_folder = orthodrive::prepare_training_folder,
      .run_training = orthodrive::run_training,
      .measure_model = orthodrive::measure_model,
      .map_classes = orthodrive::map_classes,
      .require_adaptable = orthodrive::require_adaptable,
      .adapt_model = orthodrive::adapt_model,
  };
  return &functions;
}

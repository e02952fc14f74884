// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads what an experiment trains on.

#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/lab/training/experiment.hpp"
#include "orthodrive/train/train_network.hpp"

namespace orthodrive {

struct TrainingData {
  std::vector<TrainingScene> scenes;
  std::vector<ValidationScene> validation;
};

/// Photos are brought to `gsd_m`, labels to the class table.
[[nodiscard]] TrainingData read_training_data(const Experiment& experiment, double gsd_m, const ClassTable& classes,
                                              int threads, Monitor* monitor);
/// Only what is held out.
[[nodiscard]] std::vector<ValidationScene> read_held_out_data(const Experiment& experiment, double gsd_m,
                                                              const ClassTable& classes, int threads, Monitor* monitor);

/// Of the pixels of which the class is known, by class (thesis table A.5); 0 everywhere where there are none.
struct ClassShares {
  std::vector<double> training, held_out;
};
[[nodiscard]] ClassShares class_shares(const TrainingData& data, std::size_t classes);

/// The scene with its labels laid over: the mean colour of the allowed classes, the photo where nothing is known.
[[nodiscard]] Raster<std::uint8_t> label_preview(const Raster<std::uint8_t>& rgb, const Raster<ClassSet>& allowed,
                                                 const ClassTable& classes);

}  // namespace orthodrive

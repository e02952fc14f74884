// SPDX-License-Identifier: Apache-2.0
#pragma once
// A training from its data to its files, for both programs that train: `orthodrive train` and `orthodrive-train`. The
// latter is built without GDAL and PROJ (tools/trainer), so nothing that needs them may be included here.
//
// Files in the folder: experiment.toml, weights_<architecture>.txt (where the starting weights came from), log.csv,
// training.html, checkpoint.safetensors, best.safetensors, model.safetensors. With `crf` in the sub-folder crf:
// search.csv, searched.safetensors and again the last five.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/lab/training/experiment.hpp"
#include "orthodrive/nets/net_surgery.hpp"
#include "orthodrive/pipeline/files/network_spec.hpp"
#include "orthodrive/train/train_network.hpp"

namespace orthodrive {

struct TrainingRun {
  std::filesystem::path out;
  std::string experiment_text;
  Experiment experiment;  ///< with the threads and the device of this run; its data sets are not looked at
  NetworkSpec network;
  ClassTable classes;
  std::vector<TrainingScene> scenes;
  std::vector<ValidationScene> validation;
  std::function<std::vector<WeightsSource>()> read_weights;  ///< asked when a training begins, not when it goes on
  bool resume = false;                                       ///< go on from the checkpoint in the folder
  bool crf = false;  ///< on top of the network trained in the folder: search a CRF, then learn both
};

/// Creates the folder. Throws OptionError when it holds a training that `resume` does not ask to go on with. To be
/// called before data are read, which takes long.
void prepare_training_folder(const std::filesystem::path& out, bool resume, bool crf);

/// All stages of the experiment, or the CRF.
void run_training(TrainingRun run, Monitor* monitor);

}  // namespace orthodrive

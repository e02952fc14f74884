// SPDX-License-Identifier: Apache-2.0
#pragma once
// `orthodrive train`: an experiment and the data it names -> a model; or its data packed, previewed, or measured on.

#include "orthodrive/pipeline/stages/stage_context.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"

namespace orthodrive {

struct TrainFiles {
  std::filesystem::path experiment;  ///< TOML
  std::filesystem::path folder;      ///< of the training (training_run.hpp) or its previews
  /// In place of what the experiment says, unless empty: weights to start from, data sets that are left out.
  std::vector<std::filesystem::path> weights;
  std::vector<std::string> leave_out;
};

struct RunTrainOptions {
  bool resume = false;  ///< go on from the checkpoint in the folder
  bool crf = false;     ///< on top of the network trained in the folder: search a CRF, then learn both
  bool cuda = false;
};

void run_train(const TrainFiles& files, const RunTrainOptions& options, StageContext& context);

/// Only pictures of the labels, to look at before training.
void preview_training(const TrainFiles& files, StageContext& context);

/// The data set and all that training needs to know as one safetensors file, for `orthodrive-train`, which has neither
/// GDAL nor protobuf: Caffe models become safetensors beside the pack.
void pack_training(const TrainFiles& files, const std::filesystem::path& pack, StageContext& context);

struct MeasureOptions {
  std::string model;              ///< name in a models folder, or a file
  std::vector<std::string> sets;  ///< held-out data to measure on; none: all
  bool crf = false;               ///< with the model's CRF, or the reference's
};
/// Scores of a model on the held-out data of an experiment and what they took, by data set.
[[nodiscard]] nlohmann::ordered_json measure_on_held_out_data(const TrainFiles& files, const MeasureOptions& options,
                                                              StageContext& context);

}  // namespace orthodrive

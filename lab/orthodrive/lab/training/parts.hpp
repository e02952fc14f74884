// SPDX-License-Identifier: Apache-2.0
#pragma once
// Functions that need libtorch or OpenCV. They lie in shared libraries of their own, which the first call loads; their
// table is what orthodrive_part_NAME() of part_NAME.cpp returns. What is linked into one program with them (the tests
// of their rooms, orthodrive-train, the part itself) calls them without a table.

#include "orthodrive/baselines/mrf_roads.hpp"
#include "orthodrive/baselines/road_forest.hpp"
#include "orthodrive/lab/training/training_run.hpp"
#include "orthodrive/train/train_network.hpp"

namespace orthodrive {

/// libtorch: all that trains a network; what adapts one is another table (pipeline/stages/adapt_part.hpp). Each member
/// is the function of its name.
struct TrainPart {
  decltype(&orthodrive::prepare_training_folder) prepare_training_folder;
  decltype(&orthodrive::run_training) run_training;
  decltype(&orthodrive::measure_model) measure_model;
  decltype(&orthodrive::map_classes) map_classes;
};

/// OpenCV: the random forests of the MRF baseline, and the baseline itself, which sees by them.
struct ForestsPart {
  decltype(&orthodrive::road_mask_of) road_mask_of;
  decltype(&orthodrive::road_mask) road_mask;
  decltype(&orthodrive::train_road_forests) train_road_forests;
  decltype(&orthodrive::save_road_forests) save_road_forests;
  decltype(&orthodrive::load_road_forests) load_road_forests;
  decltype(&orthodrive::mrf_photo_evidence) mrf_photo_evidence;
  decltype(&orthodrive::refine_roads_mrf) refine_roads_mrf;
};

/// Throw as load_part() does (core/load_part.hpp).
[[nodiscard]] const TrainPart& train_part();
[[nodiscard]] const ForestsPart& forests_part();

}  // namespace orthodrive

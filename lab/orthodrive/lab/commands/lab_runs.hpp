// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the command line calls of the laboratory. As pipeline/commands/runs.hpp: the program loads it from
// liborthodrive-lab.so when a command needs it (lab/app/load_lab.hpp).

#include "orthodrive/lab/commands/run_forests.hpp"
#include "orthodrive/lab/commands/run_synth.hpp"
#include "orthodrive/lab/commands/run_train.hpp"
#include "orthodrive/lab/commands/run_tune.hpp"
#include "orthodrive/lab/methods/other_methods.hpp"

namespace orthodrive {

/// Each member is the function of its name.
struct LabRuns {
  decltype(&orthodrive::run_synth) run_synth;
  decltype(&orthodrive::run_forests) run_forests;
  decltype(&orthodrive::run_refine_by) run_refine_by;
  decltype(&orthodrive::run_elevate_by) run_elevate_by;
  decltype(&orthodrive::run_tune) run_tune;

  decltype(&orthodrive::run_train) run_train;
  decltype(&orthodrive::preview_training) preview_training;
  decltype(&orthodrive::pack_training) pack_training;
  decltype(&orthodrive::measure_on_held_out_data) measure_on_held_out_data;
};

}  // namespace orthodrive

/// The one symbol that the program asks the library for.
extern "C" [[nodiscard]] const orthodrive::LabRuns* orthodrive_lab_runs();

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/commands/lab_runs.hpp"

const orthodrive::LabRuns* orthodrive_lab_runs() {
  static constexpr orthodrive::LabRuns runs{
      .run_synth = orthodrive::run_synth,
      .run_forests = orthodrive::run_forests,
      .run_refine_by = orthodrive::run_refine_by,
      .run_elevate_by = orthodrive::run_elevate_by,
      .run_tune = orthodrive::run_tune,
      .run_train = orthodrive::run_train,
      .preview_training = orthodrive::preview_training,
      .pack_training = orthodrive::pack_training,
      .measure_on_held_out_data = orthodrive::measure_on_held_out_data,
  };
  return &runs;
}

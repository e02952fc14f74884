// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/commands/runs.hpp"

const orthodrive::Runs* orthodrive_runs() {
  static constexpr orthodrive::Runs runs{
      .read_site = orthodrive::read_site,
      .build_site = orthodrive::build_site,
      .explain_build = orthodrive::explain_build,
      .size_of = orthodrive::size_of,
      .estimate_build = orthodrive::estimate_build,
      .measure_machine_speed = orthodrive::measure_machine_speed,
      .machine_of_costs = orthodrive::machine_of_costs,
      .work_on_site = orthodrive::work_on_site,
      .missing_stages = orthodrive::missing_stages,
      .run_new = orthodrive::run_new,
      .run_fetch = orthodrive::run_fetch,
      .fetch_what_lacks = orthodrive::fetch_what_lacks,
      .run_segment = orthodrive::run_segment,
      .run_refine = orthodrive::run_refine,
      .run_elevate = orthodrive::run_elevate,
      .run_network = orthodrive::run_network,
      .crg_format_of = orthodrive::crg_format_of,
      .run_scene = orthodrive::run_scene,
      .run_export = orthodrive::run_export,
      .run_drive = orthodrive::run_drive,
      .run_fmu = orthodrive::run_fmu,
      .score_labels = orthodrive::score_labels,
      .score_roads = orthodrive::score_roads,
      .score_network = orthodrive::score_network,
      .score_scene = orthodrive::score_scene,
      .score_heights = orthodrive::score_heights,
      .score_site = orthodrive::score_site,
      .to_table = orthodrive::to_table,
  };
  return &runs;
}

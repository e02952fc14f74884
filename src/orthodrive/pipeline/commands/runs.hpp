// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the command line calls. The program holds none of it: it loads liborthodrive.so, which gives out this table,
// when a command runs (app/load_runs.hpp). A program that links the rooms calls the functions themselves.

#include "orthodrive/pipeline/build/build_site.hpp"
#include "orthodrive/pipeline/build/machine_speed.hpp"
#include "orthodrive/pipeline/build/plan_build.hpp"
#include "orthodrive/pipeline/build/work_on_site.hpp"
#include "orthodrive/pipeline/commands/run_fmu.hpp"
#include "orthodrive/pipeline/score/score.hpp"
#include "orthodrive/pipeline/sources/run_fetch.hpp"
#include "orthodrive/pipeline/sources/run_new.hpp"
#include "orthodrive/pipeline/sources/site.hpp"
#include "orthodrive/pipeline/stages/crg_files.hpp"
#include "orthodrive/pipeline/stages/run_drive.hpp"
#include "orthodrive/pipeline/stages/run_elevate.hpp"
#include "orthodrive/pipeline/stages/run_network.hpp"
#include "orthodrive/pipeline/stages/run_refine.hpp"
#include "orthodrive/pipeline/stages/run_scene.hpp"
#include "orthodrive/pipeline/stages/run_segment.hpp"

namespace orthodrive {

/// Each member is the function of its name.
struct Runs {
  decltype(&orthodrive::read_site) read_site;
  decltype(&orthodrive::build_site) build_site;
  decltype(&orthodrive::explain_build) explain_build;
  decltype(&orthodrive::size_of) size_of;
  decltype(&orthodrive::estimate_build) estimate_build;
  decltype(&orthodrive::measure_machine_speed) measure_machine_speed;
  decltype(&orthodrive::machine_of_costs) machine_of_costs;
  decltype(&orthodrive::work_on_site) work_on_site;
  decltype(&orthodrive::missing_stages) missing_stages;

  decltype(&orthodrive::run_new) run_new;
  decltype(&orthodrive::run_fetch) run_fetch;
  decltype(&orthodrive::fetch_what_lacks) fetch_what_lacks;
  decltype(&orthodrive::run_segment) run_segment;
  decltype(&orthodrive::run_refine) run_refine;
  decltype(&orthodrive::run_elevate) run_elevate;
  decltype(&orthodrive::run_network) run_network;
  decltype(&orthodrive::crg_format_of) crg_format_of;
  decltype(&orthodrive::run_scene) run_scene;
  decltype(&orthodrive::run_export) run_export;
  decltype(&orthodrive::run_drive) run_drive;
  decltype(&orthodrive::run_fmu) run_fmu;

  ScoreJson (*score_labels)(const ScoreRequest&, const LabelScoreOptions&);
  ScoreJson (*score_roads)(const ScoreRequest&, const RoadScoreOptions&);
  ScoreJson (*score_network)(const ScoreRequest&, const NetworkScoreOptions&);
  ScoreJson (*score_scene)(const ScoreRequest&, const SceneScoreOptions&);
  ScoreJson (*score_heights)(const ScoreRequest&);
  ScoreJson (*score_site)(const ScoreRequest&);
  std::string (*to_table)(const ScoreJson&);
};

}  // namespace orthodrive

/// The one symbol that the program asks the library for.
extern "C" [[nodiscard]] const orthodrive::Runs* orthodrive_runs();

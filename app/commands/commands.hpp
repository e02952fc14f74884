// SPDX-License-Identifier: Apache-2.0
#pragma once
// One function a sub-command: it declares its options and what happens when it is called.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "load_runs.hpp"
#include "orthodrive/core/monitor.hpp"

namespace orthodrive::app {

/// What every command gets.
struct Context {
  Monitor* monitor = nullptr;  ///< bar and messages on stderr
  int threads = 0;             ///< --threads: 0 = all cores
  int exit_code = 0;
  std::function<void(const std::string& stage)> set_stage;  ///< tells the monitor which stage runs
  std::function<void(const char* text)> last_words;         ///< on stderr, whatever --quiet says
  /// Of liborthodrive.so, unless the laboratory has put its own here, which know more methods.
  std::function<StageOutcome(const RefineFiles&, const RunRefineOptions&, StageContext&)> run_refine =
      [](const auto& files, const auto& options, auto& stage) { return runs().run_refine(files, options, stage); };
  std::function<StageOutcome(const ElevateFiles&, const RunElevateOptions&, StageContext&)> run_elevate =
      [](const auto& files, const auto& options, auto& stage) { return runs().run_elevate(files, options, stage); };
};

void add_segment(CLI::App& app, Context& context);
void add_refine(CLI::App& app, Context& context);
void add_elevate(CLI::App& app, Context& context);
void add_network(CLI::App& app, Context& context);
void add_scene(CLI::App& app, Context& context);
void add_export(CLI::App& app, Context& context);
void add_drive(CLI::App& app, Context& context);
void add_fmu(CLI::App& app, Context& context);
void add_new(CLI::App& app, Context& context);
void add_fetch(CLI::App& app, Context& context);
void add_build(CLI::App& app, Context& context);
void add_plan(CLI::App& app, Context& context);
void add_cells(CLI::App& app, Context& context);
void add_view(CLI::App& app, Context& context);
void add_evaluate(CLI::App& app, Context& context);
void add_version(CLI::App& app, Context& context);
void add_help_files(CLI::App& app, Context& context);
/// The commands of the laboratory, and what it adds to those above: comes after them. Nothing in a build without it.
void add_laboratory(CLI::App& app, Context& context);

}  // namespace orthodrive::app

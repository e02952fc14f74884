// SPDX-License-Identifier: Apache-2.0
// orthodrive cells: a build that several processes share, on one machine or on a cluster.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "load_runs.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"

namespace orthodrive::app {
namespace {

struct CellsArguments {
  std::filesystem::path site, out;
  std::vector<std::string> overrides;
  BuildShare share;
};
using SharedArguments = std::shared_ptr<CellsArguments>;

CLI::App* add_sub(CLI::App& cmd, const SharedArguments& args, const char* name, const char* what) {
  CLI::App* sub = cmd.add_subcommand(name, what);
  sub->add_option("site", args->site, "site file (TOML), as for `orthodrive build`")->required();
  sub->add_option("-o,--output", args->out, "folder for the results, which all machines see")->required();
  sub->add_option("--set", args->overrides, "override of the site file, section.key=value; may be repeated");
  return sub;
}

void add_work(CLI::App& cmd, CLI::App& app, const SharedArguments& args, Context& context) {
  CLI::App* sub = add_sub(cmd, args, "work",
                          "Works on the build until it is complete, with all other processes that do so at that time.");
  sub->add_option("--index", args->share.index, "which of the processes, from 0: the index of a job in its array")
      ->required();
  sub->add_option("--of", args->share.of, "number of processes")->required()->check(CLI::PositiveNumber);
  sub->callback([args, &context, &app] {
    if (args->share.index >= args->share.of)
      throw OptionError(fmt::format("--index {}: there are {} processes, from 0 to {}", args->share.index,
                                    args->share.of, args->share.of - 1));
    const StopOnSignals stoppable({.last_words = [&context] { context.last_words(Stopped(0).what()); }});
    runs().work_on_site(runs().read_site(args->site, args->overrides), args->out, args->share,
                        {.threads = context.threads, .version = app.version(), .at_stage = context.set_stage},
                        context.monitor);
  });
}

void add_missing(CLI::App& cmd, const SharedArguments& args, Context& context) {
  CLI::App* sub = add_sub(cmd, args, "missing", "Prints the stages that a build would run; exit code 1 for any.");
  sub->callback([args, &context] {
    const std::vector<std::string> missing =
        runs().missing_stages(runs().read_site(args->site, args->overrides), args->out);
    if (missing.empty()) return;
    fmt::print("{}\n", fmt::join(missing, " "));
    context.exit_code = 1;
  });
}

}  // namespace

void add_cells(CLI::App& app, Context& context) {
  const auto args = std::make_shared<CellsArguments>();
  CLI::App* cmd = app.add_subcommand(
      "cells", "A build that several machines share: one process builds, the others make cells of its stages.");
  cmd->require_subcommand(1);
  add_work(*cmd, app, args, context);
  add_missing(*cmd, args, context);
  cmd->footer(
      "The result has the bytes of `orthodrive build`, whoever makes what, and however often. Any process may be lost: "
      "the others go on.\n"
      "Cells lie in OUT/.orthodrive/cells until their stage is put together. examples/cluster/slurm_build.sh does it "
      "all with Slurm.\n\n"
      "Examples:\n"
      "  orthodrive cells work site.toml -o out --index 0 --of 2      # on one machine\n"
      "  orthodrive cells work site.toml -o out --index 1 --of 2      # on another one, at the same time\n"
      "  orthodrive cells missing site.toml -o out || echo again");
}

}  // namespace orthodrive::app

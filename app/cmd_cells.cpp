// orthodrive cells: a build that several processes share, on one machine or on a cluster.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"
#include "orthodrive/pipeline/build_site.hpp"

namespace orthodrive::app {
namespace {

struct CellsArguments {
  std::filesystem::path site, out;
  std::vector<std::string> overrides;
  CellChunk chunk;
};
using SharedArguments = std::shared_ptr<CellsArguments>;

CLI::App* add_sub(CLI::App& cmd, const SharedArguments& args, const char* name, const char* what) {
  CLI::App* sub = cmd.add_subcommand(name, what);
  sub->add_option("site", args->site, "site file (TOML), as for `orthodrive build`")->required();
  sub->add_option("-o,--output", args->out, "folder for the results, which all machines see")->required();
  sub->add_option("--set", args->overrides, "override of the site file, section.key=value; may be repeated");
  return sub;
}

void add_run(CLI::App& cmd, const SharedArguments& args, Context& context) {
  CLI::App* sub = add_sub(cmd, args, "run", "Makes the missing cells of one chunk, of the stage that is next.");
  sub->add_option("--chunk", args->chunk.chunk, "which chunk, from 0: the index of a job in its array")->required();
  sub->add_option("--chunks", args->chunk.chunks, "number of chunks")->required()->check(CLI::PositiveNumber);
  sub->callback([args, &context] {
    if (args->chunk.chunk >= args->chunk.chunks)
      throw OptionError(fmt::format("--chunk {}: there are {} chunks, from 0 to {}", args->chunk.chunk,
                                    args->chunk.chunks, args->chunk.chunks - 1));
    const StopOnSignals stoppable({.last_words = [&context] { context.last_words(Stopped(0).what()); }});
    const Site site = read_site(args->site, args->overrides);
    const std::size_t made = make_cells(site, args->out, args->chunk, {.threads = context.threads}, context.monitor);
    fmt::print("{} cells made\n", made);
  });
}

void add_missing(CLI::App& cmd, const SharedArguments& args, Context& context) {
  CLI::App* sub = add_sub(cmd, args, "missing",
                          "Prints the stage that is next and its cells that nobody has made; exit code 1 while there "
                          "are any.");
  sub->callback([args, &context] {
    const auto cells = cells_to_make(read_site(args->site, args->overrides), args->out, {.threads = context.threads});
    if (!cells) return;
    fmt::print("{} {}\n", cells->stage, fmt::join(cells->missing, " "));
    context.exit_code = 1;
  });
}

void add_merge(CLI::App& cmd, CLI::App& app, const SharedArguments& args, Context& context) {
  CLI::App* sub = add_sub(cmd, args, "merge",
                          "Runs all stages up to the first of which cells are missing and says which, and how many; or "
                          "`done`.");
  sub->callback([args, &context, &app] {
    const StopOnSignals stoppable({.last_words = [&context] { context.last_words(Stopped(0).what()); }});
    const BuildResult result = build_site(
        read_site(args->site, args->overrides), args->out,
        {.threads = context.threads, .version = app.version(), .at_stage = context.set_stage, .leave_cells = true},
        context.monitor);
    if (result.waits_for)
      fmt::print("{}: {} of {} cells are missing\n", result.waits_for->stage, result.waits_for->missing.size(),
                 result.waits_for->all);
    else
      fmt::print("done\n");
  });
}

}  // namespace

void add_cells(CLI::App& app, Context& context) {
  const auto args = std::make_shared<CellsArguments>();
  CLI::App* cmd = app.add_subcommand(
      "cells",
      "A build that several machines share: they make cells of its slow stages, one process puts them together.");
  cmd->require_subcommand(1);
  add_run(*cmd, args, context);
  add_missing(*cmd, args, context);
  add_merge(*cmd, app, args, context);
  cmd->footer(
      "The result has the bytes of `orthodrive build`, whoever makes which cell, and however often. `run` needs no "
      "lock; cells\n"
      "lie in OUT/.orthodrive/cells until their stage is put together. examples/cluster/slurm_build.sh does it all "
      "with "
      "Slurm.\n\n"
      "Examples:\n"
      "  orthodrive cells merge site.toml -o out                         # prints \"segment: 36 of 36 cells are "
      "missing\"\n"
      "  orthodrive cells run site.toml -o out --chunk 0 --chunks 2      # on one machine\n"
      "  orthodrive cells run site.toml -o out --chunk 1 --chunks 2      # on another one\n"
      "  orthodrive cells missing site.toml -o out || echo again");
}

}  // namespace orthodrive::app

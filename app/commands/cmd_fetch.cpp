// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "idle_options.hpp"
#include "load_runs.hpp"
#include "orthodrive/core/stop.hpp"

namespace orthodrive::app {

void add_fetch(CLI::App& app, Context& context) {
  struct Arguments {
    std::filesystem::path site;
    std::vector<std::string> overrides;
    remote::FetchOptions options;
    IdleOptions idle;
  };
  auto args = std::make_shared<Arguments>();
  CLI::App* cmd =
      app.add_subcommand("fetch", "Fetches the sources that a site file names on servers into local files.");
  cmd->add_option("site", args->site, "site file (TOML) with [[fetch]] tables")->required();
  cmd->add_flag("--refresh", args->options.refresh, "ask for news of what is there (ETag, Last-Modified)");
  const CLI::Option* dry_run = cmd->add_flag("--dry-run", args->options.dry_run,
                                             "say how many tiles and about how many MB it is, fetch nothing");
  args->idle.excludes(cmd->add_option("--connections", args->options.http.connections, "to a server at once")
                          ->check(CLI::Range(1, 64))
                          ->capture_default_str(),
                      {dry_run});
  cmd->add_option("--attempts", args->options.http.attempts, "of a request that fails")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  cmd->add_option("--pause", args->options.http.first_pause_s,
                  "before the second attempt, s; doubles with each further one")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  cmd->add_option("--stall", args->options.http.stall_s, "seconds without a byte after which an attempt is given up")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  cmd->add_option("--set", args->overrides, "override of the site file, section.key=value; may be repeated");
  cmd->footer(
      "Reads the site file. Writes the files that its [[fetch]] tables name (MBTiles, GeoTIFF, OpenStreetMap), each "
      "with\n"
      "FILE.source.json: where it comes from, licence, attribution. A killed run goes on where it stopped. Keys of "
      "services\n"
      "stand in the url as {env:NAME} and are read from the environment. `build` fetches what is not there, too.\n\n"
      "Examples:\n"
      "  orthodrive fetch site.toml --dry-run\n"
      "  orthodrive fetch site.toml\n"
      "  orthodrive fetch site.toml --refresh --connections 2");
  cmd->callback([args, &context] {
    args->idle.refuse();
    const StopOnSignals stoppable({.last_words = [&context] { context.last_words(Stopped(0).what()); }});
    runs().run_fetch(runs().read_site(args->site, args->overrides), args->options, context.monitor);
  });
}

}  // namespace orthodrive::app

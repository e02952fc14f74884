// SPDX-License-Identifier: Apache-2.0
// The command line: parse, read, call, write. Exit codes: 0 done, 1 data or processing, 2 usage, 128 + n ended by
// signal n.

#include <mimalloc.h>

#include "commands/commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"
#include "terminal_monitor.hpp"

namespace orthodrive::app {
namespace {

void add_commands(CLI::App& app, Context& context) {
  add_new(app, context);
  add_build(app, context);
  add_plan(app, context);
  add_cells(app, context);
  add_fetch(app, context);
  add_segment(app, context);
  add_refine(app, context);
  add_elevate(app, context);
  add_network(app, context);
  add_scene(app, context);
  add_export(app, context);
  add_drive(app, context);
  add_fmu(app, context);
  add_view(app, context);
  add_evaluate(app, context);
  add_version(app, context);
  add_help_files(app, context);
  add_laboratory(app, context);
}

}  // namespace
}  // namespace orthodrive::app

int main(int argc, char** argv) {
  // Large rasters come and go, window by window: a page fault each 4 KiB of them took a sixth of `segment`.
  mi_option_enable(mi_option_large_os_pages);
  using namespace orthodrive::app;
  TerminalMonitor monitor;
  Context context{.monitor = &monitor,
                  .set_stage =
                      [&monitor](const std::string& stage) {
                        mi_collect(true);  // what the stage before has left goes back to the system
                        monitor.set_stage(stage);
                      },
                  .last_words = [&monitor](const char* text) { monitor.fail(text); }};
  CLI::App app{
      "Orthodrive turns orthophotos, OpenStreetMap roads and terrain models into drivable virtual environments."};
  app.set_version_flag("--version", ORTHODRIVE_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option("--threads", context.threads, "worker threads, 0 = all cores; the result does not depend on it")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_flag("-q,--quiet", monitor.quiet, "no messages and no progress bar on stderr");
  app.add_flag("--json", monitor.json,
               "log on stderr as JSON lines: time, level, stage, then message, or progress with rate_per_s and "
               "remaining_s");
  app.footer("Exit codes: 0 done, 1 data or processing, 2 usage, 128 + n ended by signal n (Ctrl-C: 130).");
  add_commands(app, context);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    return code == 0 ? 0 : 2;
  } catch (const orthodrive::OptionError& error) {
    monitor.fail(error.what());
    return 2;
  } catch (const orthodrive::Stopped& stopped) {
    monitor.fail(stopped.what());
    return 128 + stopped.signal;
  } catch (const std::exception& error) {
    monitor.fail(error.what());
    return 1;
  }
  monitor.clear_bar();
  return context.exit_code;
}

// SPDX-License-Identifier: Apache-2.0
// orthodrive view: a small web server for one built site and the viewer, reachable from this machine only.

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <spawn.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "commands.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/find_resource.hpp"
#include "view_server.hpp"

namespace orthodrive::app {
namespace {

constexpr const char* host = "127.0.0.1";

struct ViewOptions {
  std::filesystem::path folder;
  int port = 8080;
  bool no_open = false;
};

std::filesystem::path viewer_folder() {
  const char* elsewhere = std::getenv("ORTHODRIVE_VIEWER_DIR");
  const std::vector<std::filesystem::path> folders =
      elsewhere ? std::vector<std::filesystem::path>{elsewhere} : resource_folders("viewer", "viewer/dist");
  return find_resource(
             folders, "index.html", "the viewer is not built",
             "run `npm ci && npm run build` in the folder viewer/, or set ORTHODRIVE_VIEWER_DIR to a built one")
      .parent_path();
}

void check_site(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder))
    throw InputError(folder.string(), "no such folder; give the output folder of `orthodrive build`");
  if (!std::filesystem::exists(folder / "scene" / "tileset.json"))
    throw InputError(folder.string(),
                     "holds no scene/tileset.json; build the site first: orthodrive build site.toml -o DIR");
}

int bind_port(httplib::Server& server, int port) {
  if (port == 0) {
    port = server.bind_to_any_port(host);
    if (port < 0) throw Error(fmt::format("{}: no free port to serve on", host));
  } else if (!server.bind_to_port(host, port)) {
    throw Error(
        fmt::format("{}:{}: cannot serve there, the port is in use or not allowed; choose another with --port, "
                    "or --port 0 for any free one",
                    host, port));
  }
  return port;
}

/// Starts the desktop's browser when there is a desktop; no browser is no error, the address is printed anyway.
void open_browser(const std::string& url) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  std::string command = "xdg-open", argument = url;
  char* argv[] = {command.data(), argument.data(), nullptr};
  pid_t child = 0;
  posix_spawnattr_t attributes;  // the browser takes signals as ever
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  (void)posix_spawnp(&child, argv[0], &actions, &attributes, argv, environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
}

/// Ctrl-C (SIGINT) and SIGTERM wait for serve_until_signal: from before anybody is told the address, and before the
/// server's threads exist, which inherit it.
sigset_t hold_end_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

/// Serves until one of those signals, which ends the command well.
void serve_until_signal(httplib::Server& server, const sigset_t& signals) {
  std::thread serving([&server] { server.listen_after_bind(); });
  while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));  // stop() before that is lost
  int signal_number = 0;
  sigwait(&signals, &signal_number);
  server.stop();
  serving.join();
}

void view(const ViewOptions& options, Monitor* monitor) {
  check_site(options.folder);
  const std::filesystem::path viewer = viewer_folder();
  ViewServer server(ViewFiles(options.folder, viewer));
  const int port = bind_port(server, options.port);
  server.expect_calls(port);
  const std::string url = fmt::format("http://{}:{}/", host, port);
  const sigset_t signals = hold_end_signals();
  fmt::print("{}\n", url);
  std::fflush(stdout);
  monitor->info(fmt::format("serving {} until Ctrl-C", options.folder.string()));
  if (!options.no_open) open_browser(url);
  serve_until_signal(server, signals);
}

}  // namespace

void add_view(CLI::App& app, Context& context) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* cmd = app.add_subcommand(
      "view",
      "Shows a built site in the browser: terrain, roads, orthophoto and the driven lap.\n"
      "Reads DIR (scene/, drive/lap.csv, run.json, findings.geojson, road_graph.geojson, roads.xodr); serves it on\n"
      "127.0.0.1 until Ctrl-C. A second lap below DIR drives along with ?ghost=FILE behind the address.");
  cmd->add_option("DIR", options->folder, "output folder of `orthodrive build`")->required();
  cmd->add_option("--port", options->port, "TCP port, 0 = any free one; the address is printed on standard output")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  cmd->add_flag("--no-open", options->no_open, "do not start a browser");
  cmd->footer(
      "Examples:\n"
      "  orthodrive view out/kvarnbyn\n"
      "  orthodrive view out/kvarnbyn --port 0 --no-open");
  cmd->callback([options, &context] { view(*options, context.monitor); });
}

}  // namespace orthodrive::app

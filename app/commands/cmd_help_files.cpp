// SPDX-License-Identifier: Apache-2.0
// orthodrive help-files: manual pages and completions of shells, as the installation wants them. Not listed by --help.

#include <fmt/format.h>

#include <memory>

#include "command_table.hpp"
#include "commands.hpp"
#include "completion.hpp"
#include "man_page.hpp"
#include "orthodrive/core/atomic_file.hpp"

namespace orthodrive::app {
namespace fs = std::filesystem;

namespace {
void write_help_files(const CLI::App& app, const fs::path& folder) {
  const CommandText tool = command_table(app);
  fs::create_directories(folder);
  write_text_file(folder / "orthodrive.1", tool_page(tool, app.version()));
  for (const CommandText& command : tool.commands)
    write_text_file(folder / fmt::format("orthodrive-{}.1", command.name), command_page(tool, command, app.version()));
  write_text_file(folder / "orthodrive.bash", bash_completion(tool));
  write_text_file(folder / "orthodrive.zsh", zsh_completion(tool));
  write_text_file(folder / "orthodrive.fish", fish_completion(tool));
}
}  // namespace

void add_help_files(CLI::App& app, Context&) {
  auto folder = std::make_shared<fs::path>();
  CLI::App* cmd =
      app.add_subcommand("help-files", "Write a manual page per command, and completions for bash, zsh and fish.");
  cmd->group("");
  cmd->add_option("DIR", *folder, "folder to write to; created when missing")->required();
  cmd->footer("Examples:\n  orthodrive help-files build/help");
  cmd->callback([&app, folder] { write_help_files(app, *folder); });
}

}  // namespace orthodrive::app

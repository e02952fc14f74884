// SPDX-License-Identifier: Apache-2.0
#pragma once
// Runs the command line tool as a user does.

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "io/scratch.hpp"
#include "paths.hpp"

namespace orthodrive {

using Arguments = std::vector<std::string>;

/// Starts a program with its standard output and error going to files. Returns its process id.
inline pid_t start_program(Arguments command, const std::filesystem::path& out, const std::filesystem::path& err) {
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), flags, 0600);
  pid_t child = 0;
  const int failed = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(failed, 0) << "cannot start " << command[0];
  return child;
}

/// Exit code of a started program once it has ended; 128 + the signal that killed it, as a shell has it.
inline int wait_for(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

struct ToolRun {
  int exit_code = -1;
  std::string out, err;
};

inline ToolRun run_program(const Arguments& command) {
  std::string pattern = (std::filesystem::temp_directory_path() / "orthodrive-run-XXXXXX").string();
  const std::filesystem::path streams = mkdtemp(pattern.data());
  ToolRun run;
  run.exit_code = wait_for(start_program(command, streams / "out", streams / "err"));
  run.out = bytes_of(streams / "out"), run.err = bytes_of(streams / "err");
  std::filesystem::remove_all(streams);
  return run;
}

inline ToolRun run_tool(Arguments arguments) {
  arguments.insert(arguments.begin(), paths::tool);
  return run_program(arguments);
}

/// Runs the tool where no file can grow beyond so many KiB: writing fails as it does on a full disk.
inline ToolRun run_tool_with_file_limit(int limit_kib, const Arguments& arguments) {
  // Ignored signals stay ignored in the program, so that it sees the error of write() instead of SIGXFSZ.
  Arguments command{"/bin/bash", "-c", "trap '' XFSZ; ulimit -f " + std::to_string(limit_kib) + "; exec \"$@\"", "bash",
                    paths::tool};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_program(command);
}

/// All files below a folder with their content (not empty folders): equal before and after means that nothing was
/// touched.
inline std::map<std::string, std::string> snapshot(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files[entry.path().string()] = bytes_of(entry.path());
  return files;
}

}  // namespace orthodrive

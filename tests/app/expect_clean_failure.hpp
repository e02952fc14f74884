// SPDX-License-Identifier: Apache-2.0
#pragma once
// What every failure of the tool has in common, whatever the command.

#include <gmock/gmock.h>

#include <algorithm>

#include "app/run_tool.hpp"

namespace orthodrive {

/// Exit code 1, nothing on standard output, exactly one line on standard error that names the file, and no file
/// below `folder` new, gone or changed. `run` gets nothing and returns the ToolRun.
template <typename Run>
void expect_clean_failure(const std::filesystem::path& folder, const std::string& named_file, Run&& run) {
  const auto before = snapshot(folder);
  const ToolRun result = run();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(result.err, testing::StartsWith("orthodrive: "));
  EXPECT_THAT(result.err, testing::HasSubstr(named_file));
  for (const auto& [path, content] : snapshot(folder)) {
    const auto earlier = before.find(path);
    if (earlier == before.end())
      ADD_FAILURE() << "left behind: " << path;
    else
      EXPECT_TRUE(earlier->second == content) << "changed: " << path;
  }
  for (const auto& [path, content] : before) EXPECT_TRUE(std::filesystem::exists(path)) << "gone: " << path;
}

}  // namespace orthodrive

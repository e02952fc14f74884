// SPDX-License-Identifier: Apache-2.0
// `orthodrive cells`: a build that several processes share has the bytes of one, whoever is killed.

#include <signal.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "small_site.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A site of four windows of labels, and its build by one process.
class Cells : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::string pattern = (fs::temp_directory_path() / "orthodrive-cells-XXXXXX").string();
    scratch = mkdtemp(pattern.data());
    ASSERT_EQ(run_tool({"-q", "synth", "--seed", "4", "--size", "520", "--gsd", "0.25", "-o", site().parent_path()})
                  .exit_code,
              0);
    ASSERT_EQ(run_tool({"-q", "build", site(), "-o", folder() / "whole"}).exit_code, 0);
  }
  static void TearDownTestSuite() { fs::remove_all(scratch); }
  void TearDown() override { fs::remove_all(out()); }
  static fs::path folder() { return scratch; }
  static fs::path site() { return folder() / "site" / "site.toml"; }
  static fs::path out() { return folder() / "shared"; }
  static fs::path cells() { return out() / ".orthodrive" / "cells"; }
  static ToolRun missing(Arguments more = {}) {
    Arguments all{"cells", "missing", site(), "-o", out()};
    all.insert(all.end(), more.begin(), more.end());
    return run_tool(all);
  }
  static pid_t start_work(int index, int of) {
    const std::string name = "work" + std::to_string(index);
    return start_program({paths::tool, "-q", "--threads", "1", "cells", "work", site(), "-o", out(), "--index",
                          std::to_string(index), "--of", std::to_string(of)},
                         folder() / (name + ".out"), folder() / (name + ".err"));
  }
  static std::size_t complete_cells() {
    std::size_t count = 0;
    std::error_code ignored;
    for (fs::recursive_directory_iterator it(cells(), ignored), end; it != end; it.increment(ignored)) {
      const bool is_whole = it->path().parent_path().filename().string()[0] != '.';
      if (it->path().filename() == "cell.bin" && is_whole) ++count;
      if (ignored) break;
    }
    return count;
  }
  /// Processes that work on a stage.
  static std::size_t signs_of_life() {
    std::size_t signs = 0;
    std::error_code ignored;
    for (fs::directory_iterator it(cells(), ignored), end; it != end; it.increment(ignored)) {
      signs += it->path().filename().string().starts_with("alive-") ? 1 : 0;
      if (ignored) break;
    }
    return signs;
  }
  template <typename Condition>
  static void wait_until(const Condition& condition) {
    for (int i = 0; i < 60000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_TRUE(condition());
  }
  /// A process that helps, alone, and is killed after its first cell.
  static void lose_a_helper() {
    const pid_t node = start_work(1, 2);
    wait_until([] { return complete_cells() > 0; });
    kill(node, SIGKILL);
    wait_for(node);
  }
  static void expect_bytes_of_one() {
    const auto shared = SmallBuild::results(out()), whole = SmallBuild::results(folder() / "whole");
    for (const auto& [name, bytes] : whole) EXPECT_TRUE(shared.contains(name) && shared.at(name) == bytes) << name;
    for (const auto& [name, bytes] : shared) EXPECT_TRUE(whole.contains(name)) << "left behind: " << name;
    EXPECT_FALSE(fs::exists(cells()));
    EXPECT_EQ(missing().exit_code, 0);
  }
  static fs::path scratch;
};
fs::path Cells::scratch;

TEST_F(Cells, several_processes_make_the_bytes_of_one) {
  EXPECT_EQ(missing().out, "segment refine elevate network drive scene report\n");
  EXPECT_EQ(missing().exit_code, 1);
  // One that helps has begun before the others start, and waits until another one works beside it: no luck is needed.
  const pid_t first = start_work(1, 3);
  wait_until([] { return signs_of_life() >= 1; });
  kill(first, SIGSTOP);
  const pid_t builder = start_work(0, 3), last = start_work(2, 3);
  wait_until([] { return signs_of_life() >= 2; });
  kill(first, SIGCONT);
  for (const pid_t node : {first, builder, last}) EXPECT_EQ(wait_for(node), 0);
  expect_bytes_of_one();

  // A queue that starts a job once more: nothing is left to do.
  const std::string run = bytes_of(out() / "run.json");
  const pid_t late = start_work(2, 3);
  EXPECT_EQ(wait_for(late), 0);
  EXPECT_EQ(bytes_of(out() / "run.json"), run);
  const std::string other = paths::in_source("models/training/two_towns.safetensors").string();
  EXPECT_THAT(missing({"--set", "segment.model=" + other}).out, HasSubstr("segment refine"));
}

TEST_F(Cells, who_is_lost_is_replaced) {
  lose_a_helper();
  EXPECT_FALSE(fs::exists(out() / "labels.tif"));
  // The cell that the helper had begun is made again; then the process that builds is lost, and another one builds.
  const pid_t builder = start_work(0, 2), helper = start_work(1, 2);
  wait_until([] { return fs::exists(out() / ".orthodrive" / "segment.json"); });
  kill(builder, SIGKILL);
  wait_for(builder);
  EXPECT_EQ(wait_for(helper), 0) << bytes_of(folder() / "work1.err");
  expect_bytes_of_one();
}

TEST_F(Cells, damaged_ones_are_told) {
  lose_a_helper();
  fs::path damaged;
  for (const auto& entry : fs::recursive_directory_iterator(cells()))
    if (entry.path().filename() == "cell.bin") damaged = entry.path();
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  const ToolRun build = run_tool({"-q", "build", site(), "-o", out()});
  EXPECT_EQ(build.exit_code, 1);
  EXPECT_EQ(lines_of(build.err), 1U) << build.err;
  EXPECT_THAT(build.err, HasSubstr("cell.bin: is damaged; remove its folder"));
  EXPECT_FALSE(fs::exists(out() / "labels.tif"));
}

TEST(CellsCommand, an_index_out_of_range_is_refused) {
  const ToolRun run = run_tool({"cells", "work", "site.toml", "-o", "out", "--index", "3", "--of", "3"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--index 3: there are 3 processes, from 0 to 2"));
}

}  // namespace
}  // namespace orthodrive

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
using ::testing::MatchesRegex;

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
  static fs::path folder() { return scratch; }
  static fs::path site() { return folder() / "site" / "site.toml"; }
  static fs::path out() { return folder() / "shared"; }
  static Arguments words(const std::string& sub, Arguments more = {}) {
    Arguments all{"-q", "--threads", "1", "cells", sub, site(), "-o", out()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  static ToolRun cells(const std::string& sub, Arguments more = {}) { return run_tool(words(sub, std::move(more))); }
  static std::size_t complete_cells() {
    std::size_t count = 0;
    if (fs::exists(out() / ".orthodrive/cells"))
      for (const auto& entry : fs::recursive_directory_iterator(out() / ".orthodrive/cells"))
        count +=
            entry.path().filename() == "cell.bin" && entry.path().parent_path().filename().string()[0] != '.' ? 1 : 0;
    return count;
  }
  /// Chunks at the same time, each in a process.
  static void run_chunks(int chunks) {
    std::vector<std::thread> processes;
    for (int chunk = 0; chunk < chunks; ++chunk)
      processes.emplace_back([=] {
        const ToolRun run = cells("run", {"--chunk", std::to_string(chunk), "--chunks", std::to_string(chunks)});
        EXPECT_EQ(run.exit_code, 0) << run.err;
      });
    for (std::thread& process : processes) process.join();
  }
  static fs::path scratch;

  static void expect_only_good_cells_are_taken();
};
fs::path Cells::scratch;

/// Cells of other options are not taken, damaged ones are told. Leaves one of four to be made.
void Cells::expect_only_good_cells_are_taken() {
  const ToolRun other = cells(
      "missing", {"--set", "segment.model=" + paths::in_source("models/training/two_towns.safetensors").string()});
  EXPECT_THAT(other.out, HasSubstr("segment 0")) << other.err;

  fs::path damaged;
  for (const auto& entry : fs::recursive_directory_iterator(out() / ".orthodrive/cells"))
    if (entry.path().filename() == "cell.bin") damaged = entry.path();
  ASSERT_FALSE(damaged.empty());
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  const ToolRun merge = cells("merge");
  EXPECT_EQ(merge.exit_code, 1);
  EXPECT_EQ(lines_of(merge.err), 1U) << merge.err;
  EXPECT_THAT(merge.err, HasSubstr("cell.bin: is damaged; remove its folder"));
  EXPECT_FALSE(fs::exists(out() / "labels.tif"));
  fs::remove_all(damaged.parent_path());
  EXPECT_THAT(cells("merge").out, HasSubstr("segment: 1 of 4 cells"));
}

TEST_F(Cells, several_processes_make_the_bytes_of_one_whoever_is_killed) {
  ToolRun merge = cells("merge");
  ASSERT_EQ(merge.exit_code, 0) << merge.err;
  EXPECT_EQ(merge.out, "segment: 4 of 4 cells are missing\n");
  EXPECT_FALSE(fs::exists(out() / "labels.tif"));
  ToolRun missing = cells("missing");
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_EQ(missing.out, "segment 0 1 2 3\n");

  // A node that dies after its first cell.
  Arguments lost = words("run", {"--chunk", "0", "--chunks", "1"});
  lost.insert(lost.begin(), paths::tool);
  const pid_t node = start_program(lost, folder() / "lost.out", folder() / "lost.err");
  for (int i = 0; i < 2000 && complete_cells() == 0; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill(node, SIGKILL);
  wait_for(node);
  const std::size_t left = complete_cells();
  EXPECT_GE(left, 1U);
  EXPECT_EQ(cells("merge").out, "segment: " + std::to_string(4 - left) + " of 4 cells are missing\n");
  EXPECT_FALSE(fs::exists(out() / "labels.tif"));

  run_chunks(3);
  EXPECT_EQ(cells("missing").exit_code, 0);
  expect_only_good_cells_are_taken();
  run_chunks(2);
  std::string stages;
  for (int round = 0; round < 5; ++round) {
    merge = cells("merge");
    ASSERT_EQ(merge.exit_code, 0) << merge.err;
    if (merge.out == "done\n") break;
    stages += merge.out.substr(0, merge.out.find(':')) + " ";
    EXPECT_THAT(merge.out, MatchesRegex("[a-z]+: [0-9]+ of [0-9]+ cells are missing\n"));
    run_chunks(2);
    run_chunks(2);  // a queue that starts jobs twice
  }
  EXPECT_EQ(merge.out, "done\n");
  EXPECT_EQ(stages, "refine network scene ");
  EXPECT_EQ(cells("missing").exit_code, 0);
  const auto shared = SmallBuild::results(out()), whole = SmallBuild::results(folder() / "whole");
  for (const auto& [name, bytes] : whole) EXPECT_TRUE(shared.contains(name) && shared.at(name) == bytes) << name;
  for (const auto& [name, bytes] : shared) EXPECT_TRUE(whole.contains(name)) << "left behind: " << name;
  EXPECT_THAT(cells("run", {"--chunk", "0", "--chunks", "1"}).out, HasSubstr("0 cells made"));
}

TEST(CellsCommand, chunks_out_of_range_are_refused) {
  const ToolRun run = run_tool({"cells", "run", "site.toml", "-o", "out", "--chunk", "3", "--chunks", "3"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--chunk 3: there are 3 chunks, from 0 to 2"));
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/atomic_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("orthodrive_core_" + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(AtomicFile, keeps_the_earlier_file_when_writing_fails) {
  const fs::path folder = fresh_folder("aside"), target = folder / "out.txt";
  write_text_file(target, "first");
  {
    AtomicFile out(target);
    std::ofstream(out.path()) << "half";
    EXPECT_EQ(out.path().extension(), ".txt");
  }  // no commit: as after an exception
  EXPECT_EQ(content(target), "first");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}), 1);
  write_text_file(target, "second");
  EXPECT_EQ(content(target), "second");
}

TEST(AtomicFile, replaces_a_folder_as_a_whole) {
  const fs::path folder = fresh_folder("aside_folder"), target = folder / "scene";
  fs::create_directories(target);
  std::ofstream(target / "old.glb") << "old";
  AtomicFile out(target);
  fs::create_directories(out.path());
  std::ofstream(out.path() / "new.glb") << "new";
  out.commit();
  EXPECT_TRUE(fs::exists(target / "new.glb"));
  EXPECT_FALSE(fs::exists(target / "old.glb"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}), 1);
}

TEST(AtomicFile, what_a_killed_process_left_is_removed_and_a_living_ones_is_not) {
  const fs::path folder = fresh_folder("stale");
  const fs::path living = folder / (".scene.partial-" + std::to_string(getppid()));
  fs::create_directories(living);
  const fs::path dead = folder / ".labels.partial-2147483646.tif";  // beyond every pid_max
  std::ofstream(dead) << "half";
  const fs::path replaced = folder / ".scene.old.partial-2147483646";
  fs::create_directories(replaced / "below");
  const fs::path same_id = folder / (".roads.partial-" + std::to_string(getpid()) + ".gpkg");
  std::ofstream(same_id) << "of an earlier process with our id";
  std::ofstream(folder / "labels.tif") << "whole";
  remove_stale_atomic_files(folder);
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_FALSE(fs::exists(replaced));
  EXPECT_FALSE(fs::exists(same_id));
  EXPECT_TRUE(fs::exists(living));
  EXPECT_TRUE(fs::exists(folder / "labels.tif"));
  remove_stale_atomic_files(folder / "nowhere");
}

TEST(AtomicFile, a_process_that_ends_at_once_leaves_no_temporary) {
  const fs::path folder = fresh_folder("ended");
  EXPECT_EXIT(
      {
        AtomicFile labels(folder / "labels.tif");
        AtomicFile scene(folder / "scene");
        std::ofstream(labels.path()) << "half";
        std::ofstream(labels.path().string() + ".ovr.tmp") << "GDAL's";
        fs::create_directories(scene.path() / "below");
        AtomicFile whole(folder / "roads.xodr");
        std::ofstream(whole.path()) << "whole";
        whole.commit();
        remove_own_atomic_files();
        _exit(7);
      },
      testing::ExitedWithCode(7), "");
  std::vector<std::string> left;
  for (const auto& entry : fs::directory_iterator(folder)) left.push_back(entry.path().filename());
  EXPECT_EQ(left, std::vector<std::string>{"roads.xodr"});
}

TEST(AtomicFile, a_full_disk_is_an_error_that_names_the_file) {
  try {
    write_text_file("/dev/full/roads.xodr", "x");
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("/dev/full"));
  }
}

}  // namespace
}  // namespace orthodrive

#include "orthodrive/core/atomic_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  AtomicFile mine(folder / "scene");
  fs::create_directories(mine.path());
  const fs::path dead = folder / ".labels.partial-2147483646.tif";  // beyond every pid_max
  std::ofstream(dead) << "half";
  std::ofstream(folder / "labels.tif") << "whole";
  remove_stale_atomic_files(folder);
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(mine.path()));
  EXPECT_TRUE(fs::exists(folder / "labels.tif"));
  remove_stale_atomic_files(folder / "nowhere");
}

TEST(AtomicFile, a_full_disk_is_an_error_that_names_the_file) {
  const fs::path folder = fresh_folder("full");
  try {
    write_text_file("/dev/full/roads.xodr", "x");
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("/dev/full"));
  }
}

}  // namespace
}  // namespace orthodrive

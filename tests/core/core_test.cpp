#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <vector>

#include "orthodrive/core/aside_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/core/memory.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"

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

TEST(ParallelFor, visits_every_index_once_for_any_thread_count) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> visits(1000);
    parallel_for(visits.size(), threads, [&](std::size_t i) { ++visits[i]; });
    for (const auto& n : visits) ASSERT_EQ(n.load(), 1);
  }
  parallel_for(0, 2, [](std::size_t) { FAIL(); });
}

TEST(ParallelFor, rethrows_after_all_workers_stopped) {
  EXPECT_THROW(parallel_for(100, 2, [](std::size_t i) { if (i == 37) throw InputError("a.tif", "is broken"); }), InputError);
}

TEST(AsideFile, keeps_the_earlier_file_when_writing_fails) {
  const fs::path folder = fresh_folder("aside"), target = folder / "out.txt";
  write_text_file(target, "first");
  {
    AsideFile out(target);
    std::ofstream(out.path()) << "half";
    EXPECT_EQ(out.path().extension(), ".txt");
  }  // no commit: as after an exception
  EXPECT_EQ(content(target), "first");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}), 1);
  write_text_file(target, "second");
  EXPECT_EQ(content(target), "second");
}

TEST(AsideFile, replaces_a_folder_as_a_whole) {
  const fs::path folder = fresh_folder("aside_folder"), target = folder / "scene";
  fs::create_directories(target);
  std::ofstream(target / "old.glb") << "old";
  AsideFile out(target);
  fs::create_directories(out.path());
  std::ofstream(out.path() / "new.glb") << "new";
  out.commit();
  EXPECT_TRUE(fs::exists(target / "new.glb"));
  EXPECT_FALSE(fs::exists(target / "old.glb"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}), 1);
}

TEST(AsideFile, what_a_killed_process_left_is_removed_and_a_living_ones_is_not) {
  const fs::path folder = fresh_folder("stale");
  AsideFile mine(folder / "scene");
  fs::create_directories(mine.path());
  const fs::path dead = folder / ".labels.partial-2147483646.tif";  // beyond every pid_max
  std::ofstream(dead) << "half";
  std::ofstream(folder / "labels.tif") << "whole";
  remove_stale_asides(folder);
  EXPECT_FALSE(fs::exists(dead));
  EXPECT_TRUE(fs::exists(mine.path()));
  EXPECT_TRUE(fs::exists(folder / "labels.tif"));
  remove_stale_asides(folder / "nowhere");
}

TEST(AsideFile, a_full_disk_is_an_error_that_names_the_file) {
  const fs::path folder = fresh_folder("full");
  try {
    write_text_file("/dev/full/roads.xodr", "x");
    FAIL() << "expected an error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("/dev/full"));
  }
}

TEST(Hash, known_value_and_file_equals_bytes) {
  EXPECT_EQ(hash_bytes(""), "99aa06d3014798d86001c324468d497f");  // XXH3-128 of nothing, from the xxHash specification
  const fs::path file = fresh_folder("hash") / "a.bin";
  const std::string bytes(3'000'000, 'x');
  write_text_file(file, bytes);
  EXPECT_EQ(hash_file(file), hash_bytes(bytes));
  EXPECT_THROW((void)hash_file("/nonexistent/file"), InputError);
}

TEST(Random, stream_is_fixed_and_moments_are_right) {
  Random a(7), b(7), c(8);
  EXPECT_EQ(a.next(), b.next());
  EXPECT_NE(a.next(), c.next());
  double sum = 0.0, square = 0.0;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const double x = a.normal();
    sum += x, square += x * x;
  }
  EXPECT_NEAR(sum / n, 0.0, 0.02);
  EXPECT_NEAR(square / n, 1.0, 0.02);
}

TEST(Memory, peak_is_reset_and_grows_again) {
  if (peak_memory_bytes() == 0) GTEST_SKIP() << "no VmHWM on this system";
  reset_peak_memory();
  const auto before = peak_memory_bytes();
  {
    std::vector<char> block(200'000'000, 1);
    EXPECT_EQ(block[199'999'999], 1);
  }
  EXPECT_GT(peak_memory_bytes(), before + 190'000'000);
}

}  // namespace
}  // namespace orthodrive

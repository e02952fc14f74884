// SPDX-License-Identifier: Apache-2.0
#pragma once
// Every reader of foreign files gets seeded mutations of a small valid sample. It returns or throws an error that a
// person can read; it never crashes, hangs or takes memory without bound. A crash leaves the input that caused it in
// the temporary folder; the seed in a message brings it back: mutate(sample, seed).

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "cpu_seconds.hpp"
#include "fuzz/mutate.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/memory.hpp"

namespace orthodrive::fuzz {

constexpr int most_mutations = 3000;            // a reader; fewer where the time runs out first
constexpr double most_seconds = 2.0;            // a reader
constexpr double slow_seconds = 10.0;           // an input: as long as this is a hang
constexpr std::uint64_t most_bytes = 1U << 30;  // an input of some kilobytes

using Reader = std::function<void(const std::filesystem::path&)>;

/// How many files this process may have open. libosmium 2.19 leaves a damaged PBF file open, one a refused file.
inline long allow_open_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 8 * most_mutations);
  return setrlimit(RLIMIT_NOFILE, &limit) == 0 ? static_cast<long>(limit.rlim_cur) : 0;
}

/// `Expected` is what the reader may throw. The sample itself must be read.
template <typename Expected = Error>
void expect_survives(const std::string& file_name, const std::string& sample, const Reader& read) {
  const Scratch scratch;
  const std::filesystem::path file = scratch / file_name;
  write_bytes(file, sample);
  ASSERT_NO_THROW(read(file)) << "the sample is not valid";
  const double start = test::cpu_seconds();  // other work on the machine takes no mutation away
  const auto seconds = [&] { return test::cpu_seconds() - start; };
  const std::uint64_t memory_before = peak_memory_bytes();
  int refused = 0, done = 0;
  // Several readers of one process may leave files open.
  const long most = std::min<long>(most_mutations, allow_open_files() / 4 - 100);
  for (; done < most && seconds() < most_seconds; ++done) {
    const auto seed = static_cast<std::uint64_t>(done);
    std::filesystem::remove(file);  // ext4 writes a file that is emptied and filled anew to the disk at once: 5 ms each
    write_bytes(file, mutate(sample, seed));
    const double began = seconds();
    try {
      read(file);
    } catch (const Expected& error) {
      ++refused;
      const std::string what = error.what();
      EXPECT_FALSE(what.empty()) << "seed " << seed;
      EXPECT_EQ(what.find('\n'), std::string::npos) << "seed " << seed << ": " << what;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "seed " << seed << " threw what is no error of ours: " << error.what();
    }
    EXPECT_LT(seconds() - began, slow_seconds) << "seed " << seed;
    ASSERT_LT(peak_memory_bytes(), memory_before + most_bytes) << "seed " << seed;
  }
  EXPECT_GT(refused, 0) << "of " << done;  // or nothing was damaged
  ::testing::Test::RecordProperty("mutations", done);
}

}  // namespace orthodrive::fuzz

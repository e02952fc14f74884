// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/hash.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

TEST(Hash, known_value_and_file_equals_bytes) {
  EXPECT_EQ(hash_bytes(""), "99aa06d3014798d86001c324468d497f");  // XXH3-128 of nothing, from the xxHash specification
  const auto file = std::filesystem::temp_directory_path() / "orthodrive_core_hash.bin";
  const std::string bytes(3'000'000, 'x');
  write_text_file(file, bytes);
  EXPECT_EQ(hash_file(file), hash_bytes(bytes));
  EXPECT_THROW((void)hash_file("/nonexistent/file"), InputError);
}

}  // namespace
}  // namespace orthodrive

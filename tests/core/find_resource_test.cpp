// SPDX-License-Identifier: Apache-2.0
// Where models and the viewer are looked for, and what is said when they are not there.

#include "orthodrive/core/find_resource.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

TEST(FindResource, folders_are_beside_the_program_then_in_its_source_tree) {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const std::vector<fs::path> folders = resource_folders("models", "models");
  ASSERT_EQ(folders.size(), 2u) << "this test lies in a build folder of the source tree";
  EXPECT_EQ(folders[0], program.parent_path().parent_path() / "share/orthodrive/models");
  EXPECT_TRUE(fs::exists(folders[1] / "default.safetensors")) << folders[1];
}

TEST(FindResource, takes_the_first_folder_that_holds_the_file) {
  const fs::path scratch = fs::path(testing::TempDir()) / "orthodrive_find_resource";
  for (const char* folder : {"a", "b", "c"}) fs::create_directories(scratch / folder);
  fs::create_directories(scratch / "a" / "file");  // a folder of that name is not it
  for (const char* folder : {"b", "c"}) std::ofstream(scratch / folder / "file") << folder;
  EXPECT_EQ(find_resource({scratch / "a", scratch / "b", scratch / "c"}, "file", "what", "remedy"),
            scratch / "b" / "file");
  fs::remove_all(scratch);
}

TEST(FindResource, names_every_place_and_the_remedy) {
  try {
    (void)find_resource({"/nowhere", "/else"}, "x.safetensors", "x: no such model", "give a file");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "x: no such model: there is no /nowhere/x.safetensors nor /else/x.safetensors; give a file");
  }
}

}  // namespace
}  // namespace orthodrive

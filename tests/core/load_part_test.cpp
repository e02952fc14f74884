// SPDX-License-Identifier: Apache-2.0
// Parts are loaded when they are of the same build; else one line says which package brings the right one.

#include "orthodrive/core/load_part.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/find_resource.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class LoadPart : public testing::Test {
 protected:
  const fs::path folder = fs::path(testing::TempDir()) / "orthodrive_load_part";
  const fs::path built = fs::read_symlink("/proc/self/exe").parent_path();  ///< where small_part.so lies
  const Part part{"counting", "small_part.so", "orthodrive_part_small", "orthodrive-parts"};

  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }
  void write(const std::string& text) const { std::ofstream(folder / part.file) << text; }
  /// What is said of the file in `folder`.
  [[nodiscard]] std::string message() const { return message(folder, build_id()); }
  [[nodiscard]] std::string message(const fs::path& in, const std::string& build) const {
    try {
      (void)load_part(part, {in}, build);
      return "loaded";
    } catch (const Error& error) {
      return error.what();
    }
  }
};

TEST_F(LoadPart, gives_the_table_of_a_part_of_this_build) {
  const void* table = load_part(part, {folder, built});
  EXPECT_EQ(*static_cast<const int*>(table), 7);
  EXPECT_EQ(load_part(part, {built}), table);
}

TEST_F(LoadPart, a_missing_one_is_named_with_its_package) {
  EXPECT_EQ(message(), "counting: there is no " + (folder / "small_part.so").string() +
                           "; install the Debian package orthodrive-parts");
}

TEST_F(LoadPart, one_of_another_build_is_not_loaded_and_both_are_named) {
  const std::string other = "99.0.0 (interface 00000000)";
  EXPECT_THAT(message(built, other), AllOf(HasSubstr("is of " + build_id()), HasSubstr("the program of " + other),
                                           HasSubstr("package orthodrive-parts"), Not(HasSubstr("\n"))));
  write("|orthodrive-build|" + other + "|");  // not even a library: its version is all that is looked at
  EXPECT_THAT(message(), AllOf(HasSubstr("is of " + other), HasSubstr("the program of " + build_id())));
  write("of somebody else");
  EXPECT_THAT(message(), HasSubstr("is of an unknown version"));
}

TEST_F(LoadPart, one_that_cannot_be_loaded_says_why_and_names_the_package) {
  write("|orthodrive-build|" + build_id() + "|");
  EXPECT_THAT(message(),
              AllOf(HasSubstr("cannot be loaded"), HasSubstr("package orthodrive-parts"), Not(HasSubstr("\n"))));
}

TEST(BuildId, tells_version_and_interface) {
  EXPECT_THAT(build_id(), testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+ \\(interface [0-9a-f]+\\)"));
}

TEST(LibraryFolders, are_of_the_installed_tree_then_of_the_build) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  EXPECT_EQ(library_folders(),
            (std::vector<fs::path>{program.parent_path() / "lib/orthodrive", program / "lib/orthodrive"}));
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// main() of all test programs. Each run has a temporary folder of its own, so that tests which write files of one name
// can run at one time. A filter that no case passes is an error, and `--suites=A:B` fails when the program has a suite
// besides: cmake/testing.cmake names suites as it reads them in the sources.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <string_view>

namespace {

/// The suite of "Sites/Build" is Build, that of "Build/0" too.
std::string_view name_in_source(std::string_view suite) {
  if (const auto slash = suite.rfind('/'); slash != std::string_view::npos) {
    const std::string_view last = suite.substr(slash + 1);
    suite = last.find_first_not_of("0123456789") == std::string_view::npos ? suite.substr(0, slash) : last;
  }
  return suite;
}

/// Suites of the program that `named`, a list such as "A:B", lacks.
int count_unnamed(const std::string& named) {
  int unnamed = 0;
  const ::testing::UnitTest& all = *::testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const std::string name(name_in_source(all.GetTestSuite(i)->name()));
    if ((":" + named + ":").find(":" + name + ":") != std::string::npos) continue;
    std::cerr << "ctest runs no case of " << all.GetTestSuite(i)->name() << '\n';
    ++unnamed;
  }
  return unnamed;
}

}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  constexpr std::string_view suites = "--suites=";
  if (argc == 2 && std::string_view(argv[1]).substr(0, suites.size()) == suites) {
    return count_unnamed(argv[1] + suites.size()) == 0 ? 0 : 1;
  }
  std::string folder = (std::filesystem::temp_directory_path() / "orthodrive-test-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    std::cerr << "cannot make a temporary folder as " << folder << '\n';
    return 1;
  }
  setenv("TMPDIR", folder.c_str(), 1);
  setenv("TEST_TMPDIR", (folder + "/").c_str(), 1);  // gtest's own: TempDir() ends with a slash
  int failed = RUN_ALL_TESTS();
  if (::testing::UnitTest::GetInstance()->test_to_run_count() == 0 && !::testing::GTEST_FLAG(list_tests)) {
    std::cerr << "no case passes the filter " << ::testing::GTEST_FLAG(filter) << '\n';
    failed = 1;
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return failed;
}

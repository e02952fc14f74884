// SPDX-License-Identifier: Apache-2.0
// main() of all test programs: each run has a temporary folder of its own, so that tests which write files of one name
// can run at one time.

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  std::string folder = (std::filesystem::temp_directory_path() / "orthodrive-test-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    std::cerr << "cannot make a temporary folder as " << folder << '\n';
    return 1;
  }
  setenv("TMPDIR", folder.c_str(), 1);
  setenv("TEST_TMPDIR", (folder + "/").c_str(), 1);  // gtest's own: TempDir() ends with a slash
  const int failed = RUN_ALL_TESTS();
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return failed;
}

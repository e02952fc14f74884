// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/find_resource.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
/// Empty where the system does not say.
fs::path folder_of_program() {
  std::error_code unknown;
  return fs::read_symlink("/proc/self/exe", unknown).parent_path();
}
}  // namespace

std::vector<fs::path> resource_folders(const std::string& installed, const std::string& in_tree) {
  const fs::path program_folder = folder_of_program();
  if (program_folder.empty()) return {};
  std::vector<fs::path> folders{program_folder.parent_path() / "share" / "orthodrive" / installed};
  for (fs::path folder = program_folder; folder != folder.root_path(); folder = folder.parent_path()) {
    if (!fs::is_directory(folder / "models") || !fs::is_directory(folder / "viewer")) continue;
    folders.push_back(folder / in_tree);
    break;
  }
  return folders;
}

std::vector<fs::path> library_folders() {
  const fs::path program_folder = folder_of_program();
  if (program_folder.empty()) return {};
  return {program_folder.parent_path() / "lib" / "orthodrive", program_folder / "lib" / "orthodrive"};
}

fs::path find_resource(const std::vector<fs::path>& folders, const std::string& file, const std::string& what,
                       const std::string& remedy) {
  std::string looked;
  for (const fs::path& folder : folders) {
    if (fs::is_regular_file(folder / file)) return folder / file;
    looked += (looked.empty() ? "" : " nor ") + (folder / file).string();
  }
  throw InputError(what, fmt::format("there is no {}; {}", looked, remedy));
}

}  // namespace orthodrive

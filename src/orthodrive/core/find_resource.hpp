// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the program needs at run time and does not carry in itself: models, the viewer and shared libraries. Found
// relative to the program, so that an installed tree works wherever it is moved.

#include <filesystem>
#include <string>
#include <vector>

namespace orthodrive {

/// Where to look for such files, in order: ../share/orthodrive/INSTALLED beside the folder of the running program, then
/// IN_TREE below the nearest folder above the program that holds `models` and `viewer`, which is the source tree that
/// it was built in.
[[nodiscard]] std::vector<std::filesystem::path> resource_folders(const std::string& installed,
                                                                  const std::string& in_tree);

/// Where our shared libraries lie, in order: ../lib/orthodrive beside the folder of the running program, and, as built,
/// lib/orthodrive in that folder.
[[nodiscard]] std::vector<std::filesystem::path> library_folders();

/// The file in the first folder that holds it. Throws InputError that begins with `what` and names all places looked at
/// and the remedy.
[[nodiscard]] std::filesystem::path find_resource(const std::vector<std::filesystem::path>& folders,
                                                  const std::string& file, const std::string& what,
                                                  const std::string& remedy);

}  // namespace orthodrive

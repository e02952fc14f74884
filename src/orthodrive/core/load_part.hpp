// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shared libraries of ours that are loaded when a command first needs them: the library of all rooms, and the parts
// that bring large libraries of others along (libtorch, OpenCV). docs/decisions/library_behind_a_launcher.md

#include <filesystem>
#include <string>
#include <vector>

namespace orthodrive {

/// Version and interface of this build, as in "0.1.0 (interface 3fa94c21)". The second is a hash of all headers: what
/// was compiled with others must not be loaded, even if the version is the same.
[[nodiscard]] std::string build_id();

struct Part {
  std::string what;     ///< what needs it, as the beginning of a message: "training"
  std::string file;     ///< below lib/orthodrive: "parts/train.so"
  std::string table;    ///< a C function without arguments that returns its table of functions
  std::string package;  ///< the Debian package that brings it and what it needs
};

/// Its table of functions, for the rest of the process. The first of `folders` that holds the file counts. Throws Error
/// of one line when there is none, when it is of another build than `build` (it is not loaded then), and when it cannot
/// be loaded, because libraries that it needs are missing.
[[nodiscard]] const void* load_part(const Part& part, const std::vector<std::filesystem::path>& folders,
                                    const std::string& build = build_id());

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/load_part.hpp"

#include <dlfcn.h>

#include <fstream>
#include <iterator>
#include <string_view>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/find_resource.hpp"

/// "|orthodrive-build|0.1.0 (interface 3fa94c21)|", written by cmake/build_id.cmake. Every library of ours has it.
extern "C" const char orthodrive_build_id[];

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
/// From `begin`, which starts with a mark between two bars, to the bar that ends the text.
std::string marked_text(std::string_view begin) {
  const std::size_t text = begin.find('|', 1) + 1;
  return std::string(begin.substr(text, begin.find('|', text) - text));
}

/// Read from the file's bytes, because a library of another build may not even load.
std::string build_of(const fs::path& file) {
  const std::string_view own = orthodrive_build_id;
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const std::size_t at = bytes.find(own.substr(0, own.find('|', 1) + 1));
  return at == std::string::npos ? "an unknown version" : marked_text(std::string_view(bytes).substr(at, 200));
}
}  // namespace

std::string build_id() { return marked_text(orthodrive_build_id); }

const void* load_part(const Part& part, const std::vector<fs::path>& folders, const std::string& build) {
  const fs::path file = find_resource(folders, part.file, part.what, "install the Debian package " + part.package);
  if (const std::string other = build_of(file); other != build)
    throw Error(file.string() + ": is of " + other + ", the program of " + build + "; install the Debian package " +
                part.package + " of the program's version");
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* table = library ? dlsym(library, part.table.c_str()) : nullptr;
  if (!table)
    throw Error(file.string() + ": cannot be loaded (" + dlerror() + "); the Debian package " + part.package +
                " brings it with all that it needs");
  return reinterpret_cast<const void* (*)()>(table)();
}

}  // namespace orthodrive

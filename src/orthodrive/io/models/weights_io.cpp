// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/weights_io.hpp"

#include <cstdlib>
#include <vector>

#include "orthodrive/core/find_resource.hpp"
#include "orthodrive/io/models/safetensors.hpp"
#include "orthodrive/io/support/read_file.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

fs::path find_model(const std::string& name_or_path) {
  const std::string remedy = "give a file or set ORTHODRIVE_MODELS", what = name_or_path + ": no such model";
  const bool bare = name_or_path.find('/') == std::string::npos && fs::path(name_or_path).extension().empty();
  if (!bare)
    return find_resource({fs::path(name_or_path).parent_path()}, fs::path(name_or_path).filename(), what, remedy);
  std::vector<fs::path> folders = resource_folders("models", "models");
  if (const char* folder = std::getenv("ORTHODRIVE_MODELS")) folders.insert(folders.begin(), folder);
  return find_resource(folders, name_or_path + ".safetensors", what, remedy);
}

TensorFile read_weights(const std::filesystem::path& path) { return parse_safetensors(read_file(path), path.string()); }

}  // namespace orthodrive::io

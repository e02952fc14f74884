#include "orthodrive/io/weights_io.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive::io {
namespace fs = std::filesystem;

std::string read_file(const fs::path& path) {
  std::error_code missing;
  const auto size = fs::file_size(path, missing);
  if (missing) throw InputError(path.string(), "cannot be read: " + missing.message());
  std::string bytes(size, '\0');
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw InputError(path.string(), "cannot be read to its end");
  return bytes;
}

fs::path find_model(const std::string& name_or_path) {
  std::vector<fs::path> candidates{name_or_path};
  const bool bare = name_or_path.find('/') == std::string::npos && fs::path(name_or_path).extension().empty();
  if (bare) {
    candidates.clear();
    if (const char* folder = std::getenv("ORTHODRIVE_MODELS"))
      candidates.push_back(fs::path(folder) / (name_or_path + ".safetensors"));
    candidates.push_back(fs::path(ORTHODRIVE_MODEL_DIR) / (name_or_path + ".safetensors"));
  }
  std::string looked;
  for (const fs::path& candidate : candidates) {
    if (fs::is_regular_file(candidate)) return candidate;
    looked += (looked.empty() ? "" : " nor ") + candidate.string();
  }
  throw InputError(name_or_path,
                   fmt::format("no such model: there is no {}; give a file or set ORTHODRIVE_MODELS", looked));
}

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/build/watched_sources.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/io/raster/raster_io.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

WatchedSources::WatchedSources(const std::vector<BuildStage>& stages) {
  for (const BuildStage& stage : stages)
    for (const SourceRole& source : stage.sources) {
      if (source.files.empty() || by_role_.contains(source.role)) continue;  // several stages read it
      std::vector<fs::path>& files = by_role_[source.role];
      for (const fs::path& file : source.files) {
        if (source.kind == SourceRole::Kind::raster) {
          const std::vector<fs::path> parts = io::raster_files(file);
          files.insert(files.end(), parts.begin(), parts.end());
        } else {
          files.push_back(file);
        }
      }
      for (const fs::path& file : files) {
        const FileStamp stamp = stamp_of(file);
        files_[file] = {stamp, is_racy(stamp, now_ns()), {}};
      }
    }
}

void WatchedSources::read(FileHashes& hashes) {
  for (auto& [path, file] : files_) file.hash = hashes.hash(path);
  for (const auto& [role, files] : by_role_)
    for (const fs::path& file : files)
      hashes_[role].push_back({{"file", file.filename().string()}, {"hash", files_.at(file).hash}});
}

nlohmann::json WatchedSources::of(const BuildStage& stage) const {
  nlohmann::json result = nlohmann::json::object();
  for (const SourceRole& source : stage.sources)
    if (!source.files.empty()) result[source.role] = hashes_.at(source.role);
  return result;
}

void WatchedSources::require_unchanged(const BuildStage& stage, const std::function<void()>& read) const {
  try {
    read();
  } catch (const InputError&) {
    require_unchanged(stage);
    throw;
  }
  require_unchanged(stage);
}

void WatchedSources::require_unchanged(const BuildStage& stage) const {
  for (const SourceRole& source : stage.sources) {
    if (source.files.empty()) continue;
    for (const fs::path& path : by_role_.at(source.role)) {
      const File& file = files_.at(path);
      const bool same_stamp = stamp_of(path) == file.stamp;
      if (same_stamp && !file.racy) continue;
      if (fs::exists(path) && hash_file(path) == file.hash) continue;
      throw InputError(path.string(), fmt::format("changed while stage {} read it; its result does not count, build "
                                                  "again when the file is whole",
                                                  stage.name));
    }
  }
}

}  // namespace orthodrive

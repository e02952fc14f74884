// SPDX-License-Identifier: Apache-2.0
#pragma once
// The source files of a build: their hashes, and whether they stayed the same while stages read them.

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "orthodrive/pipeline/files/file_hashes.hpp"
#include "orthodrive/pipeline/stages/build_stage.hpp"

namespace orthodrive {

class WatchedSources {
 public:
  /// Looks at the files as they are now; make it before anything reads them. Reads no content and throws nothing for
  /// files that are missing.
  explicit WatchedSources(const std::vector<BuildStage>& stages);
  /// Reads what `hashes` does not know. Throws InputError when a file cannot be read.
  void read(FileHashes& hashes);
  /// By role a list of {file, hash}; roles without a file are left out. Names without their folders: a source may move.
  [[nodiscard]] nlohmann::json of(const BuildStage& stage) const;
  /// Of all stages.
  [[nodiscard]] const nlohmann::json& all() const { return hashes_; }
  /// Does what reads the files of the stage. Throws InputError when one of them is not what it was at the start, also
  /// in place of the error of a reader that met a file half-written.
  void require_unchanged(const BuildStage& stage, const std::function<void()>& read) const;

 private:
  void require_unchanged(const BuildStage& stage) const;

  struct File {
    FileStamp stamp;
    bool racy = false;  ///< the stamp alone does not tell
    std::string hash;
  };
  std::map<std::string, std::vector<std::filesystem::path>> by_role_;
  std::map<std::filesystem::path, File> files_;
  nlohmann::json hashes_ = nlohmann::json::object();
};

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a stage left behind, so that the next run can skip it: DIR/.orthodrive/<stage>.json, written after the outputs
// are in place. A killed run leaves no record of the stage it was in, and starts there again.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/pipeline/files/file_hashes.hpp"
#include "orthodrive/pipeline/stages/stage_outcome.hpp"

namespace orthodrive {

/// All that the result of a stage depends on.
struct StageDependencies {
  int version = 0;
  nlohmann::json options = nlohmann::json::object();
  nlohmann::json sources = nlohmann::json::object();          ///< by role a list of {file, hash}
  std::map<std::string, std::optional<std::string>> reads{};  ///< hashes of earlier outputs; none: not made yet
};

[[nodiscard]] std::string key_of(const std::string& stage, const StageDependencies& dependencies);

struct StageRecord {
  std::string stage;
  std::string key;  ///< hash of the dependencies
  StageOutcome outcome;
  double seconds = 0.0;  ///< of the run that made the outputs
  std::uint64_t peak_memory_bytes = 0;
  bool skipped = false;                        ///< taken over from an earlier run
  std::map<std::string, std::string> outputs;  ///< hashes by name
};

/// What keeps a record from being taken over.
struct StageChanges {
  std::vector<std::string> reasons;  ///< for certain: texts for a person
  std::vector<std::string> unknown;  ///< earlier outputs that are not made yet and may come out as they were
};

class StageCache {
 public:
  /// `hashes` must outlive the cache.
  StageCache(std::filesystem::path out_dir, FileHashes& hashes);
  /// Compares with the record of the last run, and the outputs with what it left. Empty: it can be taken over.
  [[nodiscard]] StageChanges changes(const std::string& stage, const StageDependencies& now,
                                     const std::vector<std::string>& outputs) const;
  /// The record of an earlier run; only where there are no changes.
  [[nodiscard]] StageRecord load(const std::string& stage) const;
  /// Runs the body, measures it and writes the record with the hashes of the outputs (files or folders below out_dir).
  StageRecord run(const std::string& stage, const StageDependencies& now, const std::vector<std::string>& outputs,
                  const std::function<StageOutcome()>& body);
  /// Files of stages that are not for the user, e.g. roads before they have heights.
  [[nodiscard]] std::filesystem::path private_file(const std::string& name) const;

 private:
  std::filesystem::path out_dir_;
  FileHashes& hashes_;
};

}  // namespace orthodrive

#pragma once
// What a stage left behind, so that the next run can skip it: DIR/.orthodrive/<stage>.json, written after the outputs
// are in place. A killed run leaves no record of the stage it was in, and starts there again.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/pipeline/stage_outcome.hpp"

namespace orthodrive {

struct StageRecord {
  std::string stage;
  std::string key;  ///< hash of tool, options, sources and the stages before
  StageOutcome outcome;
  double seconds = 0.0;  ///< of the run that made the outputs
  std::uint64_t peak_memory_bytes = 0;
  bool skipped = false;  ///< taken over from an earlier run
};

class StageCache {
 public:
  explicit StageCache(std::filesystem::path out_dir);
  /// Whether the outputs of an earlier run with that key are all there, unchanged.
  [[nodiscard]] bool holds(const std::string& stage, const std::string& key) const;
  /// The record of an earlier run; only after holds().
  [[nodiscard]] StageRecord load(const std::string& stage) const;
  /// Runs the body, measures it and writes the record with the hashes of the outputs (files or folders below out_dir).
  StageRecord run(const std::string& stage, const std::string& key, const std::vector<std::string>& outputs,
                  const std::function<StageOutcome()>& body);
  /// Files of stages that are not for the user, e.g. roads before they have heights.
  [[nodiscard]] std::filesystem::path private_file(const std::string& name) const;

 private:
  std::filesystem::path out_dir_;
};

}  // namespace orthodrive

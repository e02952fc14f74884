// SPDX-License-Identifier: Apache-2.0
#pragma once
// A stage shared by processes through files: its cells, and the blocks of its loops as cells of a folder of their own
// for each loop.

#include <chrono>
#include <map>
#include <memory>
#include <mutex>

#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/pipeline/stages/cell_store.hpp"

namespace orthodrive {

/// The stage that a process helps with is put together, and its cells are gone.
struct StageIsMade {};

class CellExchange : public LoopExchange {
 public:
  enum class Role {
    builds,  ///< puts the stage together
    helps    ///< makes cells and blocks for the one that builds
  };
  /// Takes what others have made; leaves nothing.
  explicit CellExchange(const CellStore& store);
  /// Takes part: makes, claims and leaves blocks, beginning at a share of each loop in [0, 1). Shows that it lives as
  /// long as it does.
  CellExchange(const CellStore& store, Role role, double first_share);
  ~CellExchange() override;

  [[nodiscard]] std::optional<std::string> load(const std::string& loop, std::size_t block) const override;
  /// A link whose target names the process: it is there with its content or not at all. Its name holds the number of
  /// processes that claimed the block before and were lost. Throws StageIsMade.
  [[nodiscard]] std::optional<std::string> claim(const std::string& loop, std::size_t block) override;
  /// Those that gave no sign of life for ten seconds.
  [[nodiscard]] std::set<std::string> lost_of(const std::set<std::string>& makers) override;
  void keep(const std::string& loop, std::size_t block, const std::string& bytes) override;
  [[nodiscard]] double first_share() const override { return first_share_; }

  /// The loop whose blocks are the cells of a stage.
  static constexpr const char* cells = "cells";
  /// For the process that builds: what another one has made of a block; waits where one says that it makes it. Nothing:
  /// the caller makes it. From any thread.
  [[nodiscard]] std::optional<std::string> take(const std::string& loop, std::size_t block);
  /// For those that help: the last cell that nobody has made or makes. The one that builds takes them in their order,
  /// so that they meet once; where all went one way, it would wait for each cell that a helper has just begun. From any
  /// thread. Throws StageIsMade.
  [[nodiscard]] std::optional<std::size_t> next_cell(std::size_t count);
  /// Where the blocks of a loop lie.
  [[nodiscard]] CellStore store(const std::string& loop) const { return store_.part(loop); }

 private:
  class SignOfLife;
  struct Seen {
    std::string sign;
    std::chrono::steady_clock::time_point since;
  };

  const CellStore& store_;
  std::optional<Role> role_;
  double first_share_ = 0.0;
  std::unique_ptr<SignOfLife> sign_;
  std::mutex mutex_;
  std::set<std::string> lost_;
  std::map<std::string, Seen> seen_;  ///< of processes that are waited for
  std::size_t looked_at_ = 0;         ///< cells, by next_cell()
};

}  // namespace orthodrive

#pragma once
// The loops of a stage shared through files: blocks are cells of a folder of their own for each loop.

#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/pipeline/cell_store.hpp"

namespace orthodrive {

class CellExchange : public LoopExchange {
 public:
  /// Takes what others have made; leaves nothing.
  explicit CellExchange(const CellStore& store) : store_(store) {}
  /// Takes part: makes, claims and leaves blocks, beginning at a share of each loop in [0, 1).
  CellExchange(const CellStore& store, double first_share)
      : store_(store), takes_part_(true), first_share_(first_share) {}

  [[nodiscard]] std::optional<std::string> load(const std::string& loop, std::size_t block) const override;
  /// A link whose target names the process: it is there with its content or not at all. Its name holds the number of
  /// processes that claimed the block before and were lost.
  [[nodiscard]] std::optional<std::string> claim(const std::string& loop, std::size_t block,
                                                 const std::set<std::string>& lost) override;
  void keep(const std::string& loop, std::size_t block, const std::string& bytes) override;
  [[nodiscard]] double first_share() const override { return first_share_; }

 private:
  const CellStore& store_;
  bool takes_part_ = false;
  double first_share_ = 0.0;
};

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// The memory of layers while a network runs. Blocks of one layer become those of the next: pages that the system hands
// out anew cost as much as what is computed on them.

#include <cstddef>
#include <memory>
#include <vector>

#include "orthodrive/nets/network_graph.hpp"

namespace orthodrive {

/// Floats from cell to cell: vectors of eight, the last one filled up. What fills up is never read as a channel.
[[nodiscard]] constexpr int cell_stride_of(int channels) { return (channels + 7) / 8 * 8; }

/// Cells of a layer in memory, row by row, the channels of a cell side by side.
struct CellView {
  const float* first = nullptr;  ///< the cell at rows.first, cols.first
  CellRange rows, cols;
  std::size_t channels = 0, cell_stride = 0, row_stride = 0;
  [[nodiscard]] const float* at(int row, int col) const {
    return first + static_cast<std::size_t>(row - rows.first) * row_stride +
           static_cast<std::size_t>(col - cols.first) * cell_stride;
  }
};

/// A block of floats, not initialised.
class FloatBlock {
 public:
  FloatBlock() = default;
  explicit FloatBlock(std::size_t size);
  [[nodiscard]] float* data() const { return values_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(float* values) const;
  };
  std::unique_ptr<float, Free> values_;
  std::size_t size_ = 0;
};

/// Blocks that wait for their next use. One per thread.
class CellMemory {
 public:
  /// The smallest waiting block that fits and is not much too large, or a new one.
  [[nodiscard]] FloatBlock take(std::size_t size);
  void give_back(FloatBlock block);

 private:
  std::vector<FloatBlock> waiting_;
};

/// The output of a layer and the cells it holds.
struct Cells {
  FloatBlock values;
  CellRange rows, cols;
  int channels = 0, cell_stride = 0;
  [[nodiscard]] std::size_t row_floats() const {
    return static_cast<std::size_t>(cols.size()) * static_cast<std::size_t>(cell_stride);
  }
  [[nodiscard]] float* row(int row) const {
    return values.data() + static_cast<std::size_t>(row - rows.first) * row_floats();
  }
  [[nodiscard]] CellView view() const {
    return {values.data(), rows, cols, static_cast<std::size_t>(channels), static_cast<std::size_t>(cell_stride),
            row_floats()};
  }
};

}  // namespace orthodrive

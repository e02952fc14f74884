// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/cell_memory.hpp"

#include <new>
#include <utility>

namespace orthodrive {
namespace {

constexpr std::align_val_t alignment{64};   // a cache line, the widest vector
constexpr std::size_t largest_waste = 4;    // a block is not used for less than a quarter of it
constexpr std::size_t least_floats = 1024;  // smaller blocks do not pay

}  // namespace

void FloatBlock::Free::operator()(float* values) const { ::operator delete(values, alignment); }

FloatBlock::FloatBlock(std::size_t size)
    : values_(static_cast<float*>(::operator new(size * sizeof(float), alignment))), size_(size) {}

FloatBlock CellMemory::take(std::size_t size) {
  if (size < least_floats) size = least_floats;
  std::size_t best = waiting_.size();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (waiting_[i].size() < size || waiting_[i].size() > largest_waste * size) continue;
    if (best == waiting_.size() || waiting_[i].size() < waiting_[best].size()) best = i;
  }
  if (best == waiting_.size()) return FloatBlock(size);
  FloatBlock block = std::move(waiting_[best]);
  waiting_.erase(waiting_.begin() + static_cast<std::ptrdiff_t>(best));
  return block;
}

void CellMemory::give_back(FloatBlock block) {
  if (block.size() > 0) waiting_.push_back(std::move(block));
}

}  // namespace orthodrive

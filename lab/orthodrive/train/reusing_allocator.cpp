// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/reusing_allocator.hpp"

#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

namespace orthodrive {
namespace {

constexpr std::size_t worth_keeping = std::size_t{1} << 20;  // smaller ones the C library keeps itself
constexpr std::size_t alignment = 64;                        // as c10 aligns
constexpr std::size_t largest_waste = 4;                     // a block is not used for less than a quarter of it

/// Lies right before the data: oneDNN wants pointers that are their own context.
struct alignas(alignment) Block {
  std::size_t size = 0;  ///< of the data
  [[nodiscard]] void* data() { return this + 1; }
};

Block* block_of(void* data) { return static_cast<Block*>(data) - 1; }

struct FreeBlocks {
  std::vector<Block*> blocks;
  ~FreeBlocks() { clear(); }
  void clear() {
    for (Block* block : blocks) std::free(block);
    blocks.clear();
  }
  /// The smallest that fits, or none.
  Block* take(std::size_t size) {
    std::size_t best = blocks.size();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (blocks[i]->size < size || blocks[i]->size > largest_waste * size) continue;
      if (best == blocks.size() || blocks[i]->size < blocks[best]->size) best = i;
    }
    if (best == blocks.size()) return nullptr;
    Block* block = blocks[best];
    blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(best));
    return block;
  }
};
thread_local FreeBlocks free_blocks;

Block* new_block(std::size_t size) {
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, sizeof(Block) + size) != 0) {
    free_blocks.clear();
    if (posix_memalign(&memory, alignment, sizeof(Block) + size) != 0) throw std::bad_alloc();
  }
  return new (memory) Block{size};
}

void release(void* data) {
  if (!data) return;
  Block* block = block_of(data);
  if (block->size < worth_keeping) {
    std::free(block);
  } else {
    free_blocks.blocks.push_back(block);
  }
}

c10::DataPtr take_block(std::size_t size) {
  Block* block = size < worth_keeping ? nullptr : free_blocks.take(size);
  if (!block) block = new_block(size);
  return {block->data(), block->data(), &release, c10::Device(c10::DeviceType::CPU)};
}

/// Without `override`: allocate() is const up to libtorch 2.2 and not after it, copy_data() exists since then only.
class ReusingAllocator final : public c10::Allocator {
 public:
  // NOLINTNEXTLINE(modernize-use-override): of libtorch up to 2.2 only
  c10::DataPtr allocate(std::size_t size) const { return take_block(size); }
  c10::DataPtr allocate(std::size_t size) { return take_block(size); }
  void copy_data(void* to, const void* from, std::size_t size) const { std::memcpy(to, from, size); }
  c10::DeleterFnPtr raw_deleter() const override { return &release; }
};

}  // namespace

ReuseTensorMemory::ReuseTensorMemory() : before_(c10::GetAllocator(c10::DeviceType::CPU)) {
  static ReusingAllocator allocator;  // tensors may outlive this object
  c10::SetAllocator(c10::DeviceType::CPU, &allocator);
}

ReuseTensorMemory::~ReuseTensorMemory() {
  c10::SetAllocator(c10::DeviceType::CPU, before_);
  free_blocks.clear();
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// A vector for tables that are read at random: in pages of 2 MB where Linux grants them. A page of 4 KB costs a walk
// through the page tables for nearly every access to a table of many megabytes, as much as the access itself.

#include <cstddef>
#include <limits>
#include <new>
#include <vector>

namespace roadquery {

/// Memory in whole large pages where `bytes` are half a page or more; else as operator new. Throws std::bad_alloc.
[[nodiscard]] void* allocate_large(std::size_t bytes, std::size_t alignment);
/// `bytes` and `alignment` as it was allocated with.
void free_large(void* memory, std::size_t bytes, std::size_t alignment) noexcept;

template <typename T>
struct LargeAllocator {
  using value_type = T;
  LargeAllocator() = default;
  template <typename U>
  LargeAllocator(const LargeAllocator<U>& /*other*/) {}  // NOLINT(google-explicit-constructor): as allocators are

  [[nodiscard]] T* allocate(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / 2 / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(allocate_large(count * sizeof(T), alignof(T)));
  }
  void deallocate(T* memory, std::size_t count) noexcept { free_large(memory, count * sizeof(T), alignof(T)); }
  friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace roadquery

#pragma once
// A vector for tables that are read at random: in pages of 2 MB where Linux grants them. A page of 4 KB costs a walk
// through the page tables for nearly every access to a table of many megabytes, as much as the access itself.

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace roadquery {

template <typename T>
struct LargeAllocator {
  using value_type = T;
  LargeAllocator() = default;
  template <typename U>
  LargeAllocator(const LargeAllocator<U>& /*other*/) {}  // NOLINT(google-explicit-constructor): as allocators are

  static constexpr std::size_t page_bytes = std::size_t{1} << 21;

  [[nodiscard]] T* allocate(std::size_t count) {
    const std::size_t bytes = (count * sizeof(T) + page_bytes - 1) / page_bytes * page_bytes;
    if (count > bytes / sizeof(T)) throw std::bad_array_new_length();
    if (2 * count * sizeof(T) < page_bytes)
      return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{alignof(T)}));
    void* memory = ::operator new (bytes, std::align_val_t{page_bytes});
#if defined(__linux__)
    (void)madvise(memory, bytes, MADV_HUGEPAGE);  // a wish
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) noexcept {
    const bool is_small = 2 * count * sizeof(T) < page_bytes;
    ::operator delete (memory, std::align_val_t{is_small ? alignof(T) : page_bytes});
  }
  friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace roadquery

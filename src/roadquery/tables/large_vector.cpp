// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/large_vector.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace roadquery {
namespace {

constexpr std::size_t page_bytes = std::size_t{1} << 21;

bool is_large(std::size_t bytes) { return bytes >= page_bytes / 2; }

}  // namespace

void* allocate_large(std::size_t bytes, std::size_t alignment) {
  if (!is_large(bytes)) return ::operator new (bytes, std::align_val_t{alignment});
  const std::size_t whole = (bytes + page_bytes - 1) / page_bytes * page_bytes;
  void* memory = ::operator new (whole, std::align_val_t{page_bytes});
#if defined(__linux__)
  (void)madvise(memory, whole, MADV_HUGEPAGE);  // a wish
#endif
  return memory;
}

void free_large(void* memory, std::size_t bytes, std::size_t alignment) noexcept {
  ::operator delete (memory, std::align_val_t{is_large(bytes) ? page_bytes : alignment});
}

}  // namespace roadquery

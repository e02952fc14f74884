// SPDX-License-Identifier: Apache-2.0
#pragma once
// Large tensors of one layer become those of the next. The C library gives blocks of this size back to the system
// when they are freed, and getting fresh zeroed pages took half the time of a prediction.

#include <c10/core/Allocator.h>

namespace orthodrive {

/// While it lives, ATen keeps freed blocks for the thread that freed them; they go when that thread ends, those of the
/// constructing thread with the object. One at a time.
class ReuseTensorMemory {
 public:
  ReuseTensorMemory();
  ~ReuseTensorMemory();
  ReuseTensorMemory(const ReuseTensorMemory&) = delete;
  ReuseTensorMemory& operator=(const ReuseTensorMemory&) = delete;

 private:
  c10::Allocator* before_;
};

}  // namespace orthodrive

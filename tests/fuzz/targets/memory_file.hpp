// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bytes as a file that readers open by name, without a disk.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

namespace fuzz {

class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("input", 0)), path_("/proc/self/fd/" + std::to_string(descriptor_)) {
    if (descriptor_ < 0) std::abort();
  }
  /// The name of the file with these bytes in it.
  const std::string& with(const std::uint8_t* data, std::size_t size) {
    if (ftruncate(descriptor_, 0) != 0 || pwrite(descriptor_, data, size, 0) != static_cast<ssize_t>(size))
      std::abort();
    return path_;
  }

 private:
  int descriptor_;
  std::string path_;
};

/// What a reader says of a bad file is one line.
inline void expect_one_line(const char* what) {
  const std::string text = what;
  if (text.empty() || text.find('\n') != std::string::npos) std::abort();
}

}  // namespace fuzz

// SPDX-License-Identifier: Apache-2.0
#pragma once
// One process at a time writes into an output folder.

#include <filesystem>
#include <optional>
#include <string>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/monitor.hpp"

namespace orthodrive {

/// Another process has it.
struct FolderInUse : Error {
  using Error::Error;
};

/// Holds FILE (with host and process id of its holder) by flock while it lives, and removes it then. The system lets go
/// of it when the process is killed. Throws FolderInUse that names the holder when another process has it. Where the
/// file system knows no flock, a living process on the same host is refused; one on another host cannot be seen, which
/// the monitor is told.
class OutputLock {
 public:
  explicit OutputLock(std::filesystem::path file, Monitor* monitor = nullptr);
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  /// Whether the file system keeps all others out.
  [[nodiscard]] bool is_certain() const { return certain_; }
  /// Whether a process has the lock now; nothing: the file system cannot tell.
  [[nodiscard]] static std::optional<bool> is_held(const std::filesystem::path& file);
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  void write_holder() const;

  std::filesystem::path file_;
  int descriptor_ = -1;
  bool certain_ = true;
};

}  // namespace orthodrive

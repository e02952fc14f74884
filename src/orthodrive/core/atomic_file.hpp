// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writing that never leaves a half-written file: write beside the target, then rename, which is atomic (POSIX).

#include <filesystem>
#include <string_view>

namespace orthodrive {

/// A file (or folder) that is written under a temporary name beside its target and takes its place on commit().
/// Without commit() the temporary is removed and an earlier target stays untouched.
///   AtomicFile out("roads.gpkg"); write(out.path()); out.commit();
class AtomicFile {
 public:
  /// Creates the parent folder when it is missing. The temporary keeps the target's extension (GDAL looks at it).
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return temporary_; }
  void commit();

 private:
  std::filesystem::path target_, temporary_;
  bool committed_ = false;
};

/// Removes the temporaries that killed processes left in a folder (not below it). Those of this process count as left
/// behind, too: call it before the first AtomicFile. In a container a process often has the id of the one before it.
void remove_stale_atomic_files(const std::filesystem::path& folder);

/// Before a process ends without unwinding: removes the temporaries of all its AtomicFiles that are not committed, with
/// what libraries left beside them. From then on nothing can be made or committed: such a call waits forever.
void remove_own_atomic_files();

/// Writes text to a file through AtomicFile. Throws Error naming the file when the disk is full or not writable.
void write_text_file(const std::filesystem::path& target, std::string_view text);

}  // namespace orthodrive

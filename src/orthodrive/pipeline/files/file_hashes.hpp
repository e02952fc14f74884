// SPDX-License-Identifier: Apache-2.0
#pragma once
// Content hashes of files that are not read again as long as they are the same by size, times and inode.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace orthodrive {

/// What tells that a file was not written to. Times are those of its file system, in ns since 1970.
struct FileStamp {
  std::uint64_t size = 0, inode = 0;
  std::int64_t modified_ns = 0;  ///< anybody may set it
  std::int64_t changed_ns = 0;   ///< of the inode; only the system sets it
  bool operator==(const FileStamp&) const = default;
};
/// All zero for a file that is not there.
[[nodiscard]] FileStamp stamp_of(const std::filesystem::path& file);
/// Whether the file was written to so shortly before `now_ns` (or after it: clocks jump) that the next write could
/// leave the stamp as it is. File systems count time in steps of up to 2 s (FAT).
[[nodiscard]] bool is_racy(const FileStamp& stamp, std::int64_t now_ns);
[[nodiscard]] std::int64_t now_ns();

/// Hashes with the stamps they belong to, kept in a file between runs. The rule is that of git's index: a stamp is
/// trusted only when it was not racy as the content was read.
class FileHashes {
 public:
  /// Reads what an earlier run kept; a missing or damaged file is an empty one.
  explicit FileHashes(std::filesystem::path kept_in);
  /// Of a file's content, or of the names and contents of all files in a folder. Throws InputError when a file cannot
  /// be read.
  [[nodiscard]] std::string hash(const std::filesystem::path& path);
  /// Keeps what this run asked for, for the next.
  void keep() const;

 private:
  struct Known {
    FileStamp stamp;
    std::string hash;
    bool asked = false;  ///< in this run
  };
  std::string hash_of_file(const std::filesystem::path& file);

  std::filesystem::path kept_in_;
  std::map<std::string, Known> known_;  ///< by absolute path
};

}  // namespace orthodrive

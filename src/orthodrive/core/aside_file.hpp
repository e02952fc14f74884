#pragma once
// Writing that never leaves a half-written file: write aside, then rename.

#include <filesystem>
#include <string_view>

namespace orthodrive {

/// A file (or folder) that is written under a temporary name beside its target and takes its place on commit().
/// Without commit() the temporary is removed and an earlier target stays untouched.
///   AsideFile out("roads.gpkg"); write(out.path()); out.commit();
class AsideFile {
 public:
  /// Creates the parent folder when it is missing. The temporary keeps the target's extension (GDAL looks at it).
  explicit AsideFile(std::filesystem::path target);
  ~AsideFile();
  AsideFile(const AsideFile&) = delete;
  AsideFile& operator=(const AsideFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return aside_; }
  void commit();

 private:
  std::filesystem::path target_, aside_;
  bool committed_ = false;
};

/// Removes what killed processes left aside in a folder (not below it).
void remove_stale_asides(const std::filesystem::path& folder);

/// Writes text to a file through AsideFile. Throws Error naming the file when the disk is full or not writable.
void write_text_file(const std::filesystem::path& target, std::string_view text);

}  // namespace orthodrive

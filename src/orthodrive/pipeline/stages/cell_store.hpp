// SPDX-License-Identifier: Apache-2.0
#pragma once
// What processes of one or several machines leave of a stage's cells: DIR/.orthodrive/cells/STAGE-KEY/CELL/. The files
// are the truth: a cell is there or not, whoever made it, and however often.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace orthodrive {

class CellStore {
 public:
  /// `key`: of the stage's record (stage_cache.hpp): cells of other inputs are never taken.
  CellStore(const std::filesystem::path& out_dir, const std::string& stage, const std::string& key);

  /// Bytes of a cell; nothing when nobody has made it. Throws InputError when they are damaged.
  [[nodiscard]] std::optional<std::string> load(std::size_t cell) const;
  /// Files that were left with it, as CellFolder::folder() held them.
  [[nodiscard]] std::filesystem::path folder(std::size_t cell) const;
  /// Nobody has left anything, so that nothing has to be looked for.
  [[nodiscard]] bool empty() const { return !std::filesystem::exists(folder_); }
  [[nodiscard]] bool has(std::size_t cell) const;
  /// Where its cells lie.
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  /// Makes the folder: processes may now leave cells.
  void open() const;
  /// Cells of a part of the stage, beside its own. `name`: a plain word.
  [[nodiscard]] CellStore part(const std::string& name) const { return CellStore(folder_ / name); }
  /// Host and number of this process, as no other one has them.
  [[nodiscard]] static const std::string& this_process();
  /// Cells of all keys of a stage; for when its result is complete.
  static void remove(const std::filesystem::path& out_dir, const std::string& stage);
  /// Of all stages, with what lost processes left.
  static void remove_all(const std::filesystem::path& out_dir);

 private:
  friend class CellFolder;
  explicit CellStore(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
};

/// A cell while it is made, in a folder that no other process uses. Without commit() it goes, and nothing is left.
class CellFolder {
 public:
  CellFolder(const CellStore& store, std::size_t cell);
  ~CellFolder();
  CellFolder(const CellFolder&) = delete;
  /// For files that belong to the cell.
  [[nodiscard]] const std::filesystem::path& folder() const { return aside_; }
  /// Takes its place with all its files, unless another process was first: both are the same. Throws Error when the
  /// disk is full.
  void commit(const std::string& bytes);

 private:
  std::filesystem::path target_, aside_;
};

}  // namespace orthodrive

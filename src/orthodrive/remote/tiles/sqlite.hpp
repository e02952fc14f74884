// SPDX-License-Identifier: Apache-2.0
#pragma once
// SQLite's C interface as values. Internal to remote.

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace orthodrive::remote {

class Statement;

class Database {
 public:
  enum class Mode { read, write };
  Database(std::filesystem::path file, Mode mode);
  void run(const char* sql) const;
  [[nodiscard]] Statement prepare(const char* sql) const;
  /// Throws the Error or InputError that a result code stands for.
  [[noreturn]] void fail(int code) const;
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  struct Close {
    void operator()(sqlite3* db) const { sqlite3_close_v2(db); }
  };
  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> db_;
};

/// Parameters are bound from 1, columns read from 0, as SQLite has them.
class Statement {
 public:
  Statement(const Database& database, sqlite3_stmt* statement) : database_(&database), statement_(statement) {}
  Statement& bind(int index, std::int64_t value);
  Statement& bind_text(int index, std::string_view value);
  Statement& bind_blob(int index, std::string_view value);
  /// Whether there is a row.
  bool step();
  /// Steps a statement without rows, and makes it ready for the next.
  void run();
  void reset();
  [[nodiscard]] std::int64_t integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  [[nodiscard]] std::string text(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* s) const { sqlite3_finalize(s); }
  };
  const Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace orthodrive::remote

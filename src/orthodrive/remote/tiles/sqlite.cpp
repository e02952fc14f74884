// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/sqlite.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive::remote {

Database::Database(std::filesystem::path file, Mode mode) : file_(std::move(file)) {
  sqlite3* raw = nullptr;
  const int flags = mode == Mode::read ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  const int code = sqlite3_open_v2(file_.c_str(), &raw, flags, nullptr);
  db_.reset(raw);
  if (code != SQLITE_OK) fail(code);
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, 64 << 20);
  // A schema of a file of others cannot call functions with effects.
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
}

void Database::fail(int code) const {
  const std::string said = printable(db_ ? sqlite3_errmsg(db_.get()) : sqlite3_errstr(code));
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw Error(fmt::format("{}: another process fetches into it; wait for that one", file_.string()));
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:
      throw InputError(file_.string(), fmt::format("is damaged or no store of tiles ({}); remove it", said));
    default:
      throw Error(
          fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", file_.string(), said));
  }
}

void Database::run(const char* sql) const {
  if (const int code = sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr); code != SQLITE_OK) fail(code);
}

Statement Database::prepare(const char* sql) const {
  sqlite3_stmt* raw = nullptr;
  if (const int code = sqlite3_prepare_v2(db_.get(), sql, -1, &raw, nullptr); code != SQLITE_OK) fail(code);
  return {*this, raw};
}

Statement& Statement::bind(int index, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), index, value);
  return *this;
}
Statement& Statement::bind_text(int index, std::string_view value) {
  sqlite3_bind_text(statement_.get(), index, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  return *this;
}
Statement& Statement::bind_blob(int index, std::string_view value) {
  sqlite3_bind_blob(statement_.get(), index, value.data(), static_cast<int>(value.size()), SQLITE_TRANSIENT);
  return *this;
}
bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) database_->fail(code);
  return false;
}
void Statement::run() {
  step();
  reset();
}
void Statement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
}
std::string Statement::text(int column) const {
  const void* bytes = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return bytes ? std::string(static_cast<const char*>(bytes), static_cast<std::size_t>(size)) : std::string();
}

}  // namespace orthodrive::remote

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/atomic_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
constexpr std::string_view partial_mark = ".partial-";

/// Temporaries that are not committed, for a process that has to end at once.
struct Unfinished {
  std::mutex mutex;  ///< held while a temporary takes its place, so that no end comes between two renames
  std::multiset<fs::path> temporaries;
};
Unfinished& unfinished() {
  static Unfinished& all = *new Unfinished;  // outlives every other static
  return all;
}

/// Both exist and change places in one step, where the system and the file system can do that.
bool exchange(const fs::path& a, const fs::path& b) {
  return renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

/// rename() does not replace a folder that is not empty.
void replace_folder(const fs::path& temporary, const fs::path& target, std::error_code& failed) {
  std::error_code ignored;
  if (exchange(temporary, target)) {
    fs::remove_all(temporary, ignored);
    return;
  }
  // Between the two renames the target is missing: who is killed there makes it again. The name is that of a
  // temporary, so that a later run removes it.
  const fs::path old = target.parent_path() / ("." + target.filename().string() + ".old" + std::string(partial_mark) +
                                               std::to_string(getpid()));
  fs::remove_all(old, ignored);
  fs::rename(target, old, failed);
  if (!failed) fs::rename(temporary, target, failed);
  if (failed)
    fs::rename(old, target, ignored);
  else
    fs::remove_all(old, ignored);
}

/// Files and folders of a folder whose name begins so.
std::vector<fs::path> entries_with(const fs::path& folder, const std::string& prefix) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().filename().string().starts_with(prefix)) found.push_back(entry.path());
  return found;
}
}  // namespace

AtomicFile::AtomicFile(fs::path target) : target_(std::move(target)) {
  const fs::path parent = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  std::error_code failed;
  fs::create_directories(parent, failed);
  if (failed) throw Error(parent.string() + ": cannot be created (" + failed.message() + ")");
  // The process id keeps two runs into one folder apart; the extension stays last for drivers that look at it.
  temporary_ = parent / ("." + target_.stem().string() + std::string(partial_mark) + std::to_string(getpid()) +
                         target_.extension().string());
  const std::lock_guard lock(unfinished().mutex);
  fs::remove_all(temporary_, failed);
  unfinished().temporaries.insert(temporary_);
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
  const std::lock_guard lock(unfinished().mutex);
  unfinished().temporaries.erase(unfinished().temporaries.find(temporary_));
}

void AtomicFile::commit() {
  const std::lock_guard lock(unfinished().mutex);
  std::error_code failed;
  if (fs::is_directory(target_))
    replace_folder(temporary_, target_, failed);
  else
    fs::rename(temporary_, target_, failed);
  if (failed) throw Error(target_.string() + ": cannot be written (" + failed.message() + ")");
  committed_ = true;
  unfinished().temporaries.erase(unfinished().temporaries.find(temporary_));
}

void remove_stale_atomic_files(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> stale;
  for (const fs::path& path : entries_with(folder, ".")) {
    const std::string name = path.filename().string();
    const auto mark = name.find(partial_mark);
    if (mark == std::string::npos) continue;
    const pid_t owner = static_cast<pid_t>(std::strtol(name.c_str() + mark + partial_mark.size(), nullptr, 10));
    if (owner > 0 && (owner == getpid() || (kill(owner, 0) != 0 && errno == ESRCH))) stale.push_back(path);
  }
  for (const fs::path& path : stale) fs::remove_all(path, ignored);
}

void remove_own_atomic_files() {
  unfinished().mutex.lock();  // and never unlocked: the process is over
  std::error_code ignored;
  for (const fs::path& temporary : unfinished().temporaries)
    for (const fs::path& path : entries_with(temporary.parent_path(), temporary.filename().string())) {
      // Threads go on: under another name they do not find the folder to put more into it.
      fs::path gone = path;
      gone += ".gone";
      fs::rename(path, gone, ignored);
      fs::remove_all(fs::exists(gone, ignored) ? gone : path, ignored);
    }
}

void write_text_file(const fs::path& target, std::string_view text) {
  AtomicFile out(target);
  {
    std::ofstream stream(out.path(), std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream) throw Error(target.string() + ": cannot be written, is the disk full or the folder read-only?");
  }
  out.commit();
}

}  // namespace orthodrive

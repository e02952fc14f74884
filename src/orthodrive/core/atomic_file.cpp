#include "orthodrive/core/atomic_file.hpp"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

constexpr std::string_view partial_mark = ".partial-";

AtomicFile::AtomicFile(fs::path target) : target_(std::move(target)) {
  const fs::path parent = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  std::error_code failed;
  fs::create_directories(parent, failed);
  if (failed) throw Error(parent.string() + ": cannot be created (" + failed.message() + ")");
  // The process id keeps two runs into one folder apart; the extension stays last for drivers that look at it.
  temporary_ = parent / ("." + target_.stem().string() + std::string(partial_mark) + std::to_string(getpid()) +
                         target_.extension().string());
  fs::remove_all(temporary_, failed);
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  std::error_code ignored;
  fs::remove_all(temporary_, ignored);
}

void AtomicFile::commit() {
  std::error_code failed;
  if (fs::is_directory(target_)) {  // rename() does not replace a folder that is not empty
    fs::path old = target_;
    old += ".old-" + std::to_string(getpid());
    fs::rename(target_, old, failed);
    if (!failed) fs::rename(temporary_, target_, failed);
    std::error_code ignored;
    if (failed)
      fs::rename(old, target_, ignored);
    else
      fs::remove_all(old, ignored);
  } else {
    fs::rename(temporary_, target_, failed);
  }
  if (failed) throw Error(target_.string() + ": cannot be written (" + failed.message() + ")");
  committed_ = true;
}

void remove_stale_atomic_files(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> stale;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const auto mark = name.find(partial_mark);
    if (name.front() != '.' || mark == std::string::npos) continue;
    const pid_t owner = static_cast<pid_t>(std::atol(name.c_str() + mark + partial_mark.size()));
    if (owner > 0 && kill(owner, 0) != 0 && errno == ESRCH) stale.push_back(entry.path());
  }
  for (const fs::path& path : stale) fs::remove_all(path, ignored);
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

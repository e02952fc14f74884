// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/output_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
struct Holder {
  std::string host;
  long pid = 0;  ///< 0: the file names none
};

std::string this_host() {
  std::array<char, 256> name{};
  gethostname(name.data(), name.size() - 1);
  return name.data();
}

Holder read_holder(const fs::path& file) {
  Holder holder;
  std::ifstream in(file);
  in >> holder.host >> holder.pid;
  return in ? holder : Holder{};
}

[[noreturn]] void refuse(const fs::path& file, const Holder& holder) {
  const std::string who =
      holder.pid == 0 ? std::string("another process") : fmt::format("process {} on {}", holder.pid, holder.host);
  const fs::path folder = file.parent_path().parent_path();
  throw FolderInUse(
      fmt::format("{}: {} works in this folder; wait for its end or take another folder", folder.string(), who));
}

/// Another run may have removed the file between our open() and our lock: then we hold a file that nobody sees.
bool is_still_there(int descriptor, const fs::path& file) {
  struct stat ours {
  }, theirs{};
  return fstat(descriptor, &ours) == 0 && stat(file.c_str(), &theirs) == 0 && ours.st_ino == theirs.st_ino &&
         ours.st_dev == theirs.st_dev;
}
}  // namespace

OutputLock::OutputLock(fs::path file, Monitor* monitor) : file_(std::move(file)) {
  std::error_code failed;
  fs::create_directories(file_.parent_path(), failed);
  const auto cannot = [&](int error) {
    return Error(fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", file_.string(),
                             std::strerror(error)));
  };
  if (failed) throw cannot(failed.value());
  while (true) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw cannot(errno);
    if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) {
      if (is_still_there(descriptor_, file_)) break;
      close(descriptor_);
      continue;
    }
    const int error = errno;
    const Holder holder = read_holder(file_);
    if (error == EINTR) {
      close(descriptor_);
      continue;
    }
    if (error == EWOULDBLOCK) {
      close(descriptor_);
      refuse(file_, holder);
    }
    // No locks here (ENOLCK, EOPNOTSUPP, EINVAL, ENOSYS): go by what the file says.
    if (holder.pid > 0 && holder.host == this_host() && holder.pid != getpid() &&
        (kill(static_cast<pid_t>(holder.pid), 0) == 0 || errno == EPERM)) {
      close(descriptor_);
      refuse(file_, holder);
    }
    if (holder.pid > 0 && holder.host != this_host() && monitor)
      monitor->info(
          fmt::format("{}: this file system has no locks, and process {} on {} did not end well or still "
                      "builds here; two at once would spoil the result",
                      file_.string(), holder.pid, holder.host));
    certain_ = false;
    break;
  }
  write_holder();
}

std::optional<bool> OutputLock::is_held(const fs::path& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno == ENOENT ? std::optional(false) : std::nullopt;
  const bool taken = flock(descriptor, LOCK_SH | LOCK_NB) == 0;
  const int error = errno;
  close(descriptor);
  if (taken || error == EWOULDBLOCK) return !taken;
  return std::nullopt;
}

void OutputLock::write_holder() const {
  const std::string text = fmt::format("{} {}\n", this_host(), getpid());
  const bool written = ftruncate(descriptor_, 0) == 0 &&
                       pwrite(descriptor_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
  if (!written) {
    const int error = errno;
    std::error_code ignored;
    fs::remove(file_, ignored);
    close(descriptor_);
    throw Error(fmt::format("{}: cannot be written ({}); is the disk full or the folder read-only?", file_.string(),
                            std::strerror(error)));
  }
}

OutputLock::~OutputLock() {
  std::error_code ignored;
  fs::remove(file_, ignored);  // while it is ours
  close(descriptor_);
}

}  // namespace orthodrive

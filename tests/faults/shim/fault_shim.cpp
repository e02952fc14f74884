// SPDX-License-Identifier: Apache-2.0
// Loaded before the C library (LD_PRELOAD): makes calls on chosen files fail, and lists what is opened. By environment:
//   SHIM_LOG=FILE    a line per file that was opened: "r PATH" or "w PATH"
//   SHIM_FILE=TEXT   calls on files whose path holds the text fail ...
//   SHIM_CALL=NAME   ... of this kind: open (for writing, also mkdir), write, close, rename
//   SHIM_ERRNO=N     ... with this error (ENOSPC)
//   SHIM_BYTES=N     ... write: after so many bytes of such files (0)
//   SHIM_NO_FLOCK=1  the file system knows no locks
// fwrite of the C library does not come through write(): it is a call of its own here.

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {
template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

const char* setting(const char* name) { return std::getenv(name); }

bool is_chosen(const char* path) {
  const char* text = setting("SHIM_FILE");
  return text && path && std::strstr(path, text);
}
bool is_call(const char* name) {
  const char* call = setting("SHIM_CALL");
  return call && std::strcmp(call, name) == 0;
}
bool fails(const char* path, const char* call) {
  if (!is_call(call) || !is_chosen(path)) return false;
  const char* error = setting("SHIM_ERRNO");
  errno = error ? static_cast<int>(std::strtol(error, nullptr, 10)) : ENOSPC;
  return true;
}

bool path_of(int descriptor, char* path) {
  char link[64];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t size = readlink(link, path, PATH_MAX - 1);
  path[size > 0 ? size : 0] = '\0';
  return size > 0;
}

std::atomic<long> written{0};
/// Whether a write of so many bytes to the descriptor finds the disk full.
bool is_full(int descriptor, size_t bytes) {
  if (!is_call("write")) return false;
  const int before = errno;
  char path[PATH_MAX];
  if (!path_of(descriptor, path) || !fails(path, "write")) {
    errno = before;
    return false;
  }
  const char* most = setting("SHIM_BYTES");
  const long in_all = written += static_cast<long>(bytes);
  if (in_all > (most ? std::strtol(most, nullptr, 10) : 0)) return true;
  errno = before;
  return false;
}
bool fails_at_close(int descriptor) {
  if (!is_call("close")) return false;
  char path[PATH_MAX];
  return path_of(descriptor, path) && fails(path, "close");
}

void note(const char* path, bool writes) {
  const char* log = setting("SHIM_LOG");
  if (!log) return;
  const int before = errno;
  char line[PATH_MAX + 4];
  const int size = std::snprintf(line, sizeof line, "%c %s\n", writes ? 'w' : 'r', path);
  const long descriptor = syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (descriptor >= 0) {
    syscall(SYS_write, descriptor, line, size);
    syscall(SYS_close, descriptor);
  }
  errno = before;
}

bool writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY; }
bool writes(const char* mode) { return std::strpbrk(mode, "wa+") != nullptr; }

template <typename Open>
int open_noted(const char* path, int flags, const Open& open) {
  if (writes(flags) && fails(path, "open")) return -1;
  const int descriptor = open();
  if (descriptor >= 0) note(path, writes(flags));
  return descriptor;
}
FILE* open_stream(const char* name, const char* path, const char* mode) {
  if (writes(mode) && fails(path, "open")) return nullptr;
  FILE* file = next<FILE*(const char*, const char*)>(name)(path, mode);
  if (file) note(path, writes(mode));
  return file;
}
}  // namespace

#define MODE_OF(flags)                                  \
  mode_t mode = 0;                                      \
  if ((flags) & (O_CREAT | O_TMPFILE)) {                \
    va_list list;                                       \
    va_start(list, flags);                              \
    mode = static_cast<mode_t>(va_arg(list, unsigned)); \
    va_end(list);                                       \
  }

extern "C" {
int open(const char* path, int flags, ...) {
  MODE_OF(flags)
  return open_noted(path, flags, [&] { return next<int(const char*, int, ...)>("open")(path, flags, mode); });
}
int open64(const char* path, int flags, ...) {
  MODE_OF(flags)
  return open_noted(path, flags, [&] { return next<int(const char*, int, ...)>("open64")(path, flags, mode); });
}
int openat(int folder, const char* path, int flags, ...) {
  MODE_OF(flags)
  return open_noted(path, flags,
                    [&] { return next<int(int, const char*, int, ...)>("openat")(folder, path, flags, mode); });
}
int openat64(int folder, const char* path, int flags, ...) {
  MODE_OF(flags)
  return open_noted(path, flags,
                    [&] { return next<int(int, const char*, int, ...)>("openat64")(folder, path, flags, mode); });
}
FILE* fopen(const char* path, const char* mode) { return open_stream("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return open_stream("fopen64", path, mode); }

ssize_t write(int descriptor, const void* data, size_t size) {
  if (is_full(descriptor, size)) return -1;
  return next<ssize_t(int, const void*, size_t)>("write")(descriptor, data, size);
}
ssize_t writev(int descriptor, const iovec* parts, int count) {
  size_t size = 0;
  for (int i = 0; i < count; ++i) size += parts[i].iov_len;
  if (is_full(descriptor, size)) return -1;
  return next<ssize_t(int, const iovec*, int)>("writev")(descriptor, parts, count);
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  if (is_full(descriptor, size)) return -1;
  return next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(descriptor, data, size, at);
}
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t at) {
  if (is_full(descriptor, size)) return -1;
  return next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(descriptor, data, size, at);
}
size_t fwrite(const void* data, size_t size, size_t count, FILE* file) {
  if (is_call("write") && is_full(fileno(file), size * count)) return 0;
  return next<size_t(const void*, size_t, size_t, FILE*)>("fwrite")(data, size, count, file);
}
int close(int descriptor) {
  const bool failed = fails_at_close(descriptor);
  const int error = errno;
  const int result = next<int(int)>("close")(descriptor);
  if (!failed) return result;
  errno = error;
  return -1;
}
int fclose(FILE* file) {
  const bool failed = fails_at_close(fileno(file));
  const int error = errno;
  const int result = next<int(FILE*)>("fclose")(file);
  if (!failed) return result;
  errno = error;
  return EOF;
}
int rename(const char* from, const char* to) {
  if (fails(from, "rename") || fails(to, "rename")) return -1;
  return next<int(const char*, const char*)>("rename")(from, to);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
  if (fails(from, "rename") || fails(to, "rename")) return -1;
  return next<int(int, const char*, int, const char*, unsigned)>("renameat2")(from_folder, from, to_folder, to, flags);
}
int mkdir(const char* path, mode_t mode) {
  if (fails(path, "open")) return -1;
  return next<int(const char*, mode_t)>("mkdir")(path, mode);
}
int flock(int descriptor, int operation) {
  if (setting("SHIM_NO_FLOCK")) {
    errno = ENOLCK;
    return -1;
  }
  return next<int(int, int)>("flock")(descriptor, operation);
}
}

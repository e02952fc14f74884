// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/files/file_hashes.hpp"

#include <sys/stat.h>
#include <time.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/hash.hpp"

namespace orthodrive {
namespace fs = std::filesystem;

namespace {
std::int64_t in_ns(const timespec& time) { return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec; }
}  // namespace

FileStamp stamp_of(const fs::path& file) {
  struct stat s {};
  if (stat(file.c_str(), &s) != 0) return {};
  return {.size = static_cast<std::uint64_t>(s.st_size),
          .inode = s.st_ino,
          .modified_ns = in_ns(s.st_mtim),
          .changed_ns = in_ns(s.st_ctim)};
}

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return in_ns(now);
}

bool is_racy(const FileStamp& stamp, std::int64_t now_ns) {
  constexpr std::int64_t step_ns = 2'000'000'000;
  return std::max(stamp.modified_ns, stamp.changed_ns) > now_ns - step_ns;
}

FileHashes::FileHashes(fs::path kept_in) : kept_in_(std::move(kept_in)) {
  std::ifstream in(kept_in_);
  if (!in) return;
  const nlohmann::json kept = nlohmann::json::parse(in, nullptr, false);
  try {
    for (const auto& [file, k] : kept.items())
      known_[file] = {{k.at(0).get<std::uint64_t>(), k.at(1).get<std::uint64_t>(), k.at(2).get<std::int64_t>(),
                       k.at(3).get<std::int64_t>()},
                      k.at(4).get<std::string>()};
  } catch (const nlohmann::json::exception&) {
    known_.clear();  // all is read again
  }
}

std::string FileHashes::hash_of_file(const fs::path& file) {
  const std::string name = fs::absolute(file).lexically_normal().string();
  const FileStamp before = stamp_of(file);
  const auto found = known_.find(name);
  if (found != known_.end() && found->second.stamp == before) {
    found->second.asked = true;
    return found->second.hash;
  }
  const std::int64_t start_ns = now_ns();
  std::string hash = hash_file(file);
  if (!is_racy(before, start_ns) && stamp_of(file) == before)
    known_[name] = {before, hash, true};
  else
    known_.erase(name);
  return hash;
}

std::string FileHashes::hash(const fs::path& path) {
  if (!fs::is_directory(path)) return hash_of_file(path);
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string all;
  for (const fs::path& file : files) all += fs::relative(file, path).string() + "\n" + hash_of_file(file) + "\n";
  return hash_bytes(all);
}

void FileHashes::keep() const {
  nlohmann::json kept = nlohmann::json::object();
  for (const auto& [file, k] : known_)
    if (k.asked)
      kept[file] =
          nlohmann::json::array({k.stamp.size, k.stamp.inode, k.stamp.modified_ns, k.stamp.changed_ns, k.hash});
  write_text_file(kept_in_, kept.dump(0) + "\n");
}

}  // namespace orthodrive

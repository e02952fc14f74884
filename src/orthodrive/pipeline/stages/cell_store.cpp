// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/cell_store.hpp"

#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

#include "orthodrive/core/atomic_file.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

constexpr const char* bytes_file = "cell.bin";
constexpr std::size_t hash_digits = 32, size_bytes = sizeof(std::uint64_t);

fs::path cells_folder(const fs::path& out_dir) { return out_dir / ".orthodrive" / "cells"; }

/// Hash and length of the bytes, then the bytes as zlib packs them.
std::string packed(const std::string& bytes) {
  std::string file = hash_bytes(bytes);
  const std::uint64_t size = bytes.size();
  file.append(reinterpret_cast<const char*>(&size), size_bytes);
  uLongf length = compressBound(static_cast<uLong>(size));
  const std::size_t head = file.size();
  file.resize(head + length);
  if (compress2(reinterpret_cast<Bytef*>(file.data() + head), &length, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(size), Z_BEST_SPEED) != Z_OK)
    throw Error("a cell cannot be packed: no memory");
  file.resize(head + length);
  return file;
}

std::string unpacked(const std::string& file, const std::string& name) {
  const auto damaged = [&] { return InputError(name, "is damaged; remove its folder and make the cell again"); };
  if (file.size() < hash_digits + size_bytes) throw damaged();
  std::uint64_t size = 0;
  std::memcpy(&size, file.data() + hash_digits, size_bytes);
  const std::size_t head = hash_digits + size_bytes;
  constexpr std::uint64_t most_times = 1032;  // that zlib makes bytes fewer
  if (size > most_times * (file.size() - head)) throw damaged();
  std::string bytes(size, '\0');
  auto length = static_cast<uLongf>(size);
  if (uncompress(reinterpret_cast<Bytef*>(bytes.data()), &length, reinterpret_cast<const Bytef*>(file.data() + head),
                 static_cast<uLong>(file.size() - head)) != Z_OK ||
      length != size || hash_bytes(bytes) != file.substr(0, hash_digits))
    throw damaged();
  return bytes;
}

/// Of each folder of this process.
std::string own_name() {
  static std::atomic<int> count{0};
  return fmt::format("{}-{}", CellStore::this_process(), count++);
}
}  // namespace

const std::string& CellStore::this_process() {
  static const std::string name = [] {
    std::array<char, 256> host{};
    (void)gethostname(host.data(), host.size() - 1);
    const auto began = std::chrono::system_clock::now().time_since_epoch();  // numbers of processes come again
    return fmt::format("{}-{}-{}", host.data(), getpid(),
                       std::chrono::duration_cast<std::chrono::milliseconds>(began).count());
  }();
  return name;
}

CellStore::CellStore(const fs::path& out_dir, const std::string& stage, const std::string& key)
    : folder_(cells_folder(out_dir) / fmt::format("{}-{}", stage, key.substr(0, 16))) {}

fs::path CellStore::folder(std::size_t cell) const { return folder_ / std::to_string(cell); }

std::optional<std::string> CellStore::load(std::size_t cell) const {
  const fs::path file = folder(cell) / bytes_file;
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  std::ostringstream text;
  text << in.rdbuf();
  return unpacked(std::move(text).str(), file.string());
}

bool CellStore::has(std::size_t cell) const { return fs::exists(folder(cell) / bytes_file); }

void CellStore::open() const {
  std::error_code failed;
  fs::create_directories(folder_, failed);
  if (failed) throw Error(fmt::format("{}: cannot be created ({})", folder_.string(), failed.message()));
}

void CellStore::remove(const fs::path& out_dir, const std::string& stage) {
  std::error_code ignored;
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(cells_folder(out_dir), ignored))
    if (entry.path().filename().string().starts_with(stage + "-")) folders.push_back(entry.path());
  for (const fs::path& folder : folders) fs::remove_all(folder, ignored);
  fs::remove(cells_folder(out_dir), ignored);  // when it is empty
}

void CellStore::remove_all(const fs::path& out_dir) {
  std::error_code ignored;
  fs::remove_all(cells_folder(out_dir), ignored);
}

CellFolder::CellFolder(const CellStore& store, std::size_t cell)
    : target_(store.folder(cell)), aside_(store.folder_ / fmt::format(".{}.{}", cell, own_name())) {
  std::error_code failed;
  fs::create_directories(aside_, failed);
  if (failed) throw Error(fmt::format("{}: cannot be created ({})", aside_.string(), failed.message()));
}

CellFolder::~CellFolder() {
  std::error_code ignored;
  fs::remove_all(aside_, ignored);
}

void CellFolder::commit(const std::string& bytes) {
  {
    std::ofstream out(aside_ / bytes_file, std::ios::binary);
    const std::string file = packed(bytes);
    out.write(file.data(), static_cast<std::streamsize>(file.size()));
    out.close();
    if (!out)
      throw Error(fmt::format("{}: cannot be written, is the disk full or the folder read-only?", target_.string()));
  }
  std::error_code failed;
  fs::rename(aside_, target_, failed);
  if (failed && !fs::exists(target_ / bytes_file))
    throw Error(fmt::format("{}: cannot be written ({})", target_.string(), failed.message()));
}

}  // namespace orthodrive

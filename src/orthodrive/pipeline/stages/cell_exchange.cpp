// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/stages/cell_exchange.hpp"

#include <fmt/format.h>

#include <condition_variable>
#include <fstream>
#include <sstream>
#include <thread>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/stop.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto sign_every = 1s, silence_of_the_lost = 10s;
constexpr auto shortest_exchange_pause = 5ms, longest_exchange_pause = 200ms;

fs::path sign_file(const CellStore& store, const std::string& process) {
  return store.folder().parent_path() / fmt::format("alive-{}", process);
}
}  // namespace

/// Counts in a file as long as it lives. It is beside the folders of the stages, which come and go.
class CellExchange::SignOfLife {
 public:
  explicit SignOfLife(fs::path file) : file_(std::move(file)) {
    thread_ = std::thread([this] {
      std::unique_lock lock(mutex_);
      for (int count = 0; !ends_; ++count) {
        std::ofstream(file_) << count << '\n';  // where it fails, others take this process for lost, and go on
        changed_.wait_for(lock, sign_every);
      }
    });
  }
  ~SignOfLife() {
    {
      const std::lock_guard lock(mutex_);
      ends_ = true;
    }
    changed_.notify_all();
    thread_.join();
    std::error_code ignored;
    fs::remove(file_, ignored);
  }

 private:
  fs::path file_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ends_ = false;
  std::thread thread_;
};

CellExchange::CellExchange(const CellStore& store) : store_(store) {}

CellExchange::CellExchange(const CellStore& store, Role role, double first_share)
    : store_(store),
      role_(role),
      first_share_(first_share),
      sign_(std::make_unique<SignOfLife>(sign_file(store, CellStore::this_process()))) {}

CellExchange::~CellExchange() = default;

std::optional<std::string> CellExchange::load(const std::string& loop, std::size_t block) const {
  return store_.part(loop).load(block);
}

std::optional<std::string> CellExchange::claim(const std::string& loop, std::size_t block) {
  if (!role_) return std::nullopt;
  const auto throw_if_made = [&] {
    // NOLINTNEXTLINE(bugprone-std-exception-baseclass): no error, so who catches errors must not see it
    if (role_ == Role::helps && store_.empty()) throw StageIsMade();
  };
  throw_if_made();
  const CellStore blocks = store_.part(loop);
  blocks.open();
  for (int before = 0;; ++before) {
    const fs::path link = blocks.folder() / fmt::format("{}.claim-{}", block, before);
    std::error_code failed;
    fs::create_symlink(CellStore::this_process(), link, failed);
    if (!failed) return std::nullopt;
    std::error_code unread;
    std::string maker = fs::read_symlink(link, unread).string();
    if (unread) throw_if_made();
    if (unread) throw Error(fmt::format("{}: cannot be written ({})", link.string(), failed.message()));
    const std::lock_guard lock(mutex_);
    if (!lost_.contains(maker)) return maker;
  }
}

std::set<std::string> CellExchange::lost_of(const std::set<std::string>& makers) {
  const auto now = std::chrono::steady_clock::now();
  std::set<std::string> lost;
  const std::lock_guard lock(mutex_);
  for (const std::string& maker : makers) {
    std::ostringstream sign;
    if (std::ifstream in(sign_file(store_, maker)); in) sign << in.rdbuf();
    const auto [seen, is_new] = seen_.try_emplace(maker, Seen{sign.str(), now});
    if (is_new || seen->second.sign != sign.str())
      seen->second = {sign.str(), now};
    else if (now - seen->second.since > silence_of_the_lost)
      lost.insert(maker);
  }
  lost_.insert(lost.begin(), lost.end());
  return lost;
}

void CellExchange::keep(const std::string& loop, std::size_t block, const std::string& bytes) {
  if (role_) CellFolder(store_.part(loop), block).commit(bytes);
}

std::optional<std::string> CellExchange::take(const std::string& loop, std::size_t block) {
  std::optional<std::string> bytes = load(loop, block);
  if (bytes || !role_) return bytes;
  std::chrono::milliseconds pause = shortest_exchange_pause;
  while (const std::optional<std::string> maker = claim(loop, block)) {
    throw_if_stopped();
    bytes = load(loop, block);
    if (bytes) return bytes;
    if (!lost_of({*maker}).empty()) continue;
    std::this_thread::sleep_for(pause);
    pause = std::min<std::chrono::milliseconds>(pause * 2, longest_exchange_pause);
  }
  return load(loop, block);  // made just before this process claimed it, or nothing
}

std::optional<std::size_t> CellExchange::next_cell(std::size_t count) {
  while (true) {
    std::size_t cell = 0;
    {
      const std::lock_guard lock(mutex_);
      if (looked_at_ == count) return std::nullopt;
      cell = count - ++looked_at_;
    }
    if (!store(cells).has(cell) && !claim(cells, cell)) return cell;
  }
}

}  // namespace orthodrive

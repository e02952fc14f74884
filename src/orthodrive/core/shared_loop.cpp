// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/shared_loop.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <vector>

#include "orthodrive/core/stop.hpp"

namespace orthodrive {
namespace {
constexpr std::chrono::milliseconds shortest_pause{5}, longest_pause{200};
constexpr std::size_t most_blocks = 128;  // a file each; few enough for slow disks, enough for tens of processes

/// The blocks of one loop, as this process sees them.
class Blocks {
 public:
  Blocks(const SharedLoop& loop, LoopExchange& exchange)
      : loop_(loop), exchange_(exchange), size_((loop.count + most_blocks - 1) / most_blocks) {}

  void run() {
    const std::size_t blocks = (loop_.count + size_ - 1) / size_;
    const auto first = static_cast<std::size_t>(exchange_.first_share() * static_cast<double>(blocks));
    std::vector<char> left(blocks, 0);  // made by others, not there yet
    parallel_for(
        blocks, loop_.threads,
        [&](std::size_t k) {
          const std::size_t block = (first + k) % blocks;
          left[block] = take_or_make(block) ? 0 : 1;
        },
        [&](std::size_t) { tell(); });
    std::vector<std::size_t> waiting;
    for (std::size_t block = 0; block < blocks; ++block)
      if (left[block]) waiting.push_back(block);
    wait_for(waiting);
  }

 private:
  bool take_or_make(std::size_t block) {
    if (const std::optional<std::string> bytes = exchange_.load(loop_.name, block)) {
      read(block, *bytes);
      return true;
    }
    if (std::optional<std::string> maker = exchange_.claim(loop_.name, block)) {
      const std::lock_guard lock(mutex_);
      makers_.insert(std::move(*maker));
      return false;
    }
    make(block);
    return true;
  }
  void wait_for(std::vector<std::size_t>& waiting) {
    auto pause = shortest_pause;
    while (!waiting.empty()) {
      throw_if_stopped();
      const std::size_t before = waiting.size();
      std::erase_if(waiting, [&](std::size_t block) {
        const std::optional<std::string> bytes = exchange_.load(loop_.name, block);
        if (bytes) read(block, *bytes);
        return bytes.has_value();
      });
      tell();
      if (waiting.size() < before) {
        pause = shortest_pause;
      } else if (const std::set<std::string> lost = exchange_.lost_of(makers_); !lost.empty()) {
        for (const std::string& maker : lost) makers_.erase(maker);
        std::erase_if(waiting, [&](std::size_t block) { return take_or_make(block); });
      } else {
        std::this_thread::sleep_for(pause);
        pause = std::min(pause * 2, longest_pause);
      }
    }
  }
  [[nodiscard]] std::pair<std::size_t, std::size_t> items_of(std::size_t block) const {
    return {block * size_, std::min((block + 1) * size_, loop_.count)};
  }
  void make(std::size_t block) {
    ByteWriter writer;
    const auto [first, end] = items_of(block);
    for (std::size_t i = first; i < end; ++i) {
      throw_if_stopped();
      loop_.make(i);
      loop_.write(writer, i);
    }
    exchange_.keep(loop_.name, block, writer.take());
    done_ += end - first;
  }
  void read(std::size_t block, const std::string& bytes) {
    ByteReader reader(bytes, loop_.name);
    const auto [first, end] = items_of(block);
    for (std::size_t i = first; i < end; ++i) loop_.read(reader, i);
    reader.finish();
    done_ += end - first;
  }
  void tell() {
    if (loop_.after_each) loop_.after_each(done_);
  }

  const SharedLoop& loop_;
  LoopExchange& exchange_;
  std::size_t size_;
  std::atomic<std::size_t> done_{0};
  std::mutex mutex_;
  std::set<std::string> makers_;  // of blocks that are waited for
};
}  // namespace

void share_loop(const SharedLoop& loop, LoopExchange& exchange) {
  if (loop.count > 0) Blocks(loop, exchange).run();
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Items that workers finish in any order, handed on in the order of their index, with few waiting.

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <utility>

#include "orthodrive/core/stop.hpp"

namespace orthodrive {

/// A worker waits for room before it makes item i, so that at most `ahead` items are being made or waiting. Indices
/// must be taken in ascending order (as parallel_for does): the next to deliver is then always being made, and nobody
/// waits for ever. Whoever fails to make its item must call stop().
template <typename Item>
class OrderedDelivery {
 public:
  OrderedDelivery(std::size_t ahead, std::function<void(std::size_t, const Item&)> deliver)
      : ahead_(ahead), deliver_(std::move(deliver)) {}

  /// False when the delivery was stopped, or the process is to end (whoever was to make the next item may be gone).
  [[nodiscard]] bool wait_for_room(std::size_t index) {
    std::unique_lock lock(mutex_);
    while (!room_.wait_for(lock, std::chrono::milliseconds(100), [&] { return stopped_ || index < next_ + ahead_; }))
      if (stop_requested()) return false;
    return !stopped_;
  }

  /// Delivers this item and those that waited for it, on this thread, one at a time.
  void hand_over(std::size_t index, Item item) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(index, std::move(item));
    while (!stopped_ && !waiting_.empty() && waiting_.begin()->first == next_) {
      deliver_(next_, waiting_.begin()->second);
      waiting_.erase(waiting_.begin());
      ++next_;
    }
    room_.notify_all();
  }

  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    room_.notify_all();
  }

 private:
  const std::size_t ahead_;
  const std::function<void(std::size_t, const Item&)> deliver_;
  std::mutex mutex_;
  std::condition_variable room_;
  std::map<std::size_t, Item> waiting_;
  std::size_t next_ = 0;
  bool stopped_ = false;
};

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "orthodrive/core/stop.hpp"

namespace orthodrive {

int worker_count(int threads) {
  if (threads > 0) return threads;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body,
                  const std::function<void(std::size_t)>& after_each) {
  const std::size_t workers = std::min<std::size_t>(static_cast<std::size_t>(worker_count(threads)), count);
  throw_if_stopped();
  if (count == 0) return;
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::condition_variable wake;
  std::exception_ptr first_error;
  std::size_t first_error_index = count;
  std::size_t running = workers;
  const auto keep_error = [&](std::size_t index) {
    const std::lock_guard lock(mutex);
    if (!first_error || index < first_error_index) first_error = std::current_exception(), first_error_index = index;
    stop = true;
  };

  auto work = [&] {
    for (std::size_t i = next++; i < count && !stop; i = next++) {
      try {
        throw_if_stopped();
        body(i);
      } catch (...) {
        keep_error(i);
      }
      ++done;
    }
    const std::lock_guard lock(mutex);
    --running;
    wake.notify_one();
  };

  std::vector<std::thread> pool;
  pool.reserve(workers);
  for (std::size_t w = 0; w < workers; ++w) pool.emplace_back(work);
  {
    std::unique_lock lock(mutex);
    while (running > 0) {
      wake.wait_for(lock, std::chrono::milliseconds(100));
      if (!after_each || first_error) continue;
      lock.unlock();
      try {
        after_each(done.load());
      } catch (...) {  // the workers have to end before the caller's slots go
        keep_error(count);
      }
      lock.lock();
    }
  }
  for (auto& thread : pool) thread.join();
  if (first_error) std::rethrow_exception(first_error);
}

}  // namespace orthodrive

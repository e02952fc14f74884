// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/shared_loop.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <mutex>
#include <numeric>
#include <thread>

namespace orthodrive {
namespace {

/// What files are to processes, for threads.
struct Board {
  std::mutex mutex;
  std::map<std::pair<std::string, std::size_t>, std::string> blocks;
  std::map<std::pair<std::string, std::size_t>, std::vector<std::string>> claims;
};

class BoardExchange : public LoopExchange {
 public:
  BoardExchange(Board& board, std::string name, double first) : board_(board), name_(std::move(name)), first_(first) {}
  [[nodiscard]] std::optional<std::string> load(const std::string& loop, std::size_t block) const override {
    const std::lock_guard lock(board_.mutex);
    const auto found = board_.blocks.find({loop, block});
    return found == board_.blocks.end() ? std::nullopt : std::optional(found->second);
  }
  [[nodiscard]] std::optional<std::string> claim(const std::string& loop, std::size_t block) override {
    const std::lock_guard lock(board_.mutex);
    std::vector<std::string>& claims = board_.claims[{loop, block}];
    for (const std::string& maker : claims)
      if (!lost_.contains(maker)) return maker;
    claims.push_back(name_);
    return std::nullopt;
  }
  [[nodiscard]] std::set<std::string> lost_of(const std::set<std::string>& makers) override {
    const auto now = std::chrono::steady_clock::now();
    if (!makers.contains("lost") || now - asked_first_.value_or(now) < std::chrono::milliseconds(300)) {
      asked_first_ = asked_first_.value_or(now);
      return {};
    }
    const std::lock_guard lock(board_.mutex);
    lost_.insert("lost");
    return {"lost"};
  }
  void keep(const std::string& loop, std::size_t block, const std::string& bytes) override {
    const std::lock_guard lock(board_.mutex);
    ++kept;
    board_.blocks.emplace(std::pair(loop, block), bytes);
  }
  [[nodiscard]] double first_share() const override { return first_; }
  int kept = 0;

 private:
  Board& board_;
  std::string name_;
  double first_;
  std::set<std::string> lost_;
  std::optional<std::chrono::steady_clock::time_point> asked_first_;
};

/// Two loops of which the second one needs all of the first.
std::vector<double> two_loops(LoopExchange* exchange, int threads, std::size_t count = 1000) {
  std::vector<double> first(count), second(count);
  shared_for(
      exchange, "first", count, threads,
      [&](std::size_t i) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
        first[i] = 1.0 / static_cast<double>(i + 3);
      },
      [&](auto& archive, std::size_t i) { archive(first[i]); });
  const double sum = std::accumulate(first.begin(), first.end(), 0.0);
  shared_for(
      exchange, "second", count, threads, [&](std::size_t i) { second[i] = sum * first[i] + static_cast<double>(i); },
      [&](auto& archive, std::size_t i) { archive(second[i]); });
  return second;
}

TEST(SharedLoop, all_have_the_result_of_one_whoever_made_what) {
  const std::vector<double> alone = two_loops(nullptr, 1);
  for (const int count : {1, 3}) {
    Board board;
    std::vector<std::vector<double>> results(static_cast<std::size_t>(count));
    std::vector<std::thread> processes;
    std::atomic<int> kept{0};
    for (int k = 0; k < count; ++k)
      processes.emplace_back([&, k] {
        BoardExchange exchange(board, "p" + std::to_string(k), static_cast<double>(k) / count);
        results[static_cast<std::size_t>(k)] = two_loops(&exchange, k == 1 ? 2 : 1);
        kept += exchange.kept;
      });
    for (std::thread& process : processes) process.join();
    for (const std::vector<double>& result : results) EXPECT_EQ(result, alone);
    EXPECT_EQ(static_cast<std::size_t>(kept), board.blocks.size());  // none twice
    BoardExchange late(board, "late", 0.5);
    EXPECT_EQ(two_loops(&late, 1), alone);
    EXPECT_EQ(late.kept, 0);
  }
}

TEST(SharedLoop, what_a_lost_process_said_it_would_make_is_made_again) {
  Board board;
  board.claims[{"first", 0}] = {"lost"};
  board.claims[{"first", 7}] = {"lost"};
  board.claims[{"second", 100}] = {"lost"};
  BoardExchange exchange(board, "here", 0.0);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(two_loops(&exchange, 1), two_loops(nullptr, 1));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(300));
  EXPECT_TRUE(board.blocks.contains({"first", 7}) && board.blocks.contains({"second", 100}));
  EXPECT_EQ((board.claims[{"second", 100}].size()), 2U);  // no second wait: it is lost in all loops
}

TEST(SharedLoop, an_error_and_no_items_are_as_without_others) {
  Board board;
  BoardExchange exchange(board, "here", 0.9);
  EXPECT_TRUE(two_loops(&exchange, 2, 0).empty());
  EXPECT_EQ(two_loops(&exchange, 2, 1), two_loops(nullptr, 2, 1));
  EXPECT_THROW(
      shared_for(
          &exchange, "bad", 5, 1, [](std::size_t) { throw InputError("x", "is bad"); }, [](auto&, std::size_t) {}),
      InputError);
}

}  // namespace
}  // namespace orthodrive

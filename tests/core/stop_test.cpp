// SPDX-License-Identifier: Apache-2.0
// Ending early: requests, signals, and what does not listen. Each in a process of its own: a request cannot be taken
// back.

#include "orthodrive/core/stop.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/progress_clock.hpp"

namespace orthodrive {
namespace {
using namespace std::chrono_literals;

class StopDeathTest : public testing::Test {
 protected:
  void SetUp() override { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
};

int signal_of(const std::function<void()>& body) {
  try {
    body();
  } catch (const Stopped& stopped) {
    return stopped.signal;
  }
  return 0;
}

TEST_F(StopDeathTest, a_loop_ends_between_two_items) {
  EXPECT_EXIT(
      {
        std::atomic<int> done{0};
        const int signal = signal_of([&] {
          parallel_for(1000, 4, [&](std::size_t i) {
            if (i == 10) request_stop(SIGTERM);
            ++done;
          });
        });
        _exit(signal == SIGTERM && done < 100 && stop_requested() ? 7 : 1);
      },
      testing::ExitedWithCode(7), "");
}

TEST_F(StopDeathTest, what_reports_progress_may_throw) {
  EXPECT_EXIT(
      {
        std::atomic<bool> go_on{true};
        const int signal = signal_of([&] {
          parallel_for(
              2, 2,
              [&](std::size_t) {
                while (go_on) std::this_thread::sleep_for(1ms);
              },
              [&](std::size_t) {
                go_on = false;
                throw Stopped(SIGINT);
              });
        });
        _exit(signal == SIGINT ? 7 : 1);
      },
      testing::ExitedWithCode(7), "");
}

TEST_F(StopDeathTest, a_signal_is_a_request) {
  EXPECT_EXIT(
      {
        ::signal(SIGINT, SIG_DFL);  // who starts the tests in the background of a script has it ignored
        int signal = 0;
        {
          const StopOnSignals stoppable;
          kill(getpid(), SIGINT);
          signal = signal_of([] {
            for (int i = 0; i < 1000; ++i) std::this_thread::sleep_for(1ms), throw_if_stopped();
          });
        }
        _exit(signal == SIGINT ? 7 : 1);
      },
      testing::ExitedWithCode(7), "");
}

TEST_F(StopDeathTest, what_does_not_listen_is_ended) {
  EXPECT_EXIT(
      {
        const StopOnSignals stoppable(
            {.patience = 100ms, .last_words = [] { (void)!write(STDERR_FILENO, "last words", 10); }});
        kill(getpid(), SIGTERM);
        std::this_thread::sleep_for(20s);
        _exit(1);
      },
      testing::ExitedWithCode(128 + SIGTERM), "last words");
}

TEST_F(StopDeathTest, ignored_signals_stay_ignored) {
  EXPECT_EXIT(
      {
        signal(SIGHUP, SIG_IGN);  // as under nohup
        const StopOnSignals stoppable({.patience = 1ms});
        kill(getpid(), SIGHUP);
        std::this_thread::sleep_for(200ms);
        _exit(stop_requested() ? 1 : 7);
      },
      testing::ExitedWithCode(7), "");
}

TEST_F(StopDeathTest, a_signal_that_comes_when_all_is_done_changes_nothing) {
  EXPECT_EXIT(
      {
        ::signal(SIGINT, SIG_DFL);
        { const StopOnSignals stoppable; }
        kill(getpid(), SIGINT);
        std::this_thread::sleep_for(20ms);
        _exit(7);
      },
      testing::ExitedWithCode(7), "");
}

TEST(ProgressClock, tells_rate_and_rest_once_there_is_something_to_go_by) {
  ProgressClock clock;
  EXPECT_FALSE(clock.update(0.0, "segment", 100.0));
  EXPECT_FALSE(clock.update(0.005, "segment", 110.0)) << "too little work";
  const auto pace = clock.update(0.25, "segment", 125.0);
  ASSERT_TRUE(pace);
  EXPECT_DOUBLE_EQ(pace->rate_per_s, 0.01);
  EXPECT_DOUBLE_EQ(pace->remaining_s, 75.0);
  EXPECT_FALSE(clock.update(0.25, "refine", 126.0)) << "other work";
  EXPECT_DOUBLE_EQ(clock.update(0.75, "refine", 131.0)->remaining_s, 2.5) << "counts from where it began";
  EXPECT_FALSE(clock.update(0.1, "refine", 132.0)) << "the same work anew";
  EXPECT_DOUBLE_EQ(clock.update(1.0, "refine", 135.0)->remaining_s, 0.0);
}

}  // namespace
}  // namespace orthodrive

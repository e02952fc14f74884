// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/one_cv_thread.hpp"

#include <mutex>
#include <opencv2/core.hpp>

namespace orthodrive::baselines {
namespace {

// The number is one of the process, so the last one out puts it back.
std::mutex mutex;
int living = 0, threads_before = 0;

}  // namespace

OneCvThread::OneCvThread() {
  const std::lock_guard lock(mutex);
  if (living++ > 0) return;
  threads_before = cv::getNumThreads();
  cv::setNumThreads(1);
}

OneCvThread::~OneCvThread() {
  const std::lock_guard lock(mutex);
  if (--living == 0) cv::setNumThreads(threads_before);
}

}  // namespace orthodrive::baselines

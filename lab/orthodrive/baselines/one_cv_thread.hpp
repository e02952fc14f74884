// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenCV's own threads off while one of these lives: we run one tile a thread, and SLIC's threads share their sums.

namespace orthodrive::baselines {

class OneCvThread {
 public:
  OneCvThread();
  ~OneCvThread();
  OneCvThread(const OneCvThread&) = delete;
  OneCvThread& operator=(const OneCvThread&) = delete;
};

}  // namespace orthodrive::baselines

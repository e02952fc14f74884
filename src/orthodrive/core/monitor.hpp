// SPDX-License-Identifier: Apache-2.0
#pragma once
// How the library talks: stages report to a Monitor and never print.

#include <string_view>

namespace orthodrive {

class Monitor {
 public:
  virtual ~Monitor() = default;
  virtual void info(std::string_view message) { (void)message; }
  /// `fraction` in 0..1 of the work of the running stage. Called from the calling thread only.
  virtual void progress(double fraction, std::string_view what) { (void)fraction, (void)what; }
  [[nodiscard]] virtual bool cancelled() const { return false; }
};

}  // namespace orthodrive

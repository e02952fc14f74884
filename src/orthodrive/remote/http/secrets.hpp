// SPDX-License-Identifier: Apache-2.0
#pragma once
// Keys of services: read from the environment, put into addresses, and never shown.

#include <string>
#include <utility>
#include <vector>

namespace orthodrive::remote {

class Secrets {
 public:
  /// The text with every {env:NAME} replaced by that variable, percent-encoded. Throws OptionError where one is not
  /// set.
  [[nodiscard]] std::string resolve(const std::string& text);
  /// The text with {env:NAME} where the value of a resolved variable stands, and without passwords and keys that an
  /// address carries itself (user:password@, ?key=...). For every message and file.
  [[nodiscard]] std::string hide(std::string text) const;

 private:
  std::vector<std::pair<std::string, std::string>> values_;  ///< value and its {env:NAME}, longest value first
};

}  // namespace orthodrive::remote

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the two parts of HttpClient share. Internal to remote.

#include <string>

#include "orthodrive/remote/http/http_client.hpp"

namespace orthodrive::remote {

struct HttpClient::State {
  HttpOptions options;
  const Secrets& secrets;
  Monitor* monitor = nullptr;
  [[nodiscard]] std::string shown(const std::string& text) const { return secrets.hide(text); }
};

}  // namespace orthodrive::remote

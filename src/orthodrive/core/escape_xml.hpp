// SPDX-License-Identifier: Apache-2.0
#pragma once
// Text inside XML and HTML.

#include <string>

namespace orthodrive {

/// Text for element content and attributes: & < > " escaped.
[[nodiscard]] std::string escape_xml(const std::string& text);

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Addresses with {names} in them, as tile services describe theirs.

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace orthodrive::remote {

/// Unreserved characters (RFC 3986) stay, others become %XX.
[[nodiscard]] std::string percent_encoded(std::string_view text);
/// The names in {} of a template, in their order, {env:...} left out.
[[nodiscard]] std::vector<std::string> names_in(std::string_view pattern);
/// Every {name} that is in `values` replaced. Names compare without case, as WMTS has it.
[[nodiscard]] std::string filled(std::string_view pattern, const std::map<std::string, std::string>& values);
/// Adds query parameters to an address that may have some: those of the same name (without case) are replaced.
[[nodiscard]] std::string with_query(const std::string& url,
                                     const std::vector<std::pair<std::string, std::string>>& query);
/// "https://host:port" of an address: what connections and pauses are counted for.
[[nodiscard]] std::string host_of(std::string_view url);
[[nodiscard]] bool is_http(std::string_view url);

}  // namespace orthodrive::remote

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Addresses that stand in answers of servers.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace orthodrive::remote {

/// What a link on a page means (RFC 3986, section 5), without its fragment. Empty for what is no address of http(s),
/// such as file: and s3:.
[[nodiscard]] std::string absolute_address(const std::string& page, const std::string& link);
/// Whether a name in the address ends like a raster or an archive (.tif, .jp2, .zip, ...); it may stand in the query.
/// Those of pictures (.jpg, .png) do not count: they are previews, which have no place on earth.
[[nodiscard]] bool names_sheet(std::string_view address);

/// The login and the keys of a table's address, for links to the same host: {env:NAME} and user:password@.
class LinkKeys {
 public:
  /// `pattern` has {env:NAME}, `resolved` their values.
  LinkKeys(const std::string& pattern, const std::string& resolved);
  [[nodiscard]] std::string with(const std::string& link) const;

 private:
  std::string host_, login_;
  std::vector<std::pair<std::string, std::string>> query_;  ///< name, value as it stands in the address
};

}  // namespace orthodrive::remote

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a STAC API (item search, 1.0.0) and an OGC API Features of items answer, as their JSON has it: nothing is looked
// up, so that any bytes may be given.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::remote {

struct StacAsset {
  std::string key, href, type;
  std::vector<std::string> roles;
  std::int64_t bytes = 0;  ///< 0: not said
  std::string crs;         ///< as of the item; of one asset alone
};

struct StacItem {
  std::string id, collection;  ///< an id is unique in its collection
  std::string date;
  std::string crs;         ///< "EPSG:n" of the projection extension; empty: not said
  MultiPolygon footprint;  ///< degrees; empty: not said
  std::vector<StacAsset> assets;
};

/// The link to the next page.
struct StacNext {
  std::string href;
  std::string body;    ///< JSON of a POST; empty: GET
  bool merge = false;  ///< the body adds to that of the request
};

struct StacPage {
  std::vector<StacItem> items;
  std::optional<StacNext> next;
};

/// Documents of 64 levels and five million values at most. Throws InputError that begins with `name` (an address) for
/// what is no such answer: a page of HTML, truncated JSON, an error of the server (with its text).
[[nodiscard]] StacPage parse_stac_page(std::string_view json, const std::string& name);

/// The asset with the picture: the one called `layer`, in which * stands for any characters, else the one with the role
/// "data" that is a raster, else the only raster. None where the item lacks it. Throws InputError that begins with
/// `name` where several could be meant.
[[nodiscard]] const StacAsset* chosen_asset(const StacItem& item, const std::string& layer, const std::string& name);

/// JSON of two objects, as a link with "merge" asks: members of the second replace those of the first.
[[nodiscard]] std::string merged_json(const std::string& first, const std::string& second);

}  // namespace orthodrive::remote

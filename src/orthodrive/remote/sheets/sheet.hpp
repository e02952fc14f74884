// SPDX-License-Identifier: Apache-2.0
#pragma once
// One file of many that show a country: where it lies and what it covers.

#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/geo/polygon.hpp"

namespace orthodrive::remote {

/// Of one area; more is refused.
constexpr std::size_t most_sheets = 5000;

struct Sheet {
  std::string url;         ///< with its keys
  MultiPolygon footprint;  ///< degrees, x = longitude; empty: not known, the index says that it touches the area
  std::string crs;         ///< "EPSG:n" as the index has it; empty: not said
  std::string type;        ///< media type where the index offers the same place in several; else empty
  std::string date;        ///< ISO 8601: the later text is the newer; empty: not known
  std::int64_t bytes = 0;  ///< as the index has it; 0: not said
};

/// Rings whose corners are places on earth, in degrees; others are left out.
[[nodiscard]] bool is_on_earth(const Ring& ring);
[[nodiscard]] Polygon lonlat_rectangle(double west, double south, double east, double north);

}  // namespace orthodrive::remote

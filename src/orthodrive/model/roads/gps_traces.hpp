// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where somebody has driven, as a receiver recorded it. On disk: GPX.

#include <cstddef>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polyline.hpp"

namespace orthodrive {

/// Positions in a row, in the order in which they were driven, without long gaps.
struct GpsTrace {
  Polyline line;              ///< site CRS, two points at least
  std::size_t recording = 0;  ///< traces of one recording have the error of one receiver: together they are one witness
};

struct GpsTraces {
  Crs crs;
  std::vector<GpsTrace> traces;
};

}  // namespace orthodrive

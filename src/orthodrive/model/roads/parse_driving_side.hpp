// SPDX-License-Identifier: Apache-2.0
#pragma once
// On which side of the road one drives, in the country of the site.

#include <string_view>

#include "orthodrive/core/error.hpp"
#include "roadquery/map/driving_side.hpp"

namespace orthodrive {

using DrivingSide = roadquery::DrivingSide;

[[nodiscard]] inline const char* to_string(DrivingSide side) { return side == DrivingSide::left ? "left" : "right"; }
/// "right" or "left"; throws OptionError for other texts.
[[nodiscard]] inline DrivingSide driving_side_of(std::string_view text) {
  if (text == "right") return DrivingSide::right;
  if (text == "left") return DrivingSide::left;
  throw OptionError("driving_side must be right or left, not '" + std::string(text) + "'");
}

}  // namespace orthodrive

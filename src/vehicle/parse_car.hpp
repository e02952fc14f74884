// SPDX-License-Identifier: Apache-2.0
#pragma once
// Parameter files of cars (models/vehicles): a small part of TOML. docs/vehicle.md lists keys, units and ranges.

#include <string>
#include <string_view>

#include "vehicle/car_parameters.hpp"

namespace vehicle {

/// Reads the text of a file; `file` is its name in messages. Throws std::runtime_error "FILE:LINE: what is wrong" for
/// unknown, double or missing sections and keys, values of the wrong kind, not finite or out of range, and values that
/// do not fit together.
[[nodiscard]] CarParameters parse_car(std::string_view text, const std::string& file);

/// Throws std::invalid_argument with one clear line when a value is not finite, out of range or does not fit others.
void check(const CarParameters& car);

}  // namespace vehicle

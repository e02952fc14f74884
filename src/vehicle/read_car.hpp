// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "vehicle/parse_car.hpp"

namespace vehicle {

/// parse_car() of a file; throws std::runtime_error as well when it cannot be read or is larger than 1 MB.
[[nodiscard]] CarParameters read_car(const std::filesystem::path& file);

}  // namespace vehicle

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>

namespace orthodrive {

/// A score of nothing: there was nothing to compare.
inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

}  // namespace orthodrive

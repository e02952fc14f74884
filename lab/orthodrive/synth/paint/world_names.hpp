// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>

namespace orthodrive {

/// Of the worlds that have a name (world.hpp); "random" is not among them.
inline constexpr std::array world_names{"baltic",       "japan",    "japan_winter", "japan_film", "america",
                                        "america_fall", "prairie",  "france",       "bohemia",    "winter",
                                        "south",        "himalaya", "overcast"};

}  // namespace orthodrive

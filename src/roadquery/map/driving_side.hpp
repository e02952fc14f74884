// SPDX-License-Identifier: Apache-2.0
#pragma once
// On which side of the road one drives: OpenDRIVE's rule RHT (right) or LHT (left).

#include <cstdint>

namespace roadquery {

enum class DrivingSide : std::uint8_t { right, left };

}  // namespace roadquery

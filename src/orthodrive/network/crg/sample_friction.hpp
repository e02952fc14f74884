// SPDX-License-Identifier: Apache-2.0
#pragma once
// The friction of a road's lanes as an OpenCRG grid (OpenDRIVE 1.7, 10.6: <CRG purpose="friction">).

#include <string>

#include "orthodrive/model/roads/crg_geometry.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

/// A grid whose values are friction coefficients, u along s and v = t, for mode "attached": its reference line is a
/// straight one that nobody places. Rows lie every half metre where the friction changes along the road or the lanes'
/// borders move, else only at the ends; columns every 0.25 m where lanes differ, else two. Beside the lanes the value
/// of the nearest one goes on. Lengths of zero throw Error. Linear in the length.
[[nodiscard]] CrgSurface sample_friction(const roadquery::Road& road);

/// From the whole road to its file, mode "attached".
[[nodiscard]] roadquery::SurfaceCrg friction_reference(const roadquery::Road& road, const std::string& file);

}  // namespace orthodrive

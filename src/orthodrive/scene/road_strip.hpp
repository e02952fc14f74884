#pragma once
// A road as a strip of cross sections: where the mesh follows the exact surface of roadquery/road_surface.hpp.

#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive::scene {

struct CrossSection {
  double s_m = 0.0;
  Vec3 left, right, reference;  ///< on the surface: outer edges of the carriageway and the reference line
};

struct StripOptions {
  double tolerance_m = 0.02;  ///< of edges and middle between two sections, linear in s, from the exact ones
  double max_step_m = 10.0;
};

/// Sections at every start of a geometry, profile, shape or lane element and as many between as the tolerance asks for.
/// Where the lanes change abruptly there are two sections a tenth of a millimetre apart.
/// Empty for roads without length, lanes or finite heights.
[[nodiscard]] std::vector<CrossSection> cross_sections(const roadquery::Road& road, const StripOptions& options);

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#pragma once
// A road as a strip of cross sections, evaluated in the tables of the road query.

#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/query/road_query.hpp"

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
/// Empty for roads without length, lanes or finite heights. `road`: index into the query's map.
[[nodiscard]] std::vector<CrossSection> cross_sections(const roadquery::RoadQuery& query, std::size_t road,
                                                       const StripOptions& options);
/// Whether cross_sections() has any for the road.
[[nodiscard]] bool has_sections(const roadquery::RoadQuery& query, std::size_t road);

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#pragma once
// <crossSectionSurface> (1.8, 10.5): the lateral profile by up to two strips to each side, in place of <shape>.

#include <vector>

#include "roadquery/map/road_map.hpp"
#include "roadquery/opendrive/note_list.hpp"

namespace roadquery {

/// A strip's height is constant(s) + linear(s) dt + quadratic(s) dt^2 + cubic(s) dt^3. dt is signed as t is; it counts
/// from the strip's inner edge.
struct SurfaceStrip {
  int id = 0;             ///< 1, 2 to the left, -1, -2 to the right; 2: the outer one
  bool relative = false;  ///< of an outer strip: on top of the inner one's height at its outer edge
  std::vector<Cubic> width, constant, linear, quadratic, cubic;
};

struct CrossSectionSurface {
  std::vector<Cubic> t_offset;  ///< t of the inner edges of the inner strips
  std::vector<SurfaceStrip> strips;
};

/// Gives the road rows of <shape> that are the surface, to 0.1 mm. The lists are in order. A road with shapes keeps
/// these. Notes say what is passed over.
void shapes_from_strips(Road& road, CrossSectionSurface surface, NoteList& notes);

}  // namespace roadquery

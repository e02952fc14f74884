// SPDX-License-Identifier: Apache-2.0
#pragma once
// An OpenCRG surface of a road: the one surface of roadquery/road_surface.hpp sampled on a curved regular grid.

#include <functional>

#include "orthodrive/model/roads/crg_geometry.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

struct SampleCrgOptions {
  double u_step_m = 0.5;  ///< largest step along the road; the road is divided evenly
  double v_step_m = 0.1;  ///< columns lie at its multiples, and where the lateral shape has a knot
  /// What the channels of the reference line are rounded to while it is stepped along: a step makes up for what the one
  /// before it lost, so that the line of the file does not drift off the road's.
  CrgFormat format = CrgFormat::krbi;
  /// Height to add at (s, t) of the road, for example its measured roughness; none: the surface alone.
  std::function<double(double s, double t)> relief_m;
  /// The step along the road is halved until the middles of the cells are this near to the surface (without relief),
  /// but no further than a sixteenth: tight turns and short vertical curves need it. 0: the step as it is.
  double tolerance_m = 0.0;
};

/// The reference line has its points on the road's, one chord of equal length apart (so u is shorter than s by the
/// bends' sagitta: phi^2 / 24 of a step); slope and banking (across the road in plan) are the road's at the
/// rows, the grid is the remainder. In a row the grid reproduces the road's surface at the place where crg_xy() puts
/// the column: exactly but for the format's digits; between rows and columns bilinear interpolation misses it by an
/// eighth of its second derivatives times the steps squared. Grid values are missing more than a column off the
/// carriageway and where a bend folds the surface over itself. Lengths of zero throw Error. Linear in the length.
[[nodiscard]] CrgSurface sample_crg(const roadquery::Road& road, const SampleCrgOptions& options = {});

/// The reference from the road to its file. Mode "genuine" (1.7, 10.6): the heights of the file are the whole height,
/// its own reference line counts, put to where the road begins and turned by h_offset, the angle from the road's
/// heading to the first chord. "attached" would lay the grid over the road's own heights and drop reference line, slope
/// and banking of the file, which then would not be the surface for who reads it alone.
[[nodiscard]] roadquery::SurfaceCrg crg_reference(const roadquery::Road& road, const CrgSurface& surface,
                                                  const std::string& file);

}  // namespace orthodrive

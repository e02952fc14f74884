// SPDX-License-Identifier: Apache-2.0
#pragma once
// Radius of the kerb at corners of junctions, seen in the labels.

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Sets kerb_radius_m of all nodes of a junction that has a readable corner to the median of its corners; 0 elsewhere.
/// Two neighbouring arms make a corner where their edges meet (widths as refined). With two edges at the angle phi and
/// u the bisector from their corner, a kerb of radius r has its centre at r u / sin(phi / 2) and paves what lies
/// between it and the corner. Every pixel w beyond both edges has the radius that just paves it, the larger root of
///
///     |w - r u / sin(phi / 2)| = r
///
/// The radius of a corner is the one that the fewest pixels contradict: roads beyond it, or ground within it. Trees and
/// parking places say nothing; arms that the labels do not show as roads have no corners. Returns the number of
/// junctions with a radius. Linear in the area of the corners.
int measure_kerb_radii(RoadNetwork& roads, const LabelMap& labels);

}  // namespace orthodrive

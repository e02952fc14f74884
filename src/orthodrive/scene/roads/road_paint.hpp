// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is painted on a road besides its lines: crosswalks, waiting lines, arrows, gores.

#include <vector>

#include "orthodrive/scene/roads/road_markings.hpp"

namespace orthodrive::scene {

/// Polygons of the crosswalks and road marks among the road's objects:
/// - crosswalk "zebra", and without a subtype, as OpenDRIVE before 1.7 has them: bars of 0.5 m along the road, 0.5 m
///   apart; "pedestrian": two broken lines of 0.12 m; others: nothing
/// - "signalLines": the box; a "give way line" in blocks of 0.5 m, 0.25 m apart
/// - "arrowLeft" ... "arrowStraightLeftRight": an arrow as long and wide as the box
/// - "hatchedArea" with an outline along one side and back along the other: two lines of 0.15 m and between them
/// strokes
///   of 0.5 m at 45 degrees, 1 m apart (Austria's Bodenmarkierungsverordnung; the distance is ours)
/// Measures: RMS-1 1993, R-FGUE 2001. Objects larger than 100 m are passed over.
[[nodiscard]] std::vector<MarkingPiece> road_paint(const roadquery::Road& road);

}  // namespace orthodrive::scene

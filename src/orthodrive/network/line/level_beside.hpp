// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights of roads that share a strip of pavement.

#include "orthodrive/network/line/road_sections.hpp"

namespace orthodrive::network {

/// Where two roads part, or run so near that neither can give all the room (leave_room.hpp), both are the surface of a
/// strip. Profiles are found road by road, and a tyre near the border of the one feels how the other begins: there the
/// road that gives way (gives_way()) takes the height of the other in the middle of the strip, and its cross slope as
/// far as the edges of the strip would lie over 5 mm apart. Roads are of one level up to 1.5 m apart, those that part
/// at one node up to 4 m. Before and behind the strip the change fades out over 20 m, over more where it is large or
/// the road is fast: height by 0.03 and banking by 0.0033 per metre (twice that where strips lie near each other),
/// vertical acceleration by 1 m/s2 at the speed limit. Roads give way to what lies in a junction that is not theirs.
/// Closed chains keep their heights.
void level_beside(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions, const Cuts& cuts,
                  ChainGeometries& geometry);

}  // namespace orthodrive::network

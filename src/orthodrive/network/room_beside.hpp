#pragma once
// Carriageways that lie on each other outside junctions.

#include "orthodrive/network/stretches.hpp"

namespace orthodrive::network {

/// Widths are measured road by road. Where two roads run side by side nearer to each other than half their widths
/// together, both would be the surface of the strip between them, each with a height of its own: the road of the lower
/// class (then the narrower one) gives way to the other up to its edge, but keeps what a car needs there
/// (least_carriageway_m); what is missing the other gives. Between different heights a bank as wide as high, at most
/// half a metre, stays free. Roads more than 1.5 m apart in height or 30 degrees in
/// heading are left alone, and so is what lies on a road by more than 1.5 m. Roads give way to what lies in a junction
/// that is not theirs. Widths change by 0.05 m per metre at most.
void leave_room_beside(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
                       ChainGeometries& geometry);

}  // namespace orthodrive::network

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Ways that turn off at a junction while another road runs straight on: two roads that OSM draws as one way.

#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/roads/continuation.hpp"

namespace orthodrive {

/// Cuts paths at nodes where they bend by `max_bend_rad` or more while, by the same rule, one of their two arms and
/// that of another path continue each other: the corner of a junction, not a bend of the road. Paths of rings stay
/// whole. Parts of a way are counted anew, in its direction. Order is kept.
void cut_at_corners(RoadNetwork& roads, const ContinuationRule& rule = way_continuation);

}  // namespace orthodrive

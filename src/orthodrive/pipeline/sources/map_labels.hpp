// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a site's map says of the classes of pixels: weak labels for a network that adapts.

#include "orthodrive/pipeline/sources/sources.hpp"
#include "orthodrive/segment/adapted_model.hpp"

namespace orthodrive {

/// Coats of paint_labels, from below: anything but road; buildings; water; ways that may be road or something else
/// (service ways, tracks, and all that nobody drives: nothing is said there); roads of half their usual width, and
/// nothing is said to 3 m beyond it. In the order of `roads`, `buildings`, `surroundings`.
[[nodiscard]] WeakLabels map_labels(const RoadNetwork& roads, const Sources::Files& buildings,
                                    const Sources::Files& surroundings, const SiteFrame& site,
                                    const ClassTable& classes);

}  // namespace orthodrive

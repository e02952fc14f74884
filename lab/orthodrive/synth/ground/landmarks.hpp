// SPDX-License-Identifier: Apache-2.0
#pragma once
// What few places have: a quarry, a railway, a river, tower blocks, a farm, works, an orchard, old snow, tyre barriers.
// Sites whose labels have more classes than the default table show them (synth/paint/label_classes.hpp).

#include <cstdint>

#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

/// Adds two of each a square kilometre, at least one, where there is room beside roads and buildings: a site of 500 m
/// may lack some. Railway and river run along the site's edge; roads that leave it there cross at grade, the river in a
/// culvert. Roads and heights are as before; the map has the added buildings. The same seed adds the same.
void add_landmarks(SitePlan& plan, std::uint64_t seed);

}  // namespace orthodrive::synth

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Unpaved roads that no tag tells of, seen in the labels.

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/model/roads/road_network.hpp"

namespace orthodrive {

/// Sets `known_surface` of tracks and service roads whose class is only what is usual for them (source highway): gravel
/// or ground where the labels in the middle of the carriageway say so. Classes are told by their names: gravel, macadam
/// and the plain "ground" of the default table are gravel; dirt, field, grass, grassland and lawn are ground; those of
/// roads and car parks are paved. What hides a road (trees, roofs, nodata) does not count. A road label never makes a
/// track asphalt: nets are taught that gravel tracks are roads, too. Other roads are left alone: between houses labels
/// err more often than roads are unpaved. Returns the number of paths that changed. Linear in the number of nodes.
int classify_by_photo(RoadNetwork& roads, const LabelMap& labels);

}  // namespace orthodrive

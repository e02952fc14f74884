// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/building_blocks.hpp"

#include <algorithm>
#include <vector>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/buildings/building_mesh.hpp"

namespace orthodrive::scene {
namespace {

/// Flat where the options allow it; the error counts what has changed.
PlacedBuilding block_of(const PlacedBuilding& building, const BlockOptions& options, double& error_m) {
  const double sunk_m = 0.5 * building.roof.rise_m;
  if (sunk_m > options.roof_m) return building;  // the slopes hang on the corners of the footprint
  PlacedBuilding block = building;
  const MultiPolygon outline = simplified({building.footprint}, options.outline_m);
  if (outline.size() == 1) block.footprint = outline.front();
  const bool is_changed = block.footprint.outer.size() != building.footprint.outer.size() ||
                          block.footprint.holes.size() != building.footprint.holes.size();
  if (!is_changed && building.roof.shape == RoofShape::flat) return block;
  block.roof = make_roof(block.footprint, {});
  block.eaves_z_m += sunk_m;
  error_m = std::max({error_m, sunk_m, is_changed ? options.outline_m : 0.0});
  return block;
}

}  // namespace

Blocks building_blocks(std::span<const PlacedBuilding* const> buildings, Vec3 origin, const BlockOptions& options) {
  Blocks result;
  std::vector<PlacedBuilding> blocks;
  for (const PlacedBuilding* building : buildings) {
    if (height_m(*building) <= options.size_m) {
      result.error_m = std::max(result.error_m, height_m(*building));
    } else {
      result.error_m = std::max(result.error_m, detail_reach_m(*building));
      blocks.push_back(block_of(*building, options, result.error_m));
    }
  }
  std::vector<const PlacedBuilding*> views;
  views.reserve(blocks.size());
  for (const PlacedBuilding& block : blocks) views.push_back(&block);
  result.mesh = building_mesh(views, origin, BuildingDetail::blocks);
  result.mesh.features.clear();
  return result;
}

}  // namespace orthodrive::scene

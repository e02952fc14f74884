#pragma once
// What the parts of a tile are, for those who click on them.

#include "orthodrive/model/scene.hpp"
#include "roadquery/road_query.hpp"

namespace orthodrive::scene {

/// Gives each triangle of the mesh the lane under its middle, in junctions the nearest one of the nearest connecting
/// road: sets TriMesh::features and appends the lanes to the tile's. Vertices between triangles of two lanes are
/// doubled.
void name_roads(const roadquery::RoadQuery& query, SceneTile& tile, TriMesh& road);

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the parts of a tile are, for those who click on them.

#include <compare>
#include <map>
#include <vector>

#include "orthodrive/model/scene.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive::scene {

/// What lies under the middle of a triangle.
struct LaneUnder {
  int road = -1;  ///< index into the map; -1: none
  int lane_id = 0;
  roadquery::LaneType type = roadquery::LaneType::none;
  roadquery::SurfaceClass surface = roadquery::SurfaceClass::asphalt;
  bool in_junction = false;
  friend auto operator<=>(const LaneUnder&, const LaneUnder&) = default;
};

/// Of a mesh of roads.
struct MeshLanes {
  std::map<std::uint32_t, LaneUnder> by_feature;
  std::vector<double> near_s_m;  ///< one per vertex: s of the lane's road under one of its triangles
};

/// Gives each triangle of the mesh the lane under its middle, in junctions the nearest one of the nearest connecting
/// road: sets TriMesh::features and appends the lanes to the tile's. Vertices between triangles of two lanes, or of two
/// surfaces of a lane, are doubled.
MeshLanes name_lanes(const roadquery::RoadQuery& query, SceneTile& tile, TriMesh& road);

}  // namespace orthodrive::scene

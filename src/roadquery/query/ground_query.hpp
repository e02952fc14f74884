// SPDX-License-Identifier: Apache-2.0
#pragma once
// What is under a point: a road, or the terrain beside it.

#include <memory>
#include <optional>
#include <vector>

#include "roadquery/query/road_borders.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/query/terrain_grid.hpp"

namespace roadquery {

enum class Place { none, road, junction, terrain };

struct GroundHit {
  Place place = Place::none;
  Hit hit;  ///< road -1 on terrain
};

struct RoadIds {
  int road = -1, junction = -1;
};

/// Roads, and the terrain where there is none. Within verge_m of a road's border the ground goes from the border's
/// height to the terrain by a smoothstep over the distance, as in the scene stage. Where a road and the terrain are
/// more than 1.5 m apart (under bridges, over tunnels) the one nearer to z_guess counts, and the road when that is NaN.
/// All functions are const, do not allocate, and may be called from many threads.
class GroundQuery {
 public:
  /// Throws as RoadQuery.
  GroundQuery(RoadMap map, std::optional<TerrainGrid> terrain, double verge_m);
  explicit GroundQuery(RoadMap map) : GroundQuery(std::move(map), std::nullopt, 0.0) {}

  [[nodiscard]] const RoadQuery& roads() const { return roads_; }
  [[nodiscard]] const std::optional<TerrainGrid>& terrain() const { return terrain_; }
  /// `parts`: sum of HitPart, what of a road's hit is asked for.
  [[nodiscard]] GroundHit find(double x, double y, double z_guess, Cursor& cursor, unsigned parts = hit_all) const {
    GroundHit found;
    found.place = find(x, y, z_guess, cursor, parts, found.hit);
    return found;
  }
  /// The same into a fresh Hit of the caller's.
  [[nodiscard]] Place find(double x, double y, double z_guess, Cursor& cursor, unsigned parts, Hit& hit) const {
    const bool on_road = roads_.find(x, y, z_guess, cursor, parts, hit);
    if (!terrain_) return on_road ? place_of(hit) : Place::none;
    return choose(on_road, x, y, z_guess, hit);
  }
  /// What find() gives without any part, for less.
  [[nodiscard]] Place find_height(double x, double y, double z_guess, Cursor& cursor, double& z) const {
    if (terrain_) {
      Hit hit;
      const Place place = find(x, y, z_guess, cursor, 0, hit);
      z = hit.z;
      return place;
    }
    HeightHit hit;
    if (!roads_.find_height(x, y, z_guess, cursor, hit)) return Place::none;
    z = hit.z;
    return hit.in_junction ? Place::junction : place_on(hit.road);
  }
  /// Ids of a road and of its junction (-1: none), by the road's index.
  [[nodiscard]] RoadIds ids(int road) const { return ids_[static_cast<std::size_t>(road)]; }
  /// Point (s, t) of a road, by its index: the road's own surface with its lanes' heights and OpenCRG files, whatever
  /// overlaps it there.
  [[nodiscard]] SurfacePoint point(int road, double s, double t) const;

 private:
  [[nodiscard]] Place place_on(int road) const { return ids(road).junction >= 0 ? Place::junction : Place::road; }
  [[nodiscard]] Place place_of(const Hit& hit) const { return hit.in_junction ? Place::junction : place_on(hit.road); }
  /// Road or terrain, where both may be; `hit` is the road's when there is one.
  [[nodiscard]] Place choose(bool on_road, double x, double y, double z_guess, Hit& hit) const;
  [[nodiscard]] std::optional<TerrainPoint> ground_beside_roads(double x, double y) const;

  RoadQuery roads_;
  std::vector<RoadIds> ids_;  ///< near each other in memory, which roads are not
  std::optional<TerrainGrid> terrain_;
  std::optional<RoadBorders> borders_;
  double verge_m_ = 0.0;
};

struct GroundFiles {
  std::string network;                      ///< OpenDRIVE
  HeaderOffset offset = HeaderOffset::add;  ///< the terrain is moved along
  std::string terrain;                      ///< ESRI ASCII grid in the CRS of the geoReference; empty: none
  double verge_m = 5.0;
  bool ignore_crg = false;                  ///< true: without the OpenCRG files that the roads name
  std::optional<std::string> crg_folder{};  ///< where they are; none: beside the OpenDRIVE file
};
/// What read_ground is at: says which file was wrong when it throws.
enum class GroundStage { network, terrain, crg };

/// Throws std::runtime_error "file: line: what".
[[nodiscard]] GroundQuery read_ground(const GroundFiles& files, GroundStage& stage);

}  // namespace roadquery

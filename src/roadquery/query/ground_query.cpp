// SPDX-License-Identifier: Apache-2.0
#include "roadquery/query/ground_query.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>

namespace roadquery {
namespace {

constexpr double level_of_roads_m = 1.5;  // as for the query

Hit terrain_hit(const TerrainPoint& ground) {
  Hit hit;
  const double norm = std::sqrt(1.0 + ground.dz_dx * ground.dz_dx + ground.dz_dy * ground.dz_dy);
  hit.z = ground.z;
  hit.normal = {-ground.dz_dx / norm, -ground.dz_dy / norm, 1.0 / norm};
  hit.surface = SurfaceClass::ground;
  return hit;
}

/// Terrain lies in the CRS of the geoReference; the roads lie where the header's offset has been added to, or not.
void move_to_roads(TerrainGrid& terrain, const RoadMap& map, HeaderOffset offset) {
  const double times = offset == HeaderOffset::add ? 0.0 : offset == HeaderOffset::ignore ? 1.0 : 2.0;
  terrain.west -= times * map.header_offset_m[0];
  terrain.south -= times * map.header_offset_m[1];
  for (float& z : terrain.z) z -= static_cast<float>(times * map.header_offset_m[2]);
}

}  // namespace

GroundQuery::GroundQuery(RoadMap map, std::optional<TerrainGrid> terrain, double verge_m)
    : roads_(std::move(map)), terrain_(std::move(terrain)), verge_m_(verge_m) {
  for (const Road& road : roads_.map().roads) ids_.push_back({road.id, road.junction});
  if (terrain_ && verge_m_ > 0.0) borders_.emplace(roads_, verge_m_);
}

Place GroundQuery::choose(bool on_road, double x, double y, double z_guess, Hit& hit) const {
  // On a road, near it: the terrain is not asked.
  if (on_road && !(std::abs(hit.z - z_guess) > level_of_roads_m)) return place_of(hit);
  const auto ground = ground_beside_roads(x, y);
  if (!ground) return on_road ? place_of(hit) : Place::none;
  const bool other_level = on_road && std::abs(ground->z - hit.z) > level_of_roads_m;
  if (on_road && !(other_level && std::abs(ground->z - z_guess) < std::abs(hit.z - z_guess))) return place_of(hit);
  hit = terrain_hit(*ground);
  return Place::terrain;
}

std::optional<TerrainPoint> GroundQuery::ground_beside_roads(double x, double y) const {
  if (!terrain_) return std::nullopt;
  const auto terrain = evaluate(*terrain_, x, y);
  if (!terrain || !borders_) return terrain;
  const auto border = borders_->nearest(x, y);
  if (!border) return terrain;
  // z = e + w (g - e), w = u^2 (3 - 2 u), u = distance / verge; its gradient by the product rule.
  const double u = border->distance_m / verge_m_, w = u * u * (3.0 - 2.0 * u);
  const double dw_dd = 6.0 * u * (1.0 - u) / verge_m_, rise = terrain->z - border->z;
  const double away = border->distance_m > 0.0 ? 1.0 / border->distance_m : 0.0;
  return TerrainPoint{border->z + w * rise,
                      border->dz_dx + w * (terrain->dz_dx - border->dz_dx) + rise * dw_dd * (x - border->x) * away,
                      border->dz_dy + w * (terrain->dz_dy - border->dz_dy) + rise * dw_dd * (y - border->y) * away};
}

SurfacePoint GroundQuery::point(int road, double s, double t) const {
  const auto index = static_cast<std::size_t>(road);
  SurfacePoint point = surface_point(roads_.map().roads[index], s, t);
  const auto own = roads_.at(index, s, t);
  if (!own) return point;
  point.z = own->z;
  for (std::size_t k = 0; k < 3; ++k) point.normal[k] = own->normal[k];
  return point;
}

GroundQuery read_ground(const GroundFiles& files, GroundStage& stage) {
  stage = GroundStage::network;
  RoadMap map = read_opendrive(files.network, files.offset);
  std::optional<TerrainGrid> terrain;
  if (!files.terrain.empty()) {
    stage = GroundStage::terrain;
    terrain = read_terrain_grid(files.terrain);
    if (map.header_offset_hdg != 0.0 && files.offset != HeaderOffset::add)
      throw std::runtime_error(files.terrain +
                               ": cannot be laid under roads whose <offset> has a heading, unless it is added");
    move_to_roads(*terrain, map, files.offset);
  }
  if (!files.ignore_crg) {
    stage = GroundStage::crg;
    const std::string beside = std::filesystem::path(files.network).parent_path().string();
    map.crgs = std::make_shared<const RoadCrgs>(map, files.crg_folder.value_or(beside.empty() ? "." : beside));
  }
  stage = GroundStage::network;
  return GroundQuery(std::move(map), std::move(terrain), files.verge_m);
}

}  // namespace roadquery

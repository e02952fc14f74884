// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/ground_surface.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr double on_border_m = 2.0 * plan_grid_m;
constexpr double abutment_gap_m = 0.05, abutment_slope = 0.3;  // clearance below a deck by distance to a ground road

double smoothstep(double u) { return u * u * (3.0 - 2.0 * u); }

}  // namespace

Ground::Ground(HeightGrid filled_terrain, const RoadLevel& roads, std::span<const RoadLevel> decks,
               const Waters& waters, const GroundOptions& options)
    : terrain_(std::move(filled_terrain)), roads_(&roads), decks_(decks), waters_(&waters), options_(options) {}

double Ground::terrain_m(Vec2 p) const {
  const Box2 b = terrain_.frame.bounds();
  return sample_bilinear(terrain_, {std::clamp(p.x, b.min_x, b.max_x), std::clamp(p.y, b.min_y, b.max_y)});
}

double Ground::height_m(Vec2 p) const {
  const NearestBorder border = roads_->outline().nearest(p);
  const bool on_border = border.distance_m <= on_border_m;
  const auto road = roads_->sample(p, on_border ? RoadLevel::sample_reach_m : 0.0);
  if (road && (road->inside_m > 0.0 || on_border)) return road->z_m;
  if (const WaterBody* water = waters_->at(p)) return water->level_m;
  double z = terrain_m(p);
  if (border.distance_m < options_.verge_m)
    z = border.z_m + (z - border.z_m) * smoothstep(border.distance_m / options_.verge_m);
  for (const RoadLevel& deck : decks_) {
    const auto above = deck.sample(p);
    if (!above) continue;
    const double clearance_m = std::min(options_.deck_clearance_m, abutment_gap_m + abutment_slope * border.distance_m);
    z = std::min(z, above->z_m - clearance_m);
  }
  return z;
}

Vec3 Ground::normal(Vec2 p) const {
  constexpr double h = 1.0;
  const double dx = (height_m({p.x + h, p.y}) - height_m({p.x - h, p.y})) / (2.0 * h);
  const double dy = (height_m({p.x, p.y + h}) - height_m({p.x, p.y - h})) / (2.0 * h);
  const double n = std::sqrt(1.0 + dx * dx + dy * dy);
  return {-dx / n, -dy / n, 1.0 / n};
}

}  // namespace orthodrive::scene

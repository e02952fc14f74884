// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/generic_terrain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/scene/roads/crossing_roads.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr float unknown_m = std::numeric_limits<float>::quiet_NaN(), endless_m = std::numeric_limits<float>::infinity();
constexpr double longest_step_m = 2.0;       // of places on roads
constexpr double tunnel_cover_m = 7.0;       // over the road: the tube, its slab and some ground
constexpr double ground_below_deck_m = 1.1;  // as Ground has it below decks of 0.8 m
constexpr double deck_end_slope = 0.3;       // clearance below a deck by the distance to its end
constexpr double apart_levels_m = 1.5;       // more between two roads: one lies over the other (crossing_roads.hpp)
constexpr double abutment_reach_m = 15.0;    // so near to the lower one the upper one stands on no ground
constexpr double least_normal_z = 0.2;       // steeper surfaces are not carried on to the middle of a cell
constexpr int least_side = 4;                // of the coarsest raster, cells
constexpr int first_sweeps = 400, sweeps = 80;
constexpr float relaxation = 1.8F;  // of 1 to 2; 2 / (1 + sin(pi / n)) for n cells between two roads: 28

/// What is known of the cells' heights: fixed, or bounds.
struct MembraneBounds {
  Raster<float> fixed_m;        ///< NaN: free
  Raster<float> low_m, high_m;  ///< of free cells
};

/// A place on a road's surface.
struct RoadPlaceOn {
  roadquery::SurfacePoint at;
  double to_end_m = 0.0;  ///< along the road
};

/// Calls visit(place) at most longest_step_m apart along the road and across it, for places with finite heights.
template <typename Visit>
void visit_surface(const roadquery::Road& road, double step_m, const Visit& visit) {
  if (!(road.length > 0.0) || road.plan.empty() || road.sections.empty()) return;
  const int along = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
  for (int i = 0; i <= along; ++i) {
    const double s = road.length * i / along;
    const roadquery::PlanPoint reference = roadquery::reference_point(road, s);
    const roadquery::Edges edges = roadquery::road_edges(road, s);
    const double width_m = edges.left_t - edges.right_t;
    if (!std::isfinite(width_m)) continue;
    const int across = std::max(1, static_cast<int>(std::ceil(width_m / step_m)));
    for (int k = 0; k <= across; ++k) {
      const RoadPlaceOn place{roadquery::surface_point(road, s, edges.right_t + width_m * k / across, reference),
                              std::min(s, road.length - s)};
      if (std::isfinite(place.at.x + place.at.y + place.at.z)) visit(place);
    }
  }
}

/// As if no lane lay higher: kerbs are no ground.
roadquery::RoadMap without_lane_heights(const roadquery::RoadMap& roads) {
  roadquery::RoadMap flat = roads;
  roadquery::remove_lane_heights(flat);
  return flat;
}

[[noreturn]] void throw_no_surface(const std::string& name) {
  throw InputError(name, "has no road with a surface, give a network with lanes");
}

/// Gathers what roads say of the cells.
class RoadCells {
 public:
  explicit RoadCells(const GridFrame& frame)
      : frame_(frame),
        sum_m_(frame.width, frame.height),
        places_(frame.width, frame.height),
        bounds_{Raster<float>(frame.width, frame.height, 1, unknown_m),
                Raster<float>(frame.width, frame.height, 1, -endless_m),
                Raster<float>(frame.width, frame.height, 1, endless_m)} {}

  void lay_ground(const RoadPlaceOn& place) {
    visit_cell(place, 0.0, [&](int col, int row, float z) { add(col, row, z); });
  }
  void lay_deck(const RoadPlaceOn& place) {
    visit_cell(place, -clearance_m(place), [&](int col, int row, float z) {
      bounds_.high_m.at(col, row) = std::min(bounds_.high_m.at(col, row), z);
    });
  }
  void lay_tunnel(const RoadPlaceOn& place) {
    visit_cell(place, tunnel_cover_m, [&](int col, int row, float z) {
      bounds_.low_m.at(col, row) = std::max(bounds_.low_m.at(col, row), z);
    });
  }
  /// Of a road that lies over another one somewhere: away from that one it lies on the ground. Those of the ground are
  /// settled.
  void lay_over(const RoadPlaceOn& place) {
    lay_deck(place);
    visit_cell(place, -clearance_m(place), [&](int col, int row, float z) {
      if (std::isnan(bounds_.fixed_m.at(col, row)) && !is_over_ground_road(col, row, z)) add(col, row, z);
    });
  }
  /// Means of what was laid since become fixed heights.
  void settle() {
    for (std::size_t i = 0; i < places_.data.size(); ++i) {
      if (places_.data[i] > 0) bounds_.fixed_m.data[i] = sum_m_.data[i] / static_cast<float>(places_.data[i]);
      sum_m_.data[i] = 0.0F, places_.data[i] = 0;
    }
  }
  [[nodiscard]] MembraneBounds take() {
    for (std::size_t i = 0; i < bounds_.low_m.data.size(); ++i)  // a tunnel below a deck
      bounds_.low_m.data[i] = std::min(bounds_.low_m.data[i], bounds_.high_m.data[i]);
    return std::move(bounds_);
  }

 private:
  void add(int col, int row, float z) { sum_m_.at(col, row) += z, ++places_.at(col, row); }
  [[nodiscard]] double clearance_m(const RoadPlaceOn& place) const {
    return std::min(ground_below_deck_m, deck_end_slope * place.to_end_m);
  }
  /// Calls visit(col, row, z) with the height in the middle of the cell: that of the surface's tangent plane.
  template <typename Visit>
  void visit_cell(const RoadPlaceOn& place, double more_m, const Visit& visit) const {
    const Vec2 at = frame_.pixel_from_world({place.at.x, place.at.y});
    const int col = static_cast<int>(std::floor(at.x)), row = static_cast<int>(std::floor(at.y));
    if (!places_.inside(col, row)) return;
    const Vec2 off = frame_.center_of(col, row) - Vec2{place.at.x, place.at.y};
    const double* n = place.at.normal;
    const double rise_m = n[2] > least_normal_z ? -(n[0] * off.x + n[1] * off.y) / n[2] : 0.0;
    visit(col, row, static_cast<float>(place.at.z + rise_m + more_m));
  }
  [[nodiscard]] bool is_over_ground_road(int col, int row, float z) const {
    const int reach = static_cast<int>(std::ceil(abutment_reach_m / frame_.gsd_m));
    for (int r = row - reach; r <= row + reach; ++r)
      for (int c = col - reach; c <= col + reach; ++c)
        if (places_.inside(c, r) && z - bounds_.fixed_m.at(c, r) > apart_levels_m) return true;
    return false;
  }

  GridFrame frame_;
  Raster<float> sum_m_;
  Raster<int> places_;
  MembraneBounds bounds_;
};

MembraneBounds bounds_by_roads(const roadquery::RoadMap& with_kerbs, const GridFrame& frame) {
  const roadquery::RoadMap roads = without_lane_heights(with_kerbs);
  const std::vector<bool> over = lying_over(roads.roads);
  const double step_m = std::min(longest_step_m, 0.5 * frame.gsd_m);
  RoadCells cells(frame);
  for (std::size_t i = 0; i < over.size(); ++i) {
    const RoadStructure where = structure_of(roads.roads[i], false);
    visit_surface(roads.roads[i], step_m, [&](const RoadPlaceOn& place) {
      if (where == RoadStructure::tunnel)
        cells.lay_tunnel(place);
      else if (where == RoadStructure::deck)
        cells.lay_deck(place);
      else if (!over[i])
        cells.lay_ground(place);
    });
  }
  cells.settle();
  for (std::size_t i = 0; i < over.size(); ++i)
    if (over[i]) visit_surface(roads.roads[i], step_m, [&](const RoadPlaceOn& place) { cells.lay_over(place); });
  cells.settle();
  return cells.take();
}

/// Of two by two cells.
MembraneBounds halved(const MembraneBounds& fine) {
  const int width = (fine.fixed_m.width + 1) / 2, height = (fine.fixed_m.height + 1) / 2;
  MembraneBounds half{Raster<float>(width, height, 1, unknown_m), Raster<float>(width, height, 1, -endless_m),
                      Raster<float>(width, height, 1, endless_m)};
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      float sum = 0.0F, count = 0.0F;
      for (int k = 0; k < 4; ++k) {
        const int c = 2 * col + k % 2, r = 2 * row + k / 2;
        if (!fine.fixed_m.inside(c, r)) continue;
        if (const float z = fine.fixed_m.at(c, r); !std::isnan(z)) sum += z, ++count;
        half.low_m.at(col, row) = std::max(half.low_m.at(col, row), fine.low_m.at(c, r));
        half.high_m.at(col, row) = std::min(half.high_m.at(col, row), fine.high_m.at(c, r));
      }
      if (count > 0.0F) half.fixed_m.at(col, row) = sum / count;
      half.low_m.at(col, row) = std::min(half.low_m.at(col, row), half.high_m.at(col, row));
    }
  }
  return half;
}

/// Moves the free cells of one colour towards the mean of their neighbours, within their bounds.
void relax(const MembraneBounds& bounds, int colour, Raster<float>& z_m) {
  for (int row = 0; row < z_m.height; ++row) {
    for (int col = (row + colour) % 2; col < z_m.width; col += 2) {
      if (!std::isnan(bounds.fixed_m.at(col, row))) continue;
      float sum = 0.0F, count = 0.0F;
      if (col > 0) sum += z_m.at(col - 1, row), ++count;
      if (col + 1 < z_m.width) sum += z_m.at(col + 1, row), ++count;
      if (row > 0) sum += z_m.at(col, row - 1), ++count;
      if (row + 1 < z_m.height) sum += z_m.at(col, row + 1), ++count;
      if (count == 0.0F) continue;
      float& z = z_m.at(col, row);
      z = std::clamp(z + relaxation * (sum / count - z), bounds.low_m.at(col, row), bounds.high_m.at(col, row));
    }
  }
}

/// Mean of all that is known, where a solution begins.
float mean_known(const MembraneBounds& bounds) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < bounds.fixed_m.data.size(); ++i) {
    for (const float z : {bounds.fixed_m.data[i], bounds.low_m.data[i], bounds.high_m.data[i]})
      if (std::isfinite(z)) sum += static_cast<double>(z), ++count;
  }
  return count > 0.0 ? static_cast<float>(sum / count) : unknown_m;
}

Raster<float> solve(const MembraneBounds& bounds) {
  const bool is_coarsest = std::max(bounds.fixed_m.width, bounds.fixed_m.height) <= least_side;
  Raster<float> z_m(bounds.fixed_m.width, bounds.fixed_m.height, 1, is_coarsest ? mean_known(bounds) : 0.0F);
  if (!is_coarsest) {
    const Raster<float> half = solve(halved(bounds));
    for (int row = 0; row < z_m.height; ++row)
      for (int col = 0; col < z_m.width; ++col) z_m.at(col, row) = half.at(col / 2, row / 2);
  }
  for (std::size_t i = 0; i < z_m.data.size(); ++i) {
    const float fixed = bounds.fixed_m.data[i];
    z_m.data[i] = std::isnan(fixed) ? std::clamp(z_m.data[i], bounds.low_m.data[i], bounds.high_m.data[i]) : fixed;
  }
  for (int i = 0; i < (is_coarsest ? first_sweeps : sweeps); ++i) relax(bounds, 0, z_m), relax(bounds, 1, z_m);
  return z_m;
}

}  // namespace

Polygon area_around_roads(const roadquery::RoadMap& roads, double margin_m, const std::string& name) {
  constexpr double step_m = 10.0, widest_m = 200e3;
  constexpr int corners = 16;
  std::vector<Vec2> points;
  for (const roadquery::Road& road : roads.roads)
    visit_surface(road, step_m, [&](const RoadPlaceOn& place) { points.push_back({place.at.x, place.at.y}); });
  if (points.empty()) throw_no_surface(name);
  const Box2 box = bounds_of(points);
  if (const double wide_m = std::max(box.width(), box.height()); wide_m > widest_m)
    throw InputError(name, fmt::format("has roads {:.0f} km apart, a landscape holds {:.0f} km; are they in metres, or "
                                       "is one misplaced?",
                                       1e-3 * wide_m, 1e-3 * widest_m));
  const Ring hull = convex_hull(points);
  const std::vector<Vec2>& inner = hull.size() >= 3 ? hull : points;  // roads on one straight line have no hull
  std::vector<Vec2> around;
  for (const Vec2 p : inner) {
    for (int k = 0; k < corners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / corners;
      around.push_back(p + Vec2{std::cos(angle), std::sin(angle)} * margin_m);
    }
  }
  return {convex_hull(std::move(around)), {}};
}

HeightGrid generic_terrain(const roadquery::RoadMap& roads, const Box2& box, const std::string& name,
                           const GenericTerrainOptions& options) {
  const double cell_m = std::max(options.cell_m, std::sqrt(box.width() * box.height() / options.most_cells));
  HeightGrid grid{{roads.geo_reference}, covering_grid(box, cell_m), {}, {}};
  const MembraneBounds bounds = bounds_by_roads(roads, grid.frame);
  if (std::isnan(mean_known(bounds))) throw_no_surface(name);
  grid.height_m = solve(bounds);
  return grid;
}

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#include "roadquery/tables/junction_levels.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/surface/blend.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/tables/baked_surface.hpp"
#include "roadquery/tables/overlaps.hpp"

namespace roadquery {
namespace {

// Heights are compared at corners and nodes: between them surfaces differ by less than the rest of same_level_m.
constexpr double widest_band_m = 0.6 * same_level_m;

/// Heights over the plane of a station's middle, so that a gradient counts for nothing.
class Band {
 public:
  explicit Band(const Station& q) : q_(q), slope_(q.profile[0][1]), tilt_(std::tan(static_cast<double>(q.bank))) {}

  void add(double x, double y, double z) {
    const FramePoint p = in_frame(q_, x, y);
    const double over = z - q_.z - slope_ * p.along - tilt_ * p.left;
    low_ = std::min(low_, over), high_ = std::max(high_, over);
    finite_ = finite_ && std::isfinite(over);
  }
  void add(const BakedRoads& roads, const Station& other) {
    const LaneStretch& lanes = roads.stretches[other.lanes];
    for (const double u : {-static_cast<double>(other.half_m), static_cast<double>(other.half_m)}) {
      const double ds = other.s + u - lanes.s;
      const LinePolynomial line = line_at(other, u);
      const Pair edges = cubics_at(lanes.edges, ds);
      for (const double t : {edges[0], 0.0, edges[1]}) {
        SurfacePlace place;
        surface_at_t(roads, other, u, t, place);
        const FramePoint at = place_beside(line, {place.ahead_m, t});
        add(other.x + at.along * other.cos_hdg - at.left * other.sin_hdg,
            other.y + at.along * other.sin_hdg + at.left * other.cos_hdg, place.z);
      }
    }
  }
  /// The nodes of the field that count somewhere in the station's box, and the arms near it.
  void add(const JunctionSurface& surface, const StationBox& box) {
    const double beyond = 2.0 * surface.spacing_m;
    const double reach =
        beyond + std::max({-box.along_min, box.along_max, -box.left_min, box.left_max}) * std::sqrt(2.0);
    const int stride = std::max(1, static_cast<int>(1.0 / surface.spacing_m));  // nodes are smooth: one a metre
    const auto node = [&](double v, double origin, int count) {
      return static_cast<int>(std::clamp((v - origin) / surface.spacing_m, 0.0, std::max(count - 1.0, 0.0)));
    };
    const int first_column = node(q_.x - reach, surface.x, surface.columns),
              last_column = node(q_.x + reach, surface.x, surface.columns);
    for (int row = node(q_.y - reach, surface.y, surface.rows); row <= node(q_.y + reach, surface.y, surface.rows);
         row += stride) {
      for (int column = first_column; column <= last_column; column += stride) {
        const auto k = static_cast<std::size_t>(row) * static_cast<std::size_t>(surface.columns) +
                       static_cast<std::size_t>(column);
        if (k < surface.z.size())
          add_near(box, beyond, surface.x + column * surface.spacing_m, surface.y + row * surface.spacing_m,
                   surface.z[k]);
      }
    }
    for (const JunctionArm& arm : surface.arms)
      for (const double inside_m : {-junction_transition_m, 0.0, junction_transition_m})
        for (const JunctionArm::Place& place : arm.places) {
          const double in_m = place.in_m + inside_m;
          add_near(box, beside_arm_m + junction_transition_m, arm.x + in_m * arm.in_x - place.left_m * arm.in_y,
                   arm.y + in_m * arm.in_y + place.left_m * arm.in_x, arm_height(arm, in_m, place.left_m));
        }
  }
  [[nodiscard]] bool is_one_level() const { return finite_ && high_ - low_ <= widest_band_m; }

 private:
  void add_near(const StationBox& box, double beyond, double x, double y, double z) {
    const FramePoint p = in_frame(q_, x, y);
    if (p.along >= box.along_min - beyond && p.along <= box.along_max + beyond && p.left >= box.left_min - beyond &&
        p.left <= box.left_max + beyond)
      add(x, y, z);
  }

  const Station& q_;
  double slope_, tilt_, low_ = 1e30, high_ = -1e30;
  bool finite_ = true;
};

bool is_one_level(const BakedRoads& roads, const RoadMap& map, std::uint32_t station, const StationBox& box,
                  const std::vector<std::uint32_t>& junctions) {
  const Station& q = roads.stations[station];
  Band band(q);
  band.add(roads, q);
  for (std::uint32_t i = roads.companion_begin[station]; i < roads.companion_begin[station + 1]; ++i) {
    const StationRange& range = roads.companions[i].range;
    if (roads.road_of(roads.stations[range.first]) == roads.road_of(q)) return false;
    for (std::uint32_t k = range.first; k <= range.last; ++k) band.add(roads, roads.stations[k]);
  }
  for (const std::uint32_t junction : junctions) band.add(*surface_of(map.junctions[junction]), box);
  return band.is_one_level();
}

/// The part of a station's width within its edges, by near_place(). None where that misses the foot by too much.
void find_core(const BakedRoads& roads, const Station& q, StationJunction& junction) {
  constexpr double margin_m = 0.25;  // what is between the places that are looked at, and of near_place()
  constexpr int parts = 8;
  const LaneStretch& lanes = roads.stretches[q.lanes];
  double right = -1e30, left = 1e30;
  for (int k = 0; k <= parts; ++k) {
    const double u = q.half_m * (2.0 * k / parts - 1.0);
    const LinePolynomial line = line_at(q, u);
    const Pair edges = cubics_at(lanes.edges, q.s + u - lanes.s);
    for (const int side : {0, 1}) {
      SurfacePlace place;
      surface_at_t(roads, q, u, edges[side], place);
      const double left_m = place.t * place.cos_bank - place.h * place.sin_bank;
      const FramePoint at = place_beside(line, {place.ahead_m, left_m});
      const NearPlace near = near_place(q, q.x + at.along * q.cos_hdg - at.left * q.sin_hdg,
                                        q.y + at.along * q.sin_hdg + at.left * q.cos_hdg);
      if (!(std::abs(near.u - u) <= end_margin_m(q) && std::abs(near.left_m - left_m) <= 0.5 * margin_m)) return;
      if (side == 0)
        right = std::max(right, near.left_m);
      else
        left = std::min(left, near.left_m);
    }
  }
  const auto steps = [](double t) { return static_cast<std::int8_t>(std::clamp(t, -127.0, 127.0)); };
  junction.core_right = steps(std::ceil((right + margin_m) / free_step_m));
  junction.core_left = steps(std::floor((left - margin_m) / free_step_m));
}

}  // namespace

void find_levels(BakedRoads& roads, const RoadMap& map, const CellIndex& cells) {
  std::vector<std::uint32_t> junctions;
  for (std::uint32_t i = 0; i < roads.stations.size(); ++i) {
    StationJunction& junction = roads.deciding_junction[i];
    if (junction.index == no_index) continue;
    const Station& q = roads.stations[i];
    const StationBox box = station_box(roads, q);
    junctions.clear();
    cells.append_junctions(q, box, junctions);
    if (!is_one_level(roads, map, i, box, junctions))
      junction.index = no_index;
    else if (junction.index < one_of_several)
      find_core(roads, q, junction);
  }
}

}  // namespace roadquery

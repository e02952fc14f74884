// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/networks/track_samples.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/model/roads/traffic_calming.hpp"

namespace orthodrive::evaluate {
namespace {

constexpr double mirror_room_m = 0.4;  // a lane is wider than a track by this, at least
constexpr double same_place_m = 0.02;  // ends of linked lanes: one sample is enough

double speed_at(const PathPoint& at, double curvature) {
  const double limit = at.piece->road->speed_limit_mps;
  const double legal =
      std::min(limit > 0.0 ? limit : judged::unlimited_speed_mps, hump_speed_mps(*at.piece->road, at.s));
  return std::abs(curvature) < 1e-9 ? legal : std::min(legal, std::sqrt(judged::lateral_mps2 / std::abs(curvature)));
}

}  // namespace

void append_places(const LanePiece& piece, double from_m, double to_m, double step_m, std::vector<PathPoint>& path) {
  const int steps = std::max(1, static_cast<int>(std::ceil((to_m - from_m) / step_m - 1e-6)));
  for (int i = 0; i <= steps; ++i) path.push_back({&piece, piece.s_at(from_m + (to_m - from_m) * i / steps)});
}

roadquery::SurfacePoint lane_point(const PathPoint& at, double left_m) {
  const LanePlace place = lane_place(*at.piece, at.s);
  return roadquery::surface_point(*at.piece->road, at.s, place.centre_t + (at.piece->forward ? left_m : -left_m),
                                  place.reference);
}

std::vector<std::vector<AxleSample>> sample_axles(const roadquery::RoadQuery& query,
                                                  const std::vector<PathPoint>& path) {
  std::vector<std::vector<AxleSample>> runs(1);
  std::array<roadquery::Cursor, 2> cursors;
  double driven = 0.0;
  roadquery::SurfacePoint before;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const PathPoint& at = path[i];
    const LanePlace place = lane_place(*at.piece, at.s);
    const double side = at.piece->forward ? 1.0 : -1.0;
    const roadquery::SurfacePoint middle =
        roadquery::surface_point(*at.piece->road, at.s, place.centre_t, place.reference);
    const double moved = i > 0 ? std::hypot(middle.x - before.x, middle.y - before.y) : 0.0;
    before = middle, driven += moved;
    if (place.width_m < judged::least_lane_m) {
      if (!runs.back().empty()) runs.emplace_back();
      continue;
    }
    if (!runs.back().empty() && moved < same_place_m && runs.back().back().at.piece != at.piece) continue;
    AxleSample axle{.at = at, .driven_m = driven, .heading_rad = place.heading_rad, .curvature = place.curvature};
    axle.width_m = place.width_m;
    axle.speed_mps = speed_at(at, place.curvature);
    axle.track_m = std::min(judged::track_m, place.width_m - mirror_room_m);
    for (std::size_t wheel = 0; wheel < 2; ++wheel) {
      const double left = (wheel == 0 ? 0.5 : -0.5) * axle.track_m;
      const roadquery::SurfacePoint p =
          roadquery::surface_point(*at.piece->road, at.s, place.centre_t + side * left, place.reference);
      const WheelSample* last = runs.back().empty() ? nullptr : &runs.back().back().wheels[wheel];
      const auto hit = query.find(p.x, p.y, last && last->on_road ? last->z : p.z, cursors[wheel]);
      axle.wheels[wheel] = {p.x, p.y, hit ? hit->z : p.z, hit ? hit->friction : 1.0, hit.has_value()};
    }
    runs.back().push_back(axle);
  }
  if (runs.back().empty()) runs.pop_back();
  return runs;
}

}  // namespace orthodrive::evaluate

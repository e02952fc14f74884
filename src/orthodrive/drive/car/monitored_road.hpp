// SPDX-License-Identifier: Apache-2.0
#pragma once
// The roads under a car's wheels, with note of where there is none and where it has a step.

#include <array>
#include <cmath>
#include <cstdint>

#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/blend.hpp"
#include "vehicle/ground.hpp"

namespace orthodrive {

/// Beside the road the ground goes on as the plane of that wheel's last contact. A bridge above or a street below that
/// place is another level: no wheel gets there by leaving its road.
class MonitoredRoad final : public vehicle::Ground {
 public:
  explicit MonitoredRoad(const roadquery::RoadQuery& query) : query_(query) {}

  [[nodiscard]] vehicle::GroundPoint at(int wheel, double x_m, double y_m, double z_guess_m) override {
    Contact& last = contacts_[static_cast<std::size_t>(wheel)];
    const auto& n = last.point.normal;
    // What the tangent plane at the last contact promises here.
    const double promised_m =
        last.known ? last.point.z_m - (n[0] * (x_m - last.x_m) + n[1] * (y_m - last.y_m)) / n[2] : z_guess_m;
    const auto hit = query_.find(x_m, y_m, last.known ? last.point.z_m : z_guess_m, last.cursor);
    ++queries_;
    if (!hit || (last.known && !roadquery::is_same_level(hit->z, promised_m))) {
      ++missed_;
      last.on_road = false;
      return {promised_m, n, last.point.friction, false};
    }
    if (last.known && last.on_road) step_m_ = std::max(step_m_, std::abs(hit->z - promised_m));
    last.x_m = x_m, last.y_m = y_m;
    last.point = {hit->z, hit->normal, hit->friction, true};
    last.known = last.on_road = true;
    return last.point;
  }

  /// Largest step of a height and wheels without road since the last call.
  struct Seen {
    double step_m = 0.0;
    int missed = 0;
    int queries = 0;
  };
  [[nodiscard]] Seen take() {
    const Seen seen{step_m_, missed_, queries_};
    step_m_ = 0.0, missed_ = 0, queries_ = 0;
    return seen;
  }

 private:
  struct Contact {
    roadquery::Cursor cursor;
    vehicle::GroundPoint point;
    double x_m = 0.0, y_m = 0.0;
    bool known = false, on_road = false;
  };
  const roadquery::RoadQuery& query_;
  std::array<Contact, 4> contacts_;
  double step_m_ = 0.0;
  int missed_ = 0, queries_ = 0;
};

}  // namespace orthodrive

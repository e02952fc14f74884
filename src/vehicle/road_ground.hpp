// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads as the ground of a car.

#include <array>
#include <cmath>

#include "roadquery/query/road_query.hpp"
#include "vehicle/ground.hpp"

namespace vehicle {

/// The surface of a RoadQuery. Beside the road the ground goes on as the plane of the last contact of that wheel, with
/// on_road = false, so that a car that leaves the road still stands on something.
class RoadGround final : public Ground {
 public:
  explicit RoadGround(const roadquery::RoadQuery& query) : query_(query) {}

  [[nodiscard]] GroundPoint at(int wheel, double x_m, double y_m, double z_guess_m) override {
    Contact& contact = contacts_[static_cast<std::size_t>(wheel)];
    const auto hit = query_.find(x_m, y_m, z_guess_m, contact.cursor);
    if (hit) {
      contact.x_m = x_m;
      contact.y_m = y_m;
      contact.point = {hit->z, hit->normal, hit->friction, true};
      contact.known = true;
      return contact.point;
    }
    GroundPoint beside = contact.point;
    beside.on_road = false;
    const auto& n = contact.point.normal;
    beside.z_m = contact.known ? contact.point.z_m - (n[0] * (x_m - contact.x_m) + n[1] * (y_m - contact.y_m)) / n[2]
                               : z_guess_m;
    return beside;
  }

  [[nodiscard]] const roadquery::Cursor& cursor(int wheel) const {
    return contacts_[static_cast<std::size_t>(wheel)].cursor;
  }

 private:
  struct Contact {
    roadquery::Cursor cursor;
    GroundPoint point;
    double x_m = 0.0, y_m = 0.0;
    bool known = false;
  };
  const roadquery::RoadQuery& query_;
  std::array<Contact, 4> contacts_;
};

}  // namespace vehicle

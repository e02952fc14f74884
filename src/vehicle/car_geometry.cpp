// SPDX-License-Identifier: Apache-2.0
#include "vehicle/car_geometry.hpp"

#include <cmath>

namespace vehicle {

double static_load_n(const CarParameters& car, bool front) {
  const double share = front ? car.body.front_share : 1.0 - car.body.front_share;
  return 0.5 * share * car.body.mass_kg * gravity_mps2;
}

CarGeometry car_geometry(const CarParameters& car) {
  const Body& b = car.body;
  CarGeometry g;
  g.mass_kg = b.mass_kg;
  // First with the car's origin as origin.
  const Vec3 cg{b.wheelbase_m * (b.front_share - 0.5), 0.0, b.cg_height_m};
  Vec3 sum = b.mass_kg * cg;
  g.body.mass_kg = b.mass_kg;
  for (std::size_t i = 0; i < 4; ++i) {
    const bool front = i < 2;
    const Suspension& s = front ? car.front : car.rear;
    const Tyre& t = front ? car.front_tyre : car.rear_tyre;
    WheelGeometry& w = g.wheels[i];
    w.side = i % 2 == 0 ? 1.0 : -1.0;
    w.mass_kg = s.unsprung_mass_kg;
    w.static_load_n = static_load_n(car, front);
    // The wheel leans, so its loaded radius is not quite upright.
    const double loaded_m = (t.radius_m - w.static_load_n / t.vertical_npm) / std::hypot(1.0, s.camber_rad);
    w.hub = {front ? 0.5 * b.wheelbase_m : -0.5 * b.wheelbase_m, 0.5 * w.side * s.track_m, loaded_m};
    // Anti-dive, anti-squat: the front wheel moves ahead in bump, the rear wheel back.
    const double ahead = front ? 1.0 : -1.0;
    w.path = {ahead * std::tan(s.drive_support_rad), w.side * s.roll_centre_m / (0.5 * s.track_m), 1.0};
    w.turn_per_travel = ahead * (std::tan(s.drive_support_rad) - std::tan(s.brake_support_rad)) / loaded_m;
    sum += -w.mass_kg * w.hub;
    g.body.mass_kg -= w.mass_kg;
  }
  const Vec3 body_cg = (1.0 / g.body.mass_kg) * sum;

  Inertia& i = g.body.inertia;
  i = {b.roll_inertia_kgm2, b.pitch_inertia_kgm2, b.yaw_inertia_kgm2, 0.0, -b.roll_yaw_product_kgm2, 0.0};
  const auto remove = [&](double mass, const Vec3& r) {  // a point mass at r from the c.g. of all
    i.xx -= mass * (r.y * r.y + r.z * r.z);
    i.yy -= mass * (r.x * r.x + r.z * r.z);
    i.zz -= mass * (r.x * r.x + r.y * r.y);
    i.xy += mass * r.x * r.y;
    i.xz += mass * r.x * r.z;
    i.yz += mass * r.y * r.z;
  };
  for (const WheelGeometry& w : g.wheels) remove(w.mass_kg, w.hub - cg);
  remove(g.body.mass_kg, body_cg - cg);  // Steiner, back to the body's own c.g.
  for (WheelGeometry& w : g.wheels) w.hub = w.hub - body_cg;
  g.origin = -body_cg;
  g.cg = cg - body_cg;
  return g;
}

std::array<double, 2> front_wheel_angles(const CarParameters& car, double mean_rad) {
  const double tangent = std::tan(mean_rad), share = car.steering.ackermann_share;
  const double part = 0.5 * car.front.track_m / car.body.wheelbase_m * tangent;
  return {(1.0 - share) * mean_rad + share * std::atan2(tangent, 1.0 - part),
          (1.0 - share) * mean_rad + share * std::atan2(tangent, 1.0 + part)};
}

}  // namespace vehicle

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/axle_slip.hpp"

#include <algorithm>
#include <cmath>

#include "vehicle/envelope.hpp"

namespace orthodrive {
namespace {

/// Side force of a tyre at a small camber-free slip angle, Magic Formula (Pacejka 2012, 4.E19 - 4.E30) at load F_z.
struct SideForce {
  double b = 0.0, c = 0.0, d = 0.0, e = 0.0;
  SideForce(const vehicle::Tyre& tyre, double load_n) {
    const double df = (load_n - tyre.nominal_load_n) / tyre.nominal_load_n;
    const double stiffness = std::abs(tyre.p_ky1) * tyre.nominal_load_n *
                             std::sin(2.0 * std::atan(load_n / (std::abs(tyre.p_ky2) * tyre.nominal_load_n)));
    c = tyre.p_cy1, d = std::abs(tyre.p_dy1 + tyre.p_dy2 * df) * load_n, e = tyre.p_ey1;
    b = stiffness / (c * d);
  }
  [[nodiscard]] double at(double angle_rad) const {
    const double x = b * angle_rad;
    return d * std::sin(c * std::atan(x - e * (x - std::atan(x))));
  }
};

}  // namespace

AxleSlip::AxleSlip(const vehicle::CarParameters& car, bool front) {
  constexpr double most_rad = 0.35, step_rad = 2e-4;
  const vehicle::Tyre& tyre = front ? car.front_tyre : car.rear_tyre;
  const double axle_share = front ? car.body.front_share : 1.0 - car.body.front_share;
  const double wheel_n = 0.5 * car.body.mass_kg * axle_share * vehicle::gravity_mps2;
  // A bend moves load from the inner to the outer wheel, and the outer gains less than the inner loses.
  const double transfer = 2.0 * car.body.cg_height_m / (front ? car.front : car.rear).track_m;
  const auto share_at = [&](double angle_rad, double share) {
    const double moved = std::min(transfer * share, 0.95);
    // Across the way of the axle: a tyre far out of its way pulls backwards instead.
    return 0.5 * std::cos(angle_rad) *
           (SideForce(tyre, wheel_n * (1.0 + moved)).at(angle_rad) +
            SideForce(tyre, wheel_n * (1.0 - moved)).at(angle_rad)) /
           wheel_n;
  };
  const auto angle_for = [&](double share) {
    double angle = 0.0;
    while (angle < most_rad && share_at(angle, share) < share) angle += step_rad;
    return angle;
  };
  double able = 0.0, too_much = 5.0;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (able + too_much);
    (angle_for(middle) < most_rad ? able : too_much) = middle;
  }
  peak_share_ = able, peak_rad_ = angle_for(able);
  for (std::size_t i = 0; i < entries; ++i)
    angle_rad_[i] = angle_for(peak_share_ * static_cast<double>(i) / static_cast<double>(entries - 1));
}

double AxleSlip::angle_rad(double force_share) const {
  const double place = std::min(std::abs(force_share) / peak_share_, 1.0) * static_cast<double>(entries - 1);
  const auto i = std::min(static_cast<std::size_t>(place), entries - 2);
  const double u = place - static_cast<double>(i);
  return std::copysign(angle_rad_[i] + u * (angle_rad_[i + 1] - angle_rad_[i]), force_share);
}

}  // namespace orthodrive

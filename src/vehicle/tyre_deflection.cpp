// SPDX-License-Identifier: Apache-2.0
#include "vehicle/tyre_deflection.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vehicle {
namespace {

// Below this speed the tyre gets a damper and its deflection a bound. Pacejka's V_low in sec. 8.6 is 2.5 m/s, too.
constexpr double low_speed_mps = 2.5;
// Damper over spring at rest. With this, a car of 400 kg a wheel on tyres of 400 kN/m swings with a tenth of critical
// damping; longer times would make the spin of the wheel stiff at steps of 2 ms.
constexpr double damping_s = 0.006;
// Deflection at rest, in units of the one where the initial slope meets the peak. There the force is 0.95 of the peak.
// Pacejka (sec. 8.6) stops it at 3, which stores so much that a car rolls back by a hand after an emergency stop.
constexpr double bound_at_rest = 1.5;
constexpr double least_relaxation = 0.05;  // of the nominal one, for a tyre that hardly touches

/// (1 - exp(-x)) / x.
double mean_decay(double x) { return x < 1e-5 ? 1.0 - 0.5 * x : -std::expm1(-x) / x; }

}  // namespace

CarcassStiffness carcass_stiffness(const Tyre& tyre) {
  const TyreGrip nominal = tyre_grip(tyre, tyre.nominal_load_n, 0.0, 1.0);
  return {nominal.kx_n / tyre.relaxation_long_m, nominal.ky_nprad / tyre.relaxation_lat_m};
}

Slip TyreDeflection::step(double dt_s, const Tyre& tyre, const TyreGrip& grip, const ContactMotion& motion) {
  const double nominal_kx_n = tyre.nominal_load_n * tyre.p_kx1;
  const double nominal_q = 1.0 / tyre.p_ky2;
  const double nominal_ky = tyre.p_ky1 * tyre.nominal_load_n * 2.0 * nominal_q / (1.0 + nominal_q * nominal_q);
  const double sigma_x = tyre.relaxation_long_m * std::max(grip.kx_n / nominal_kx_n, least_relaxation);
  const double sigma_y = tyre.relaxation_lat_m * std::max(grip.ky_nprad / nominal_ky, least_relaxation);

  const double speed = std::abs(motion.ahead_mps), way_m = speed * dt_s;
  const double x_part = way_m / sigma_x, y_part = way_m / sigma_y;
  const double x_mean = mean_decay(x_part), y_mean = mean_decay(y_part);
  u_m_ = u_m_ * (1.0 - x_part * x_mean) - dt_s * x_mean * motion.slip_x_mps;
  v_m_ = v_m_ * (1.0 - y_part * y_mean) - dt_s * y_mean * motion.slip_y_mps;

  double damper_s = 0.0;
  if (speed < low_speed_mps) {
    const double fade = 0.5 * (1.0 + std::cos(std::numbers::pi * speed / low_speed_mps));
    damper_s = damping_s * fade;
    const double in_x = u_m_ / sigma_x * grip.kx_n / grip.dx_n, in_y = v_m_ / sigma_y * grip.ky_nprad / grip.dy_n;
    const double size = fade * std::sqrt(in_x * in_x + in_y * in_y);
    if (size > bound_at_rest) {
      u_m_ *= bound_at_rest / size;
      v_m_ *= bound_at_rest / size;
    }
  }
  return {(u_m_ - damper_s * motion.slip_x_mps) / sigma_x, (v_m_ - damper_s * motion.slip_y_mps) / sigma_y, 0.0};
}

void TyreDeflection::hold(const Tyre& tyre, double fx_n, double fy_n) {
  const CarcassStiffness carcass = carcass_stiffness(tyre);
  u_m_ = fx_n / carcass.long_npm;
  v_m_ = fy_n / carcass.lat_npm;
}

}  // namespace vehicle

// SPDX-License-Identifier: Apache-2.0
#include "vehicle/magic_formula.hpp"

#include <algorithm>
#include <cmath>

namespace vehicle {
namespace {

/// sin or cos take this angle: C atan(B x - E (B x - atan(B x))).
double formula_angle(double b_x, double c, double e) {
  const double inner = e == 0.0 ? b_x : b_x - e * (b_x - std::atan(b_x));
  return c * std::atan(inner);
}

/// Weighting function of combined slip; not below 0, where C > 1 would take it at large slip.
double weight(double b_x, double c) { return std::max(std::cos(c * std::atan(b_x)), 0.0); }

constexpr double least_grip_share = 0.2;  // the linear loss of grip with load ends there

}  // namespace

TyreGrip tyre_grip(const Tyre& t, double load_n, double lean, double friction) {
  const double dfz = (load_n - t.nominal_load_n) / t.nominal_load_n;  // 4.E2
  const double mu_x = std::max(t.p_dx1 + t.p_dx2 * dfz, least_grip_share * t.p_dx1);
  const double mu_y = std::max(t.p_dy1 + t.p_dy2 * dfz, least_grip_share * t.p_dy1);
  TyreGrip grip;
  grip.dx_n = friction * load_n * mu_x;                                               // 4.E12, 4.E13
  grip.dy_n = friction * load_n * mu_y * std::max(1.0 - t.p_dy3 * lean * lean, 0.1);  // 4.E22, 4.E23
  grip.kx_n = load_n * (t.p_kx1 + t.p_kx2 * dfz) * std::exp(t.p_kx3 * dfz);           // 4.E15
  // 4.E25 with p_Ky4 = 2: sin(2 atan q) = 2 q / (1 + q^2).
  const double q = load_n / (t.p_ky2 * t.nominal_load_n);
  grip.ky_nprad = t.p_ky1 * t.nominal_load_n * 2.0 * q / (1.0 + q * q);
  return grip;
}

TyreForces magic_formula(const Tyre& t, double load_n, double friction, const Slip& slip, const TyreGrip& g) {
  constexpr double tiny_n = 1e-6;
  const double dfz = (load_n - t.nominal_load_n) / t.nominal_load_n;
  const double b_x = g.kx_n / (t.p_cx1 * g.dx_n + tiny_n);                                  // 4.E16
  const double fx0 = g.dx_n * std::sin(formula_angle(b_x * slip.kappa, t.p_cx1, t.p_ex1));  // 4.E9
  const double camber_n = load_n * (t.p_ky6 + t.p_ky7 * dfz) * slip.lean;                   // 4.E30
  const double alpha_y = slip.tan_alpha + camber_n / (g.ky_nprad + tiny_n);                 // 4.E20, 4.E27
  const double b_y = g.ky_nprad / (t.p_cy1 * g.dy_n + tiny_n);                              // 4.E26
  const double fy0 = g.dy_n * std::sin(formula_angle(b_y * alpha_y, t.p_cy1, t.p_ey1));     // 4.E19

  // 4.E54, 4.E62: cos(atan a) = 1 / sqrt(1 + a^2).
  const double kappa_part = t.r_bx2 * slip.kappa, alpha_part = t.r_by2 * slip.tan_alpha;
  const double b_xa = t.r_bx1 / std::sqrt(1.0 + kappa_part * kappa_part);
  const double b_yk = t.r_by1 / std::sqrt(1.0 + alpha_part * alpha_part);
  TyreForces f;
  f.fx_n = fx0 * weight(b_xa * slip.tan_alpha, t.r_cx1);  // 4.E50, 4.E51
  f.fy_n = fy0 * weight(b_yk * slip.kappa, t.r_cy1);      // 4.E58, 4.E59

  const double kappa_as_alpha = g.kx_n / (g.ky_nprad + tiny_n) * slip.kappa;
  const double alpha_t = std::sqrt(slip.tan_alpha * slip.tan_alpha + kappa_as_alpha * kappa_as_alpha);  // 4.E78
  const double d_t = load_n * t.radius_m / t.nominal_load_n * t.q_dz1;                                  // 4.E42
  const double cos_alpha = 1.0 / std::sqrt(1.0 + slip.tan_alpha * slip.tan_alpha);
  const double b_t = t.q_bz1 / std::max(friction, 0.01);                                              // 4.E40
  const double trail_m = d_t * std::cos(formula_angle(b_t * alpha_t, t.q_cz1, t.q_ez1)) * cos_alpha;  // 4.E33
  f.mz_nm = -trail_m * f.fy_n;                                                                        // 4.E32, 4.E71
  return f;
}

TyreForces magic_formula(const Tyre& tyre, double load_n, double friction, const Slip& slip) {
  return magic_formula(tyre, load_n, friction, slip, tyre_grip(tyre, load_n, slip.lean, friction));
}

}  // namespace vehicle

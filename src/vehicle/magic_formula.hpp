// SPDX-License-Identifier: Apache-2.0
#pragma once
// Steady forces of a tyre: Magic Formula, Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, sec. 4.3.2 (eq. 4.E..).

#include "vehicle/car_parameters.hpp"

namespace vehicle {

/// Slip of a tyre in the axes of its contact (x ahead, y left, z up), signed so that a positive slip gives a positive
/// force.
struct Slip {
  double kappa = 0.0;      ///< -V_sx / |V_x|
  double tan_alpha = 0.0;  ///< alpha* of eq. 4.E3: -V_sy / |V_x|; ISO 8855 has the other sign
  double lean = 0.0;       ///< sine of the inclination, positive = top to the left, which pushes to the left
};

/// Peaks and slopes at a load.
struct TyreGrip {
  double dx_n = 0.0, dy_n = 0.0;      ///< largest forces, eq. 4.E12 and 4.E22
  double kx_n = 0.0, ky_nprad = 0.0;  ///< slip stiffnesses, eq. 4.E15 and 4.E25
};

struct TyreForces {
  double fx_n = 0.0, fy_n = 0.0, mz_nm = 0.0;
};

/// load_n > 0; friction scales the peaks and leaves the stiffness (lambda_mu).
[[nodiscard]] TyreGrip tyre_grip(const Tyre& tyre, double load_n, double lean, double friction);

/// Forces at combined slip (eq. 4.E50 to 4.E78).
[[nodiscard]] TyreForces magic_formula(const Tyre& tyre, double load_n, double friction, const Slip& slip,
                                       const TyreGrip& grip);
[[nodiscard]] TyreForces magic_formula(const Tyre& tyre, double load_n, double friction, const Slip& slip);

}  // namespace vehicle

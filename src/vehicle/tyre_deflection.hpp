// SPDX-License-Identifier: Apache-2.0
#pragma once
// Transient slip of a tyre: the deflection of its contact patch, after Pacejka (3rd ed. 2012), ch. 7 (single-contact-
// point model) and sec. 8.6 (towards standstill).

#include "vehicle/magic_formula.hpp"

namespace vehicle {

/// How the contact of a tyre moves.
struct ContactMotion {
  double ahead_mps = 0.0;   ///< V_x of the wheel
  double slip_x_mps = 0.0;  ///< V_sx = V_x - omega R_e
  double slip_y_mps = 0.0;  ///< V_sy = V_y
};

/// Deflection of the contact patch ahead and to the left, signed so that a positive one gives a positive force:
///   du/dt + |V_x| u / sigma = -V_s,   slip = u / sigma,   sigma = slip stiffness / carcass stiffness.
/// At rest that is a spring, so that a braked car stands on a slope without creeping.
class TyreDeflection {
 public:
  /// Moves on by dt (exact for constant motion) and returns the slip.
  Slip step(double dt_s, const Tyre& tyre, const TyreGrip& grip, const ContactMotion& motion);
  /// Gives the tyre the deflection that holds these forces at rest.
  void hold(const Tyre& tyre, double fx_n, double fy_n);
  void reset() { u_m_ = v_m_ = 0.0; }
  [[nodiscard]] double u_m() const { return u_m_; }
  [[nodiscard]] double v_m() const { return v_m_; }

 private:
  double u_m_ = 0.0, v_m_ = 0.0;
};

/// Stiffness of the carcass in N/m that gives the relaxation lengths at the nominal load.
struct CarcassStiffness {
  double long_npm = 0.0, lat_npm = 0.0;
};
[[nodiscard]] CarcassStiffness carcass_stiffness(const Tyre& tyre);

}  // namespace vehicle

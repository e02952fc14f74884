// SPDX-License-Identifier: Apache-2.0
#pragma once
// Everything that turns: engine, clutch, gears, differentials, brakes, wheels.

#include <array>

#include "vehicle/gear_shift.hpp"

namespace vehicle {

/// What the rest of the car tells the drive train about one wheel.
struct WheelLoad {
  double tyre_nm = 0.0;     ///< F_x R_e: slows a wheel that drives the car
  double rolling_nm = 0.0;  ///< largest torque of the rolling resistance
  double slip_mps = 0.0;    ///< omega R_e - V_x
  double speed_mps = 0.0;   ///< V_x
};

struct WheelSpin {
  double spin_radps = 0.0;
  double acceleration_radps2 = 0.0;  ///< mean of the last step
  double drive_nm = 0.0, brake_nm = 0.0, rolling_nm = 0.0;
};

/// Rigid shafts. Clutch, locking differentials, brakes and rolling resistance are dry friction: each holds until its
/// torque is reached and slips then. Their impulses over a step are found together, implicitly, by projected
/// Gauss-Seidel sweeps, so that a locked wheel stands and a closed clutch does not slip, whatever the step.
class DriveTrain {
 public:
  struct Pedals {
    double throttle = 0.0, brake = 0.0, clutch = 0.0;
    bool automatic = true;
    int gear = 1;
  };

  explicit DriveTrain(const CarParameters& car);

  /// Wheels turn as given; engine and gear follow.
  void place(const CarParameters& car, const std::array<double, 4>& spin_radps);
  void step(const CarParameters& car, double dt_s, const Pedals& pedals, const std::array<WheelLoad, 4>& wheels);

  [[nodiscard]] const std::array<WheelSpin, 4>& wheels() const { return wheels_; }
  [[nodiscard]] double engine_radps() const { return engine_radps_; }
  [[nodiscard]] double engine_nm() const { return engine_nm_; }
  [[nodiscard]] double throttle() const { return throttle_; }
  [[nodiscard]] const GearShift& gears() const { return gears_; }
  [[nodiscard]] double engine_w() const { return engine_w_; }
  [[nodiscard]] double brakes_w() const { return brakes_w_; }
  [[nodiscard]] double rolling_w() const { return rolling_w_; }
  [[nodiscard]] double transmission_w() const { return transmission_w_; }
  [[nodiscard]] double fuel_w() const { return fuel_w_; }
  [[nodiscard]] double energy_j(const CarParameters& car) const;

 private:
  struct Friction {
    std::array<double, 4> hold{};  // brake and rolling resistance
    double clutch = 0.0, front = 0.0, rear = 0.0, centre = 0.0;
  };
  struct Sweep;

  [[nodiscard]] double mean_spin_radps() const;  ///< of the driven wheels, by torque share
  [[nodiscard]] double engine_torque(const CarParameters& car, double dt_s, double throttle) const;
  void control_slip(const CarParameters& car, double dt_s, const Pedals& pedals,
                    const std::array<WheelLoad, 4>& wheels);
  void solve_friction(Sweep& sweep);
  void account(const CarParameters& car, double dt_s, const std::array<double, 4>& spin_before,
               const std::array<WheelLoad, 4>& wheels, const Sweep& sweep);

  std::array<double, 4> share_{};    // of the torque after the gears
  std::array<double, 4> inertia_{};  // of each wheel
  std::array<WheelSpin, 4> wheels_;
  std::array<double, 4> abs_{1.0, 1.0, 1.0, 1.0};  // share of the brake torque that ABS lets through
  double traction_ = 1.0, traction_held_ = 1.0;    // share of the throttle that traction control lets through, integral
  Friction impulse_;                               // of the last step, N m s
  GearShift gears_;
  double engine_radps_ = 0.0, engine_nm_ = 0.0, throttle_ = 0.0;
  double engine_w_ = 0.0, brakes_w_ = 0.0, rolling_w_ = 0.0, transmission_w_ = 0.0, fuel_w_ = 0.0;
};

}  // namespace vehicle

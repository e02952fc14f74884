// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which gear is in, and when the gearbox changes it.

#include "vehicle/car_parameters.hpp"

namespace vehicle {

/// Gear, shifting and the automatic clutch. Gears: -1 reverse, 0 neutral, 1 .. n.
class GearShift {
 public:
  struct Input {
    double dt_s = 0.0;
    bool automatic = true;
    int wanted = 1;
    double throttle = 0.0, brake = 0.0, clutch_pedal = 0.0;
    double engine_rpm = 0.0, wheel_rpm = 0.0;  ///< wheel_rpm: mean of the driven wheels, by torque share
    double demand_nm = 0.0;                    ///< of the engine, by the pedal, once it turns with the gearbox
    double clutch_nm = 0.0;                    ///< through the clutch a step ago
  };

  /// Puts a gear in at once, with the clutch closed where it turns the engine fast enough.
  void set(int gear, bool locked) {
    gear_ = coming_ = gear;
    shifting_s_ = 0.0;
    handing_over_ = false;
    locked_ = locked;
  }
  void step(const CarParameters& car, const Input& input);

  [[nodiscard]] int gear() const { return gear_; }
  [[nodiscard]] bool shifting() const { return shifting_s_ > 0.0; }
  /// The gear that a shift leads to; without one the gear that is in.
  [[nodiscard]] int coming() const { return coming_; }
  [[nodiscard]] double clutch_capacity_nm() const { return capacity_nm_; }
  /// After a shift, until engine and gearbox turn as one: the engine gives carried_nm and seeks engine_target_rpm.
  [[nodiscard]] bool handing_over() const { return handing_over_ && !shifting(); }
  [[nodiscard]] double carried_nm() const { return carried_nm_; }
  [[nodiscard]] double engine_target_rpm() const { return engine_target_rpm_; }

 private:
  [[nodiscard]] int automatic_gear(const CarParameters& car, const Input& input) const;
  void close_clutch(const CarParameters& car, const Input& input);
  void hand_over(const CarParameters& car, const Input& input);
  void shift(const CarParameters& car, const Input& input);

  int gear_ = 1, coming_ = 1;
  double shifting_s_ = 0.0;  // left of the shift
  double since_shift_s_ = 10.0;
  double demand_ = 0.0;  // pedals of the last seconds
  double capacity_nm_ = 0.0;
  double carried_nm_ = 0.0, engine_target_rpm_ = 0.0;
  bool locked_ = false;        // the clutch turns as one
  bool handing_over_ = false;  // it closes because of a shift, not for a start
};

/// Engine over wheel speed, negative in reverse, 0 in neutral.
[[nodiscard]] double gear_ratio(const CarParameters& car, int gear);

}  // namespace vehicle

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
  };

  /// Puts a gear in at once, with the clutch closed where it turns the engine fast enough.
  void set(int gear, bool locked) {
    gear_ = coming_ = gear;
    shifting_s_ = 0.0;
    locked_ = locked;
  }
  void step(const CarParameters& car, const Input& input);

  [[nodiscard]] int gear() const { return gear_; }
  [[nodiscard]] bool shifting() const { return shifting_s_ > 0.0; }
  /// The gear that a shift leads to; without one the gear that is in.
  [[nodiscard]] int coming() const { return coming_; }
  [[nodiscard]] double clutch_capacity_nm() const { return capacity_nm_; }

 private:
  [[nodiscard]] int automatic_gear(const CarParameters& car, const Input& input) const;
  void close_clutch(const CarParameters& car, const Input& input);
  void shift(const CarParameters& car, const Input& input);

  int gear_ = 1, coming_ = 1;
  double shifting_s_ = 0.0;  // left of the shift
  double since_shift_s_ = 10.0;
  double demand_ = 0.0;  // pedals of the last seconds
  double capacity_nm_ = 0.0;
  bool locked_ = false;       // the clutch turns as one
  bool after_shift_ = false;  // it closes because of a shift, not for a start
};

/// Engine over wheel speed, negative in reverse, 0 in neutral.
[[nodiscard]] double gear_ratio(const CarParameters& car, int gear);

}  // namespace vehicle

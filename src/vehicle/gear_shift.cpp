// SPDX-License-Identifier: Apache-2.0
#include "vehicle/gear_shift.hpp"

#include <algorithm>
#include <cmath>

namespace vehicle {
namespace {

constexpr double demand_memory_s = 3.0;    // a gearbox holds the gear through a bend
constexpr double shift_pause_s = 0.5;      // between two automatic shifts
constexpr double engage_over_idle = 1.15;  // the automatic clutch begins to carry there
constexpr double open_under_idle = 1.02;
constexpr double synchronous_rpm = 40.0;
constexpr double opening_share = 0.4, closing_share = 0.4;  // of a shift
constexpr double least_closing_s = 0.02;
constexpr double leading_rpm = 100.0;  // so far the pushing side of a closing clutch turns ahead

}  // namespace

double gear_ratio(const CarParameters& car, int gear) {
  if (gear == 0) return 0.0;
  const Gearbox& g = car.gearbox;
  if (gear < 0) return -g.reverse_ratio * g.final_drive;
  return g.ratios[static_cast<std::size_t>(gear) - 1] * g.final_drive;
}

int GearShift::automatic_gear(const CarParameters& car, const Input& in) const {
  const Gearbox& g = car.gearbox;
  const int last = static_cast<int>(g.ratios.size());
  if (gear_ < 1) return 1;
  if (since_shift_s_ < shift_pause_s) return gear_;
  const double up = g.up_calm_rpm + demand_ * (g.up_rpm - g.up_calm_rpm);
  const double down = g.down_calm_rpm + demand_ * (g.down_rpm - g.down_calm_rpm);
  if (gear_ < last && in.wheel_rpm * gear_ratio(car, gear_) > up && in.brake <= 0.0) return gear_ + 1;
  if (gear_ > 1) {
    const double after = in.wheel_rpm * gear_ratio(car, gear_ - 1);
    if (in.wheel_rpm * gear_ratio(car, gear_) < down && after < 0.95 * up) return gear_ - 1;
  }
  return gear_;
}

void GearShift::close_clutch(const CarParameters& car, const Input& in) {
  const Gearbox& g = car.gearbox;
  const double input_rpm = in.wheel_rpm * gear_ratio(car, gear_);
  const double engage_rpm = engage_over_idle * car.engine.idle_rpm;
  if (locked_) {
    locked_ = input_rpm > open_under_idle * car.engine.idle_rpm;
  } else {
    locked_ = input_rpm > engage_rpm && std::abs(in.engine_rpm - input_rpm) < synchronous_rpm;
  }
  double able_nm = g.clutch_nm;
  if (!locked_) {
    // Carries more the faster the engine turns, so that it settles near launch_rpm at full throttle.
    const double x = std::clamp((in.engine_rpm - engage_rpm) / (g.launch_rpm - engage_rpm), 0.0, 1.0);
    able_nm *= x * x;
  }
  capacity_nm_ = able_nm * (1.0 - in.clutch_pedal);
}

/// After a shift the clutch hands over what the driver asks for and no more: the torque that brings engine and gearbox
/// together would push the car. The engine does that itself.
void GearShift::hand_over(const CarParameters& car, const Input& in) {
  const double input_rpm = in.wheel_rpm * gear_ratio(car, gear_);
  const double closing_s = std::max(closing_share * car.gearbox.shift_s, least_closing_s);
  const double share = std::min(since_shift_s_ / closing_s, 1.0);
  const double ahead_rpm = std::copysign(1.0, in.demand_nm) * (in.engine_rpm - input_rpm);
  carried_nm_ = ahead_rpm > -synchronous_rpm ? share * in.demand_nm : 0.0;
  engine_target_rpm_ = input_rpm + std::copysign((1.0 - share) * leading_rpm, in.demand_nm);
  capacity_nm_ = std::min(std::abs(carried_nm_), car.gearbox.clutch_nm) * (1.0 - in.clutch_pedal);
  const bool turns_as_one = share >= 1.0 && std::abs(ahead_rpm) < synchronous_rpm;
  if (!turns_as_one && input_rpm > engage_over_idle * car.engine.idle_rpm) return;
  handing_over_ = false;
  close_clutch(car, in);
}

/// The clutch lets go of what it carried over the first part of the shift, then the gear changes, then it stays open to
/// the end.
void GearShift::shift(const CarParameters& car, const Input& in) {
  const double whole_s = car.gearbox.shift_s, open_s = (1.0 - closing_share) * whole_s;
  shifting_s_ -= in.dt_s;
  since_shift_s_ = 0.0;
  locked_ = false;
  handing_over_ = true;
  const double opening_left = whole_s > 0.0 ? 1.0 - (open_s - shifting_s_) / (opening_share * whole_s) : 0.0;
  const double opening_nm = std::max(opening_left, 0.0) * carried_nm_ * (1.0 - in.clutch_pedal);
  capacity_nm_ = std::min(capacity_nm_, opening_nm);
  if (opening_left <= 0.0) gear_ = coming_;
}

void GearShift::step(const CarParameters& car, const Input& in) {
  demand_ = std::max({in.throttle, in.brake, demand_ * (1.0 - in.dt_s / demand_memory_s)});
  since_shift_s_ += in.dt_s;
  if (!shifting()) {
    coming_ =
        in.automatic ? automatic_gear(car, in) : std::clamp(in.wanted, -1, static_cast<int>(car.gearbox.ratios.size()));
    if (coming_ != gear_)
      shifting_s_ = (1.0 - closing_share) * car.gearbox.shift_s + in.dt_s, carried_nm_ = std::abs(in.clutch_nm);
  }
  if (shifting()) {
    shift(car, in);
  } else if (gear_ == 0) {
    capacity_nm_ = 0.0;
    handing_over_ = false;
  } else if (handing_over_) {
    hand_over(car, in);
  } else {
    close_clutch(car, in);
  }
}

}  // namespace vehicle

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Follows a line at a planned speed with steering wheel and pedals.

#include <vector>

#include "orthodrive/drive/car/driver.hpp"
#include "orthodrive/drive/car/speed_profile.hpp"
#include "orthodrive/drive/line/driving_line.hpp"
#include "vehicle/car.hpp"

namespace orthodrive {

/// Where a place of the car is along its line; moves on from call to call.
struct Progress {
  double s_m = 0.0, error_m = 0.0;  ///< error: positive = left of the line
  void update(const DrivingLine& line, Vec2 place);
};

/// Steering: the front wheels point along the way of the front axle (axle_line.hpp) a short time ahead, plus the slip
/// angle that the bend needs, minus a correction of the axle's distance from its way (Stanley: Hoffmann, Tomlin,
/// Montemerlo, Thrun, Autonomous automobile trajectory tracking for off-road driving, 2007). Because the wheels are
/// held in the direction of the way and not of the car, a car that slides is caught without a further rule.
///
/// Pedals: the planned acceleration with what slows the car down made up for, and a proportional-integral controller of
/// the speed.
class DriverModel {
 public:
  DriverModel(const vehicle::CarParameters& car, const EnvelopeTable& envelope, const Driver& driver,
              const DrivingLine& line, const SpeedPlan& plan, std::vector<double> stops_m);

  /// The car has been put on the line with the middle of its wheelbase at s_m.
  void begin(double s_m);
  /// What to do for the next dt_s.
  [[nodiscard]] vehicle::Controls drive(const vehicle::State& state, double dt_s);

  [[nodiscard]] double s_m() const { return middle_.s_m; }  ///< of the middle of the wheelbase; goes on lap by lap
  [[nodiscard]] double error_m() const { return middle_.error_m; }  ///< of the same from the line
  [[nodiscard]] int stops_made() const { return static_cast<int>(next_stop_); }

 private:
  /// Side force of the tyres over their load in a bend.
  [[nodiscard]] double side_share(const LinePoint& p, double speed_mps) const;
  [[nodiscard]] DrivingLine way_of_front_axle() const;
  [[nodiscard]] double steering_rad(const vehicle::State& state) const;
  /// Largest acceleration that grip and engine leave in the bend; less for who runs wide.
  [[nodiscard]] double most_drive_here_mps2(const LinePoint& p, double speed_mps) const;
  [[nodiscard]] double wanted_force_n(const vehicle::State& state, double dt_s);
  /// Stands or waits at the next stop: true as long as the brake is to be held.
  [[nodiscard]] bool holds(const vehicle::State& state, double dt_s);

  const vehicle::CarParameters& car_;
  const EnvelopeTable& envelope_;
  const Driver& driver_;
  const DrivingLine& line_;
  const SpeedPlan& plan_;
  std::vector<double> stops_m_;
  DrivingLine front_line_;
  Progress front_, middle_;  // each along its own line
  std::size_t next_stop_ = 0;
  double waited_s_ = 0.0, integral_mps2_ = 0.0;
};

}  // namespace orthodrive

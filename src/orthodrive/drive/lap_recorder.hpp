// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a drive leaves behind: samples, extremes, findings.

#include "orthodrive/drive/car/driver_model.hpp"
#include "orthodrive/drive/car/monitored_road.hpp"
#include "orthodrive/drive/drive_route.hpp"

namespace orthodrive {

/// Findings of one kind, one per place: what follows within a few metres belongs to the one before.
class SpacedFindings {
 public:
  explicit SpacedFindings(Findings& findings) : findings_(findings) {}
  void add(double s_m, Finding finding);

 private:
  Findings& findings_;
  double last_s_m_ = -1e300;
};

/// Takes down what every step of a lap shows.
class LapRecorder {
 public:
  LapRecorder(const roadquery::RoadQuery& query, const SpeedPlan& plan, DriveResult& result);

  /// The state at the end of a step. s_m: from where the timed way begins.
  void step(const vehicle::State& state, const DriverModel& driver, MonitoredRoad::Seen seen, double s_m);
  void sample(double t_s, const vehicle::State& state, const vehicle::Controls& controls, const DriverModel& driver,
              double s_m);

 private:
  const roadquery::RoadQuery& query_;
  const SpeedPlan& plan_;
  DriveResult& result_;
  SpacedFindings bumps_, misses_, jolts_;
  roadquery::Cursor cursor_;  ///< of the middle of the car
  double last_z_m_ = 0.0, first_fuel_kg_ = -1.0;
  bool has_z_ = false;
};

}  // namespace orthodrive

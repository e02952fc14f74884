// SPDX-License-Identifier: Apache-2.0
#pragma once
// How fast the car may be at each place of its line.

#include <cstddef>
#include <optional>
#include <vector>

#include "orthodrive/drive/car/driver.hpp"
#include "orthodrive/drive/car/envelope_table.hpp"
#include "orthodrive/drive/line/driving_line.hpp"

namespace orthodrive {

/// What a place of the road asks of the tyres at a speed, in the plane of the road (per mass).
struct RoadLoad {
  double lateral_mps2 = 0.0;  ///< to the left: path curvature and banking
  double normal_mps2 = 0.0;   ///< gravity, banking in a bend, crests and sags; without air forces
  double slope_mps2 = 0.0;    ///< gravity along the road, positive uphill
};
[[nodiscard]] RoadLoad road_load(const LinePoint& p, double speed_mps);

/// Largest acceleration along the line that the driver asks for there, with the slope: what exit_share leaves, and up
/// to grip_share at least as much as keeps the speed.
[[nodiscard]] double most_drive_mps2(const EnvelopeTable& envelope, const Driver& driver, const LinePoint& p,
                                     double speed_mps);

/// What else bounds the speed, beyond car and driver.
struct SpeedCaps {
  std::vector<double> legal_mps;  ///< one per line point, or empty: no limit
  std::vector<double> stops_m;    ///< places along the line where the car comes to rest, ascending
};

/// One speed a line point: quasi-steady g-g-g (Brayshaw and Harrison, A quasi steady state approach to race car lap
/// simulation, 2005; with the third dimension as Lovato and Massaro, A three-dimensional free-trajectory
/// quasi-steady-state optimal-control method, 2022). The limit by curvature, banking, crests and the car's envelope,
/// then a backward pass with the brakes and a forward pass with the engine, both at the lateral acceleration of the
/// place. On a bank that is too steep for low speeds the limit is the largest of the speeds that hold the car there;
/// where the driver's limits leave none, first max_vertical_mps2 and then max_lateral_mps2 do not count.
[[nodiscard]] std::vector<double> plan_speed(const DrivingLine& line, const EnvelopeTable& envelope,
                                             const Driver& driver, const SpeedCaps& caps = {});

/// Lowest speed at every point of the line that holds the car on its bank, m/s; 0 where it can stand, and where no
/// speed does.
[[nodiscard]] std::vector<double> least_speeds_on_banks(const DrivingLine& line, const EnvelopeTable& envelope,
                                                        const Driver& driver);

/// A place where the tyres do not hold the car on a bank at the planned speed.
struct SteepBank {
  std::size_t point = 0;            ///< of the line
  std::optional<double> least_mps;  ///< so fast the car stays on it; none: at no speed
};
/// The first one, if there is one. `speed_mps`: as planned, one per line point.
[[nodiscard]] std::optional<SteepBank> first_too_steep_bank(const DrivingLine& line, const EnvelopeTable& envelope,
                                                            const Driver& driver, const std::vector<double>& speed_mps);

/// Speed limit at every point of the line, m/s: that of the lane below it, else of the road there; infinite where there
/// is none.
[[nodiscard]] std::vector<double> legal_speeds(const roadquery::RoadQuery& query, const Route& route,
                                               const DrivingLine& line);

/// Places along the line, at the end of a road, where other traffic goes first (Junction::priorities): one stops there.
[[nodiscard]] std::vector<double> give_way_places(const roadquery::RoadMap& map, const Route& route,
                                                  const DrivingLine& line);

/// Planned speed and acceleration along a line.
class SpeedPlan {
 public:
  SpeedPlan(const DrivingLine& line, std::vector<double> speed_mps) : line_(&line), speed_(std::move(speed_mps)) {}
  struct At {
    double speed_mps = 0.0, acceleration_mps2 = 0.0;
  };
  /// Between points v^2 is linear in s: the acceleration is constant.
  [[nodiscard]] At at(double s_m) const;
  [[nodiscard]] double duration_s() const;  ///< without the waiting at stops

 private:
  const DrivingLine* line_;
  std::vector<double> speed_;
};

}  // namespace orthodrive

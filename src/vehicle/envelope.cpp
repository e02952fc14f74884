#include "vehicle/envelope.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vehicle/car_geometry.hpp"
#include "vehicle/engine.hpp"
#include "vehicle/gear_shift.hpp"
#include "vehicle/magic_formula.hpp"

namespace vehicle {
namespace {

constexpr double least_load_n = 1.0;
constexpr double rolling_reference_mps = 16.67;
constexpr int bisections = 30;

double rolling_radius_m(const Tyre& tyre, double load_n) { return tyre.radius_m - load_n / tyre.vertical_npm / 3.0; }

/// A steady state: accelerations in the road plane and what follows for the wheels.
class SteadyState {
 public:
  SteadyState(const CarParameters& car, const EnvelopeQuery& query) : car_(car), query_(query) {
    const Aero& a = car.aero;
    const double pressure = 0.5 * a.air_density_kgpm3 * query.speed_mps * query.speed_mps;
    const double weight_n = car.body.mass_kg * std::max(query.normal_mps2, 0.0);
    axle_n_ = {car.body.front_share * weight_n - pressure * a.front_lift_area_m2,
               (1.0 - car.body.front_share) * weight_n - pressure * a.rear_lift_area_m2};
    drag_n_ = pressure * a.drag_area_m2;
    drag_arm_n_ = drag_n_ * car.body.cg_height_m / car.body.wheelbase_m;
    for (std::size_t i = 0; i < 2; ++i) {
      const Suspension& s = i == 0 ? car.front : car.rear;
      const Tyre& t = i == 0 ? car.front_tyre : car.rear_tyre;
      // Spring and bar in series with the tyre.
      const double at_wheel = s.spring_npm + 2.0 * s.anti_roll_npm;
      roll_stiffness_[i] = 0.5 * s.track_m * s.track_m * at_wheel * t.vertical_npm / (at_wheel + t.vertical_npm);
    }
  }

  /// Loads of the wheels. The tyres give along_mps2 and lateral_mps2 times the mass.
  [[nodiscard]] std::array<double, 4> loads(double along_mps2, double lateral_mps2) const {
    const Body& b = car_.body;
    const double mass = b.mass_kg;
    // Pitch: the sum of the tyres' forces acts at the road, drag too (its lift is in the lift areas).
    const double pitch_n = mass * along_mps2 * b.cg_height_m / b.wheelbase_m - drag_arm_n_;
    const std::array<double, 2> axle = {axle_n_[0] - pitch_n, axle_n_[1] + pitch_n};
    const std::array<double, 2> share = {b.front_share, 1.0 - b.front_share};
    const double axis_m = share[0] * car_.front.roll_centre_m + share[1] * car_.rear.roll_centre_m;
    const double roll_nm = mass * lateral_mps2 * (b.cg_height_m - axis_m);
    std::array<double, 4> load{};
    for (std::size_t i = 0; i < 2; ++i) {
      const Suspension& s = i == 0 ? car_.front : car_.rear;
      const double through_springs = roll_nm * roll_stiffness_[i] / (roll_stiffness_[0] + roll_stiffness_[1]);
      const double through_links = mass * share[i] * lateral_mps2 * s.roll_centre_m;
      const double transfer = (through_springs + through_links) / s.track_m;
      const double all = std::max(axle[i], 0.0), half = 0.5 * all;
      load[2 * i] = std::clamp(half - transfer, 0.0, all);
      load[2 * i + 1] = all - load[2 * i];
    }
    return load;
  }

  [[nodiscard]] TyreGrip grip(std::size_t wheel, double load_n) const {
    return tyre_grip(tyre(wheel), std::max(load_n, least_load_n), 0.0, query_.friction);
  }
  [[nodiscard]] const Tyre& tyre(std::size_t wheel) const { return wheel < 2 ? car_.front_tyre : car_.rear_tyre; }

  /// Share of the lateral grip of an axle that the lateral acceleration takes; over 1: too much.
  [[nodiscard]] double lateral_use(std::size_t axle, double along_mps2, double lateral_mps2) const {
    const auto load = loads(along_mps2, lateral_mps2);
    const double share = axle == 0 ? car_.body.front_share : 1.0 - car_.body.front_share;
    const double able = grip(2 * axle, load[2 * axle]).dy_n + grip(2 * axle + 1, load[2 * axle + 1]).dy_n;
    return share * car_.body.mass_kg * std::abs(lateral_mps2) / std::max(able, least_load_n);
  }

  /// Largest longitudinal force of the tyres with that lateral acceleration: sign +1 drives, -1 brakes. Each wheel
  /// gives what the friction ellipse leaves, but no more than its share of engine or brake.
  [[nodiscard]] double force_n(double sign, double along_mps2, double lateral_mps2, double engine_n) const {
    const auto load = loads(along_mps2, lateral_mps2);
    const Differential& d = car_.differential;
    double sum = 0.0;
    for (std::size_t axle = 0; axle < 2; ++axle) {
      const double use = lateral_use(axle, along_mps2, lateral_mps2);
      const double left = std::sqrt(std::max(1.0 - use * use, 0.0));
      double able = 0.0;
      for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i) {
        const double grip_n = left * grip(i, load[i]).dx_n;
        const double brake_n =
            (axle == 0 ? car_.brakes.front_nm : car_.brakes.rear_nm) / rolling_radius_m(tyre(i), load[i]);
        able += sign > 0.0 ? grip_n : std::min(grip_n, brake_n);
      }
      const double share = axle == 0 ? d.front_share : 1.0 - d.front_share;
      sum += sign > 0.0 ? std::min(able, share * engine_n) : able;
    }
    return sum;
  }

  [[nodiscard]] double rolling_n(double along_mps2, double lateral_mps2) const {
    const auto load = loads(along_mps2, lateral_mps2);
    const double relative = query_.speed_mps / rolling_reference_mps;
    const double fourth = relative * relative * relative * relative;
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += load[i] * (tyre(i).rolling_resistance + tyre(i).rolling_resistance_v4 * fourth);
    }
    return sum;
  }
  [[nodiscard]] double drag_n() const { return drag_n_; }

 private:
  const CarParameters& car_;
  const EnvelopeQuery& query_;
  std::array<double, 2> axle_n_{}, roll_stiffness_{};
  double drag_n_ = 0.0, drag_arm_n_ = 0.0;
};

double max_lateral_mps2(const SteadyState& steady) {
  double least = 0.0, most = 100.0;
  for (int n = 0; n < bisections; ++n) {
    const double middle = 0.5 * (least + most);
    const bool holds = std::max(steady.lateral_use(0, 0.0, middle), steady.lateral_use(1, 0.0, middle)) <= 1.0;
    (holds ? least : most) = middle;
  }
  return least;
}

}  // namespace

double max_drive_force_n(const CarParameters& car, double speed_mps) {
  const Differential& d = car.differential;
  const double radius_m = d.front_share * rolling_radius_m(car.front_tyre, static_load_n(car, true)) +
                          (1.0 - d.front_share) * rolling_radius_m(car.rear_tyre, static_load_n(car, false));
  double most = 0.0;
  for (int gear = 1; gear <= static_cast<int>(car.gearbox.ratios.size()); ++gear) {
    const double ratio = gear_ratio(car, gear);
    // Below the launch speed of first gear the clutch slips.
    const double turned = std::abs(speed_mps) / radius_m * ratio * rpm_per_radps;
    const double rpm = gear == 1 ? std::max(turned, car.gearbox.launch_rpm) : turned;
    if (rpm > car.engine.limit_rpm || rpm < car.engine.idle_rpm) continue;
    most = std::max(most, crankshaft_nm(car.engine, rpm, 1.0) * ratio * car.gearbox.efficiency / radius_m);
  }
  return most;
}

Envelope envelope(const CarParameters& car, const EnvelopeQuery& query) {
  const SteadyState steady(car, query);
  const double lateral = std::abs(query.lateral_mps2), mass = car.body.mass_kg;
  const double engine_n = max_drive_force_n(car, query.speed_mps);
  Envelope e;
  e.max_lateral_mps2 = max_lateral_mps2(steady);
  // The load transfer depends on the acceleration that it limits: bisection for the place where both agree.
  const auto agreeing = [&](double sign) {
    double least = 0.0, most = 100.0;
    for (int n = 0; n < bisections; ++n) {
      const double middle = 0.5 * (least + most);
      (steady.force_n(sign, sign * middle, lateral, engine_n) >= mass * middle ? least : most) = middle;
    }
    return least;
  };
  const double drive = agreeing(1.0), brake = agreeing(-1.0);
  e.max_drive_mps2 = drive - (steady.drag_n() + steady.rolling_n(drive, lateral)) / mass;
  e.max_brake_mps2 = brake + (steady.drag_n() + steady.rolling_n(-brake, lateral)) / mass;
  return e;
}

}  // namespace vehicle

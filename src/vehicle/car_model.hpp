// SPDX-License-Identifier: Apache-2.0
#pragma once
// Inside of Car: state variables and the parts of a step.

#include "vehicle/car.hpp"
#include "vehicle/car_geometry.hpp"
#include "vehicle/drive_train.hpp"
#include "vehicle/tyre_deflection.hpp"

namespace vehicle {

/// A wheel on the road. Vectors in the car's axes, places from the c.g. of the body.
struct Contact {
  Vec3 hub, place;
  Vec3 ahead, left, normal;  ///< of the contact
  Vec3 axle;                 ///< unit, to the left
  Vec3 velocity;             ///< of the hub carrier at the contact
  double lean = 0.0;         ///< sine of the inclination, positive = top to the right
  double loaded_m = 0.0;     ///< hub to contact
  double rolling_m = 0.0;    ///< effective rolling radius
  double load_n = 0.0, damping_w = 0.0;
  double friction = 1.0;
  TyreForces forces;
  ContactMotion motion;
};

struct Car::Model {
  explicit Model(CarParameters p);

  void place(double x_m, double y_m, double heading_rad, double speed_mps, Ground& ground, double z_guess_m);
  void step(double dt_s, const Controls& controls, Ground& ground);
  [[nodiscard]] double energy_j() const;

  CarParameters car;
  CarGeometry geometry;
  DriveTrain train;
  State state;

 private:
  void move(double dt_s);
  void steer(double dt_s, double wanted_rad);
  void set_steering(double mean_rad);
  void touch(Ground& ground);
  void touch_wheel(std::size_t i, const GroundPoint& ground);
  void roll_tyres(double dt_s);
  void slide_with_weight();
  [[nodiscard]] Accelerations accelerations(bool wheels_turn);
  [[nodiscard]] double anti_roll_n(std::size_t i) const;
  void settle(double speed_mps, Ground& ground);
  void report(double dt_s);
  void report_wheels();

  [[nodiscard]] const Tyre& tyre(std::size_t i) const { return i < 2 ? car.front_tyre : car.rear_tyre; }
  [[nodiscard]] const Suspension& suspension(std::size_t i) const { return i < 2 ? car.front : car.rear; }

  Vec3 place_;     // c.g. of the body, world
  Vec3 velocity_;  // of it, world
  Quaternion turn_;
  Vec3 rates_;  // car's axes
  std::array<double, 4> travel_{}, travel_rate_{};
  std::array<TyreDeflection, 4> deflection_;
  std::array<double, 4> wheel_steer_{}, steer_cos_{1.0, 1.0, 1.0, 1.0}, steer_sin_{};
  double steering_ = 0.0;

  // Of the last step.
  Mat3 axes_;
  std::array<Contact, 4> contacts_;
  Accelerations accelerations_;
  double air_w_ = 0.0;
};

}  // namespace vehicle

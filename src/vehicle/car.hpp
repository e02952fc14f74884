// SPDX-License-Identifier: Apache-2.0
#pragma once
// A car on four wheels: rigid body with six degrees of freedom, suspension, tyres, drive train. docs/vehicle.md.

#include <array>
#include <memory>

#include "vehicle/car_parameters.hpp"
#include "vehicle/ground.hpp"

namespace vehicle {

/// What a driver does. Values out of range are clamped, values that are not numbers count as 0.
struct Controls {
  double steering_rad = 0.0;  ///< mean angle of the front wheels, positive = left
  double throttle = 0.0;      ///< 0 .. 1
  double brake = 0.0;         ///< 0 .. 1
  double clutch = 0.0;        ///< 0: left to the automatic clutch, 1: pressed
  bool automatic = true;      ///< the gearbox chooses among the forward gears
  int gear = 1;               ///< wanted when not automatic: -1 reverse, 0 neutral, 1 .. number of gears
};

/// One wheel. Forces act on the tyre; axes of the contact: x along the wheel's heading, y to the left, both in the road
/// plane, z along its normal.
struct WheelState {
  double load_n = 0.0;  ///< F_z
  double fx_n = 0.0, fy_n = 0.0;
  double aligning_nm = 0.0;     ///< M_z, positive turns the wheel to the left
  double slip_ratio = 0.0;      ///< kappa = (omega R_e - V_x) / |V_x|: negative when braking; transient value
  double slip_angle_rad = 0.0;  ///< ISO 8855: positive = velocity to the left of the wheel; transient value
  double camber_rad = 0.0;      ///< to the road, positive = turned about x: top to the right
  double spin_radps = 0.0;
  double steer_rad = 0.0;  ///< positive = left, toe included
  double travel_m = 0.0;   ///< from the design position, positive = bump
  double travel_rate_mps = 0.0;
  double drive_nm = 0.0, brake_nm = 0.0;  ///< torques about the axle; brake: positive slows forward motion
  std::array<double, 3> hub_m{};          ///< world
  std::array<double, 3> contact_m{};      ///< world; where the wheel plane meets the road plane
  double ground_z_m = 0.0;                ///< answer of the ground under the wheel
  double friction = 1.0;
  bool on_road = true;
};

/// Powers in W, positive as named. Energy balance: engine - all others = change of kinetic and potential energy.
struct Powers {
  double engine = 0.0;        ///< at the crankshaft, negative when it brakes
  double transmission = 0.0;  ///< lost in gears, clutch and differentials
  double brakes = 0.0;
  double tyre_slip = 0.0;
  double rolling = 0.0;
  double suspension = 0.0;  ///< dampers and the tyres' vertical damping
  double air = 0.0;
  double fuel = 0.0;  ///< heat of the burnt fuel; not part of the balance
};

/// The car at one time. World frame: x east, y north, z up. Car frame: ISO 8855, x ahead, y left, z up.
struct State {
  double t_s = 0.0;
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;        ///< origin of the car (car_parameters.hpp)
  double heading_rad = 0.0;                      ///< from east, counter-clockwise, in (-pi, pi]
  double pitch_rad = 0.0;                        ///< ISO 8855: positive = nose down
  double roll_rad = 0.0;                         ///< ISO 8855: positive = left side up
  std::array<double, 3> cg_m{};                  ///< c.g. of body and wheels in the design position, world
  double speed_mps = 0.0;                        ///< along the car's x axis, of the c.g.
  double lateral_mps = 0.0, vertical_mps = 0.0;  ///< along the car's y and z axes
  std::array<double, 3> rates_radps{};           ///< roll, pitch, yaw rate in the car frame
  std::array<double, 3> acceleration_mps2{};     ///< d velocity / dt of the c.g. along the car's axes; without gravity
  double steering_rad = 0.0;                     ///< mean of the front wheels
  std::array<WheelState, 4> wheels;              ///< front left, front right, rear left, rear right
  double engine_rpm = 0.0, engine_nm = 0.0;
  int gear = 1;
  bool shifting = false;
  double throttle = 0.0;  ///< after traction control and shifting
  double fuel_kg = 0.0;   ///< burnt since place()
  Powers powers;
  double side_slip_rad = 0.0;  ///< of the c.g.
};

/// One car. step() does not allocate, lock or look at a clock; the same calls give the same bytes.
class Car {
 public:
  /// Throws std::invalid_argument for parameters that check() of parse_car.hpp refuses.
  explicit Car(CarParameters parameters);
  Car(const Car& other);
  Car& operator=(const Car& other);
  Car(Car&&) noexcept;
  Car& operator=(Car&&) noexcept;
  ~Car();

  /// Puts the origin at (x, y) on the ground, settled on its springs, rolling freely at that speed in a fitting gear.
  /// z_guess_m: height near that of the ground.
  void place(double x_m, double y_m, double heading_rad, double speed_mps, Ground& ground, double z_guess_m = 0.0);
  /// Moves on by dt_s (0.1 to 2 ms; 1 ms is what the parameters are made for).
  void step(double dt_s, const Controls& controls, Ground& ground);

  [[nodiscard]] const State& state() const;
  [[nodiscard]] const CarParameters& parameters() const;
  /// Kinetic and potential energy in J: body, wheels, engine, springs, tyres, height over z = 0.
  [[nodiscard]] double energy_j() const;

 private:
  struct Model;
  std::unique_ptr<Model> model_;
};

}  // namespace vehicle

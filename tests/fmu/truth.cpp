// SPDX-License-Identifier: Apache-2.0
// What an FMU must answer, from the libraries themselves. Reads rows of inputs from stdin, writes rows of outputs.
//   truth_of_fmu roads NETWORK             rows: x y z_guess of four tyres
//   truth_of_fmu car NETWORK CAR x y z heading speed STEPS     rows: steering throttle brake, each held for STEPS ms

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "roadquery/query/ground_query.hpp"
#include "vehicle/car.hpp"
#include "vehicle/read_car.hpp"
#include "vehicle/road_ground.hpp"

namespace {

int roads(const char* network) {
  const roadquery::GroundQuery ground(roadquery::read_opendrive(network));
  std::array<roadquery::Cursor, 4> cursors;
  for (std::array<double, 12> row;;) {
    for (double& value : row)
      if (!(std::cin >> value)) return 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto hit = ground.roads().find(row[3 * i], row[3 * i + 1], row[3 * i + 2], cursors[i]);
      if (hit)
        std::printf("%.17g %.17g %.17g %.17g %.17g 1 ", hit->z, hit->normal[0], hit->normal[1], hit->normal[2],
                    hit->friction);
      else
        std::printf("%.17g 0 0 1 0 0 ", row[3 * i + 2]);
    }
    std::printf("\n");
  }
}

void print(const vehicle::State& s) {
  std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %d %.17g", s.x_m, s.y_m, s.z_m,
              s.heading_rad, s.pitch_rad, s.roll_rad, s.speed_mps, s.lateral_mps, s.acceleration_mps2[1], s.engine_rpm,
              s.gear, s.fuel_kg);
  for (const vehicle::WheelState& wheel : s.wheels)
    std::printf(" %.17g %.17g %.17g %.17g", wheel.load_n, wheel.slip_angle_rad, wheel.spin_radps, wheel.travel_m);
  std::printf("\n");
}

int car(char** arguments) {
  const roadquery::RoadQuery query(roadquery::read_opendrive(arguments[0]));
  vehicle::RoadGround ground(query);
  vehicle::Car car(vehicle::read_car(arguments[1]));
  const auto number = [&](int i) { return std::stod(arguments[i]); };
  car.place(number(2), number(3), number(5), number(6), ground, number(4));
  print(car.state());
  vehicle::Controls controls;
  while (std::cin >> controls.steering_rad >> controls.throttle >> controls.brake) {
    for (int i = 0; i < static_cast<int>(number(7)); ++i) car.step(0.001, controls, ground);
    print(car.state());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "roads") == 0) return roads(argv[2]);
  if (argc == 10 && std::strcmp(argv[1], "car") == 0) return car(argv + 2);
  return 2;
}

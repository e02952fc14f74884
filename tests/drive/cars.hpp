// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shipped cars, with a driver each.

#include "orthodrive/drive/car/envelope_table.hpp"
#include "orthodrive/drive/drive_route.hpp"
#include "paths.hpp"
#include "vehicle/read_car.hpp"

namespace orthodrive::test {

inline vehicle::CarParameters car_of(const char* file) {
  return vehicle::read_car(paths::in_source("models/vehicles") / file);
}

/// On public roads.
inline DriveOptions family() {
  DriveOptions options;
  options.car = car_of("family_car.toml");
  return options;
}

/// At the limit.
inline DriveOptions racing(const char* file) {
  DriveOptions options;
  options.car = car_of(file);
  options.driver = racing_driver();
  options.style = DrivingStyle::racing;
  return options;
}

/// Finds the route and drives it.
inline DriveResult simulate_lap(const roadquery::RoadMap& map, const DriveOptions& options) {
  const roadquery::RoadQuery query(map);
  return drive_route(query, find_route(map, options.route), options, EnvelopeTable(options.car));
}

}  // namespace orthodrive::test

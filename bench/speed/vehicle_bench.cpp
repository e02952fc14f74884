// SPDX-License-Identifier: Apache-2.0
// Steps of a car a second: on a plane, which is the car alone, and on a road that its tyres ask. 300 times real time at
// 1 kHz are 3.3 us a step.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "vehicle/car.hpp"
#include "vehicle/envelope.hpp"
#include "vehicle/read_car.hpp"
#include "vehicle/road_ground.hpp"

namespace {

using namespace vehicle;

constexpr double radius_m = 100.0;

CarParameters preset(const std::string& name) {
  return read_car(std::filesystem::path(ORTHODRIVE_VEHICLES) / (name + ".toml"));
}

/// A ring of 10 m width and 100 m radius about the origin, banked by 0.03, with waves of 10 cm.
roadquery::RoadMap ring() {
  using namespace roadquery;
  Road road;
  road.length = 2.0 * std::numbers::pi * radius_m;
  road.plan = {{0.0, radius_m, 0.0, 0.5 * std::numbers::pi, road.length, Arc{1.0 / radius_m}}};
  for (double s = 0.0; s < road.length; s += 20.0)
    road.elevation.push_back({s, 0.1 * std::sin(0.05 * s), 0.0, 0.0, 0.0});
  road.superelevation = {{0.0, -0.03, 0.0, 0.0, 0.0}};
  Lane lane;
  lane.width = {{0.0, 5.0, 0.0, 0.0, 0.0}};
  LaneSection section;
  lane.id = 1, section.left = {lane};
  lane.id = -1, section.right = {lane};
  road.sections = {section};
  RoadMap map;
  map.roads = {road};
  return map;
}

/// Holds speed and circle.
void drive(benchmark::State& state, Car& car, Ground& ground, double speed_mps) {
  car.place(radius_m, 0.0, 0.5 * std::numbers::pi, speed_mps, ground);
  Controls c;
  double steps = 0.0, off = 0.0;
  for (auto _ : state) {
    const State& s = car.state();
    const double distance = std::hypot(s.x_m, s.y_m);
    const double heading = std::atan2(s.y_m, s.x_m) + 0.5 * std::numbers::pi;
    c.steering_rad =
        0.03 + 0.05 * (distance - radius_m) + 0.5 * std::remainder(heading - s.heading_rad, 2.0 * std::numbers::pi);
    c.throttle = std::clamp(0.2 + 0.3 * (speed_mps - s.speed_mps), 0.0, 1.0);
    car.step(1e-3, c, ground);
    steps += 1.0;
    for (const WheelState& w : s.wheels) off += w.on_road ? 0.0 : 1.0;
  }
  if (off > 0.0 || !(std::abs(std::hypot(car.state().x_m, car.state().y_m) - radius_m) < 4.0)) {
    state.SkipWithError("the car left its circle");
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["real_time"] = benchmark::Counter(1e-3 * steps, benchmark::Counter::kIsRate);
}

void on_a_plane(benchmark::State& state, const std::string& name) {
  Car car(preset(name));
  PlaneGround plane;
  drive(state, car, plane, 20.0);
}
BENCHMARK_CAPTURE(on_a_plane, family_car, std::string("family_car"))->Name("vehicle/plane/family_car");
BENCHMARK_CAPTURE(on_a_plane, sports_car, std::string("sports_car"))->Name("vehicle/plane/sports_car");
BENCHMARK_CAPTURE(on_a_plane, gt3_like, std::string("gt3_like"))->Name("vehicle/plane/gt3_like");

void on_a_road(benchmark::State& state, const std::string& name) {
  const roadquery::RoadQuery query(ring());
  RoadGround ground(query);
  Car car(preset(name));
  drive(state, car, ground, 20.0);
}
BENCHMARK_CAPTURE(on_a_road, family_car, std::string("family_car"))->Name("vehicle/road/family_car");
BENCHMARK_CAPTURE(on_a_road, gt3_like, std::string("gt3_like"))->Name("vehicle/road/gt3_like");

void limits(benchmark::State& state) {
  const CarParameters car = preset("sports_car");
  double speed = 0.0;
  for (auto _ : state) {
    speed = speed < 80.0 ? speed + 0.1 : 5.0;
    benchmark::DoNotOptimize(envelope(car, {.speed_mps = speed, .lateral_mps2 = 5.0}));
  }
}
BENCHMARK(limits)->Name("vehicle/envelope");

}  // namespace

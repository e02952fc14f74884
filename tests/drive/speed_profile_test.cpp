// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/drive/car/speed_profile.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "drive/cars.hpp"
#include "drive/roads.hpp"

namespace orthodrive {
namespace {

using namespace test;

/// East on a level road; a point a metre.
DrivingLine straight(int length_m) {
  DrivingLine line;
  for (int i = 0; i <= length_m; ++i)
    line.points.push_back({.s_m = static_cast<double>(i), .x_m = static_cast<double>(i)});
  return line;
}

void expect_what_it_tabulates(const vehicle::CarParameters& car, double most_share, double drive_mps2 = 0.15) {
  const EnvelopeTable table(car);
  for (const double speed : {4.0, 10.0, 19.4, 33.0, 46.9, 61.5})
    for (const double normal : {8.0, 9.81, 12.3, 16.0})
      for (const double friction : {0.4, 0.9, 1.0})
        for (const double share : {0.0, 0.3, 0.5, 0.7, 0.9}) {
          if (share > most_share) continue;
          const double lateral = share * vehicle::envelope(car, {speed, normal, 0.0, friction}).max_lateral_mps2;
          const vehicle::EnvelopeQuery query{speed, normal, lateral, friction};
          const vehicle::Envelope exact = vehicle::envelope(car, query), looked_up = table.at(query);
          const std::string where =
              fmt::format("{} at {} m/s, {} m/s2, {}, {}", car.name, speed, normal, friction, share);
          EXPECT_NEAR(looked_up.max_lateral_mps2, exact.max_lateral_mps2, 0.15) << where;
          EXPECT_NEAR(looked_up.max_drive_mps2, exact.max_drive_mps2, drive_mps2) << where;
          EXPECT_NEAR(looked_up.max_brake_mps2, exact.max_brake_mps2, 0.2) << where;
        }
}

TEST(EnvelopeTable, agrees_with_what_it_tabulates) {
  for (const char* name : {"gt3_like.toml", "sports_car.toml", "family_car.toml"})
    expect_what_it_tabulates(car_of(name), 1.0);
}

TEST(EnvelopeTable, knows_that_an_engine_drives_both_axles) {
  vehicle::CarParameters car = car_of("sports_car.toml");
  car.differential.front_share = 0.35;
  expect_what_it_tabulates(car, 0.5, 0.3);  // near the lateral limit the share of each axle moves too fast
}

TEST(RoadLoad, a_banked_bend_over_a_crest_is_what_mechanics_says) {
  const LinePoint p{.curvature_1pm = 0.01, .banking = -0.1, .vertical_curvature_1pm = -0.002};
  const RoadLoad load = road_load(p, 20.0);
  EXPECT_NEAR(load.lateral_mps2, 4.0 * std::cos(0.1) - 9.81 * std::sin(0.1), 1e-12);
  EXPECT_NEAR(load.normal_mps2, 9.81 * std::cos(0.1) + 4.0 * std::sin(0.1) - 0.8, 1e-12);
}

TEST(PlanSpeed, bend_is_driven_at_the_share_of_the_limit_that_the_driver_takes) {
  const vehicle::CarParameters car = car_of("sports_car.toml");
  DrivingLine line = straight(400);
  for (LinePoint& p : line.points) p.curvature_1pm = 0.02;
  const Driver driver = racing_driver();
  const double speed = plan_speed(line, EnvelopeTable(car), driver)[200];
  // The drag has to be overcome: it takes the share at which just so much drive is left.
  const double lateral = 0.02 * speed * speed, limit = vehicle::envelope(car, {.speed_mps = speed}).max_lateral_mps2;
  const auto drive_at = [&](double share) {
    return vehicle::envelope(car, {.speed_mps = speed, .lateral_mps2 = lateral / share}).max_drive_mps2;
  };
  EXPECT_NEAR(drive_at(driver.grip_share), 0.0, 0.05);
  EXPECT_LT(lateral / limit, driver.grip_share);
  EXPECT_GT(lateral / limit, driver.grip_share - 0.0125);
}

TEST(PlanSpeed, crest_slows_and_banking_that_helps_quickens) {
  const EnvelopeTable table(car_of("sports_car.toml"));
  const auto speed_with = [&](double banking, double vertical) {
    DrivingLine line = straight(400);
    for (LinePoint& p : line.points) p.curvature_1pm = 0.01, p.banking = banking, p.vertical_curvature_1pm = vertical;
    return plan_speed(line, table, racing_driver())[200];
  };
  EXPECT_LT(speed_with(0.0, -0.004), 0.95 * speed_with(0.0, 0.0));
  EXPECT_GT(speed_with(0.0, 0.004), 1.02 * speed_with(0.0, 0.0));
  EXPECT_GT(speed_with(-0.1, 0.0), 1.03 * speed_with(0.0, 0.0));
  EXPECT_LT(speed_with(0.1, 0.0), 0.97 * speed_with(0.0, 0.0));
}

TEST(PlanSpeed, a_bank_too_steep_to_stand_on_has_a_least_speed) {
  const EnvelopeTable table(car_of("family_car.toml"));
  const Driver driver;
  DrivingLine line = straight(400);
  line.closed = true;
  for (LinePoint& p : line.points) p.curvature_1pm = 0.008, p.banking = -std::numbers::pi / 3.0;  // 60 degrees
  const std::vector<double> speed = plan_speed(line, table, driver);
  EXPECT_NEAR(speed[200], driver.max_speed_mps, 0.02) << "no speed is comfortable, this one holds the car";
  EXPECT_FALSE(first_too_steep_bank(line, table, driver, speed));

  SpeedCaps caps;
  caps.legal_mps.assign(line.points.size(), 10.0);
  const auto slow = first_too_steep_bank(line, table, driver, plan_speed(line, table, driver, caps));
  ASSERT_TRUE(slow && slow->least_mps);
  EXPECT_EQ(slow->point, 0u);
  const RoadLoad load = road_load(line.points[0], *slow->least_mps);
  const double able = table.max_lateral_mps2({*slow->least_mps, load.normal_mps2, load.lateral_mps2, 1.0});
  EXPECT_NEAR(std::abs(load.lateral_mps2), driver.grip_share * able, 0.02);

  for (LinePoint& p : line.points) p.curvature_1pm = 0.0;
  const auto none = first_too_steep_bank(line, table, driver, plan_speed(line, table, driver));
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->least_mps);
  for (LinePoint& p : line.points) p.banking = 0.3;
  EXPECT_FALSE(first_too_steep_bank(line, table, driver, plan_speed(line, table, driver)));
}

TEST(PlanSpeed, never_asks_for_more_than_the_envelope_or_the_driver_gives) {
  const vehicle::CarParameters car = car_of("gt3_like.toml");
  const EnvelopeTable table(car);
  DrivingLine line = straight(900);
  for (int i = 400; i < 460; ++i) line.points[static_cast<std::size_t>(i)].curvature_1pm = 0.02;
  const std::vector<double> speed = plan_speed(line, table, racing_driver());
  for (std::size_t i = 1; i + 1 < speed.size(); ++i) {
    const double a = 0.5 * (speed[i] * speed[i] - speed[i - 1] * speed[i - 1]);
    const RoadLoad load = road_load(line.points[i], speed[i]), before = road_load(line.points[i - 1], speed[i - 1]);
    ASSERT_LE(a, table.at({speed[i - 1], before.normal_mps2, before.lateral_mps2, 1.0}).max_drive_mps2 + 1e-6) << i;
    const double brake = table.at({speed[i], load.normal_mps2, load.lateral_mps2, 1.0}).max_brake_mps2;
    ASSERT_GE(a, -brake - 1e-6) << i;
    ASSERT_LE(std::abs(load.lateral_mps2), table.at({speed[i]}).max_lateral_mps2) << i;
  }
  EXPECT_GT(speed[380], speed[430] + 3.0);
}

TEST(PlanSpeed, speed_limits_hold_and_the_comfort_of_passengers) {
  const EnvelopeTable table(car_of("family_car.toml"));
  const DrivingLine line = straight(600);
  SpeedCaps caps;
  caps.legal_mps.assign(line.points.size(), 20.0);
  for (std::size_t i = 300; i < 400; ++i) caps.legal_mps[i] = 10.0;
  const Driver driver;
  const std::vector<double> speed = plan_speed(line, table, driver, caps);
  for (std::size_t i = 1; i < speed.size(); ++i) {
    ASSERT_LE(speed[i], caps.legal_mps[i] + 1e-9);
    const double a = 0.5 * (speed[i] * speed[i] - speed[i - 1] * speed[i - 1]);
    ASSERT_LE(a, driver.max_drive_mps2 + 1e-9) << i;
    ASSERT_GE(a, -driver.max_brake_mps2 - 1e-9) << i;
  }
  EXPECT_NEAR(speed[250], 20.0, 1e-6);
}

TEST(LegalSpeeds, are_those_of_the_place_and_of_the_lane) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 600.0, roadquery::Line{}});
  road.speed_limit_mps = 30.0;
  road.speed_limits = {{0.0, 30.0}, {200.0, 20.0}};
  road.sections[0].right[0].speeds = {{400.0, 8.0}};
  road.sections[0].left[0].speeds = {{500.0, 5.0}};
  const roadquery::RoadQuery query(map_of({road}));
  Route route;
  route.steps = {{0, true}};
  DrivingLine line = straight(600);
  for (LinePoint& p : line.points) p.y_m = -1.75;
  const std::vector<double> legal = legal_speeds(query, route, line);
  for (const auto& [s, mps] : {std::pair(100, 30.0), {199, 30.0}, {201, 20.0}, {399, 20.0}, {401, 8.0}, {590, 8.0}})
    EXPECT_EQ(legal[static_cast<std::size_t>(s)], mps) << s;
}

TEST(PlanSpeed, long_climb_slows_to_the_speed_at_which_force_balances) {
  const vehicle::CarParameters car = car_of("family_car.toml");
  DrivingLine line = straight(6000);
  for (LinePoint& p : line.points) p.gradient = 0.15;
  Driver driver = racing_driver();
  driver.grip_share = 1.0;
  const double v = plan_speed(line, EnvelopeTable(car), driver)[5000];
  const double cosine = 1.0 / std::hypot(1.0, 0.15), weight_n = car.body.mass_kg * vehicle::gravity_mps2;
  const double fourth = std::pow(v / 16.67, 4.0);
  const double rolling = car.front_tyre.rolling_resistance + car.front_tyre.rolling_resistance_v4 * fourth;
  const double needed_n =
      weight_n * (0.15 + rolling) * cosine + 0.5 * car.aero.air_density_kgpm3 * car.aero.drag_area_m2 * v * v;
  EXPECT_NEAR(needed_n / vehicle::full_drive(car, v).force_n, 1.0, 0.005) << v;
}

TEST(GiveWay, one_stops_before_the_junction_where_others_go_first) {
  Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}}), b = make_road(2, {0.0, 100.0, 0.0, 0.0, 20.0, Line{}}),
       c = make_road(3, {0.0, 120.0, 0.0, 0.0, 100.0, Line{}});
  b.junction = 9;
  a.speed_limit_mps = b.speed_limit_mps = c.speed_limit_mps = 14.0;
  link(a, b), link(b, c);
  RoadMap map = map_of({a, b, c});
  map.junctions = {{9, "", {}, {{7, 2}}, {}}};
  DriveOptions options = family();
  options.stops = true;
  const roadquery::RoadQuery query(map);
  const Route route{{{0, true}, {1, true}, {2, true}}, false, "through", 220.0};
  const DriveResult drive = drive_route(query, route, options, EnvelopeTable(options.car));
  EXPECT_TRUE(drive.finished);
  EXPECT_EQ(drive.stops, 1);
  double standing_s = 0.0, most_mps = 0.0;
  for (const DriveSample& s : drive.samples) {
    most_mps = std::max(most_mps, s.speed_mps);
    if (s.speed_mps > 0.2) continue;
    if (s.x_m < 50.0) continue;
    standing_s += 0.01;
    EXPECT_NEAR(s.x_m, 97.0, 4.0);
  }
  EXPECT_NEAR(standing_s, options.driver.stop_s, 1.0);
  EXPECT_LT(most_mps, 14.3);
  EXPECT_GT(most_mps, 13.0);
}

}  // namespace
}  // namespace orthodrive

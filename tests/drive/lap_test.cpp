// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <tuple>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/drive/car/speed_profile.hpp"
#include "orthodrive/drive/drive_route.hpp"
#include "orthodrive/drive/line/lane_path.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

using namespace test;

bool has_finding(const DriveResult& result, const std::string& code) {
  return std::any_of(result.findings.begin(), result.findings.end(), [&](const Finding& f) { return f.code == code; });
}

std::string message_of(const DriveResult& result, const std::string& code) {
  for (const Finding& f : result.findings)
    if (f.code == code) return f.message;
  return {};
}

/// Springs (and bars) of an axle at one wheel in series with its tyre.
double at_wheel_npm(const vehicle::Suspension& s, const vehicle::Tyre& t, double bar_share) {
  const double spring = s.spring_npm + bar_share * s.anti_roll_npm;
  return spring * t.vertical_npm / (spring + t.vertical_npm);
}

/// How far the body leans on its springs when the tyres give so much sideways: roll moment over roll stiffness, less
/// what the weight adds as it leans.
double lean_rad(const vehicle::CarParameters& car, double lateral_mps2, double normal_mps2) {
  const vehicle::Body& b = car.body;
  const auto stiffness = [](const vehicle::Suspension& s, const vehicle::Tyre& t) {
    return 0.5 * s.track_m * s.track_m * at_wheel_npm(s, t, 2.0);
  };
  const double axis_m = b.front_share * car.front.roll_centre_m + (1.0 - b.front_share) * car.rear.roll_centre_m;
  const double arm_nm = b.mass_kg * (b.cg_height_m - axis_m);
  return arm_nm * lateral_mps2 /
         (stiffness(car.front, car.front_tyre) + stiffness(car.rear, car.rear_tyre) - arm_nm * normal_mps2);
}

/// Stiffness of all springs against heave over the mass they carry: so far the body sinks for each m/s2.
double heave_stiffness_ps2(const vehicle::CarParameters& car) {
  const double sprung_kg = car.body.mass_kg - 2.0 * (car.front.unsprung_mass_kg + car.rear.unsprung_mass_kg);
  return 2.0 * (at_wheel_npm(car.front, car.front_tyre, 0.0) + at_wheel_npm(car.rear, car.rear_tyre, 0.0)) / sprung_kg;
}

TEST(SimulateLap, centre_line_is_driven_as_it_is) {
  DriveOptions options = racing("sports_car.toml");
  options.style = DrivingStyle::centre;
  options.driver.max_lateral_mps2 = 5.0;
  const DriveResult lap = simulate_lap(map_of({make_circle(1, 50.0)}), options);
  EXPECT_TRUE(lap.finished);
  EXPECT_NEAR(lap.length_m, 2.0 * std::numbers::pi * 50.0, 0.05);  // not the lane's centre
  for (const LinePoint& p : lap.line.points) EXPECT_NEAR(std::hypot(p.x_m, p.y_m), 50.0, 0.005);
  EXPECT_NEAR(lap.mean_speed_mps, std::sqrt(5.0 * 50.0), 0.2);
  EXPECT_LT(lap.max_line_error_m, 0.3);
  EXPECT_EQ(lap.tyre_misses, 0u);
  options.style = DrivingStyle::racing;
  // The line of least curvature is the widest circle.
  EXPECT_GT(simulate_lap(map_of({make_circle(1, 50.0)}), options).length_m, 2.0 * std::numbers::pi * 51.0);
}

TEST(SimulateLap, circle_is_driven_at_the_speed_that_the_lateral_limit_allows) {
  const DriveResult lap = simulate_lap(map_of({make_circle(1, 50.0)}), family());
  const double radius_m = 51.75;  // the centre of the outer lane
  EXPECT_TRUE(lap.finished);
  EXPECT_TRUE(lap.findings.empty());
  EXPECT_NEAR(lap.length_m, 2.0 * std::numbers::pi * radius_m, 0.05);
  EXPECT_NEAR(lap.mean_speed_mps, std::sqrt(4.0 * radius_m), 0.05);
  EXPECT_NEAR(lap.max_lateral_mps2, 4.0, 0.15);
  EXPECT_LT(lap.max_line_error_m, 0.05);
  EXPECT_EQ(lap.tyre_misses, 0u);
  EXPECT_NEAR(static_cast<double>(lap.tyre_queries), 4000.0 * lap.lap_time_s, 4.0 * 20.0);
  for (const DriveSample& s : lap.samples) {
    EXPECT_NEAR(std::hypot(s.x_m, s.y_m), radius_m, 0.1);
    EXPECT_NEAR(s.curvature_1pm, 1.0 / radius_m, 5e-5);
  }
}

TEST(SimulateLap, banking_that_helps_makes_the_circle_faster_by_what_gravity_gives) {
  Road circle = make_circle(1, 50.0);
  const double bank = std::atan(0.1);
  circle.superelevation = {{.s = 0.0, .a = -bank}};  // left turn: right side higher
  const DriveResult lap = simulate_lap(map_of({circle}), family());
  const double radius_m = 50.0 + 1.75 * std::cos(bank);
  EXPECT_NEAR(lap.mean_speed_mps, std::sqrt((4.0 + 9.80665 * std::sin(bank)) * radius_m), 0.1);
  // The tyres give 4 m/s2 in the road's plane; a bend that is banked presses the car down.
  const double turn_mps2 = lap.mean_speed_mps * lap.mean_speed_mps / radius_m;
  const double lean = lean_rad(family().car, 4.0, 9.80665 * std::cos(bank) + turn_mps2 * std::sin(bank));
  EXPECT_NEAR(lean, 0.039, 1e-3);
  for (const DriveSample& s : lap.samples) {
    EXPECT_NEAR(s.banking_rad, -bank, 1e-3);
    EXPECT_NEAR(s.roll_rad, -bank + lean, 2e-3);
  }
}

TEST(SimulateLap, heights_follow_a_hill_and_an_open_road_is_driven_to_its_end) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 200.0, Line{}});
  // Up 10 m and down again: 100 + 0.003 s^2 - 2e-5 s^3 from 0 to 100, mirrored.
  road.elevation = {{0.0, 100.0, 0.0, 0.003, -2e-5}, {100.0, 110.0, 0.0, -0.003, 2e-5}};
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_TRUE(has_finding(lap, "drive.open_route"));
  EXPECT_EQ(lap.tyre_misses, 0u);
  EXPECT_NEAR(lap.length_m, 200.0 - family().car.body.wheelbase_m - 1.0, 0.1);
  EXPECT_LT(lap.max_height_step_m, 1e-5);  // the surface is smooth: only its curvature over 4 cm is left
  EXPECT_NEAR(lap.climb_m, 10.0, 0.1);
  EXPECT_NEAR(lap.max_gradient, 0.15, 2e-3);
  ASSERT_GT(lap.samples.size(), 100u);
  const double heave_ps2 = heave_stiffness_ps2(family().car);
  for (const DriveSample& s : lap.samples) {
    // On its springs the body rises where the road falls away. The mean of axle heights 1.35 m ahead and behind differs
    // from the middle by z'' 1.35^2 / 2 < 6 mm.
    EXPECT_NEAR(s.z_m, roadquery::elevation(road, s.x_m) - s.a_vert_mps2 / heave_ps2, 0.007) << s.x_m;
    EXPECT_NEAR(s.gradient, roadquery::gradient(road, s.x_m), 2e-3) << s.x_m;
    EXPECT_NEAR(s.y_m, -1.75, 0.01);
    EXPECT_EQ(s.road_id, 1);
    EXPECT_NEAR(s.road_s_m, s.x_m, 1e-6);
  }
}

TEST(SimulateLap, samples_are_10_ms_apart_and_move_forward) {
  const DriveResult lap = simulate_lap(map_of(make_stadium(1, 458000.0, 5540000.0, 150.0, 30.0)), family());
  ASSERT_GT(lap.samples.size(), 1000u);
  for (std::size_t i = 1; i < lap.samples.size(); ++i) {
    const DriveSample &a = lap.samples[i - 1], &b = lap.samples[i];
    ASSERT_NEAR(b.t_s - a.t_s, 0.01, 1e-9);
    ASSERT_GT(b.s_m, a.s_m);
    ASSERT_NEAR(std::hypot(b.x_m - a.x_m, b.y_m - a.y_m), 0.01 * b.speed_mps, 0.02);
    for (int wheel = 0; wheel < 4; ++wheel) ASSERT_NEAR(b.wheel_z_m[static_cast<std::size_t>(wheel)], 0.0, 1e-9);
    double load_n = 0.0;
    for (const double wheel_n : b.load_n) load_n += wheel_n;
    ASSERT_NEAR(load_n, family().car.body.mass_kg * 9.81, 0.1 * family().car.body.mass_kg * 9.81);
  }
  // The car brakes for the bends and stays within what the driver asks for.
  EXPECT_TRUE(lap.finished);
  EXPECT_GT(lap.max_speed_mps, 18.0);
  EXPECT_LT(lap.max_lateral_mps2, 4.6);
  EXPECT_LT(lap.max_braking_mps2, 4.6);
  EXPECT_LT(lap.max_line_error_m, 0.2);
  EXPECT_EQ(lap.tyre_misses, 0u);
}

TEST(SimulateLap, step_between_two_roads_is_measured_and_found) {
  Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, 60.0, Line{}}, 5.0),
       b = make_road(2, {0.0, 60.0, 0.0, 0.0, 60.0, Line{}}, 5.06);
  link(a, b);
  const DriveResult lap = simulate_lap(map_of({a, b}), family());
  EXPECT_NEAR(lap.max_height_step_m, 0.06, 1e-6);
  EXPECT_NEAR(lap.max_height_step_s_m, 60.0, 3.0);
  EXPECT_TRUE(has_finding(lap, "drive.bump"));
}

TEST(SimulateLap, hole_in_the_road_is_counted_per_tyre) {
  Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, 60.0, Line{}}), b = make_road(2, {0.0, 64.0, 0.0, 0.0, 60.0, Line{}});
  link(a, b);
  const DriveResult lap = simulate_lap(map_of({a, b}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_TRUE(has_finding(lap, "drive.off_road"));
  // Each tyre misses the road over 4 m less the two seams of 0.25 m.
  const auto there =
      std::find_if(lap.samples.begin(), lap.samples.end(), [](const DriveSample& s) { return s.s_m > 62.0; });
  ASSERT_NE(there, lap.samples.end());
  EXPECT_NEAR(static_cast<double>(lap.tyre_misses) / 4.0 * 1e-3 * there->speed_mps, 3.5, 0.2);
}

TEST(SimulateLap, lane_jump_between_roads_is_driven_smoothly) {
  Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, 150.0, Line{}}), b = make_road(2, {0.0, 150.0, 0.0, 0.0, 150.0, Line{}});
  b.sections[0].right.push_back(roadquery::test::make_lane(-2, 3.5));  // the outermost lane is now one further right
  link(a, b);
  const DriveResult lap = simulate_lap(map_of({a, b}), family());
  EXPECT_TRUE(lap.finished);
  EXPECT_EQ(lap.tyre_misses, 0u);
  EXPECT_LT(lap.max_lateral_mps2, 4.6);
  EXPECT_NEAR(lap.samples.back().y_m, -5.25, 0.05);
}

TEST(SimulateLap, bend_banked_too_steeply_to_stand_on_is_driven_fast_enough) {
  Road circle = make_circle(1, 125.0);
  const double bank = std::numbers::pi / 180.0 * 50.0;
  circle.superelevation = {{.s = 0.0, .a = -bank}};  // as on a velodrome or a proving ground
  const DriveResult lap = simulate_lap(map_of({circle}), family());
  EXPECT_TRUE(lap.finished);
  for (const char* code : {"drive.too_tight", "drive.steep_bank", "drive.off_road", "drive.not_finished"})
    EXPECT_FALSE(has_finding(lap, code)) << code;
  EXPECT_EQ(lap.tyre_misses, 0u);
  // The bend presses the car down by what passengers bear.
  const double turn_mps2 = (family().driver.max_vertical_mps2 + 9.80665 * (1.0 - std::cos(bank))) / std::sin(bank);
  EXPECT_NEAR(lap.mean_speed_mps, std::sqrt(turn_mps2 * (125.0 + 1.75 * std::cos(bank))), 0.3);
}

TEST(SimulateLap, bank_that_the_car_slides_down_is_said) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}});
  road.superelevation = {{.s = 0.0, .a = std::numbers::pi / 180.0 * 60.0}};
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_FALSE(lap.finished);
  EXPECT_NE(message_of(lap, "drive.steep_bank").find("banked by 60 degrees: the car slides down it at any speed"),
            std::string::npos);
}

TEST(SimulateLap, sidewalks_and_shoulders_are_no_room_to_drive_in) {
  // Lanes so narrow that drivers keep off the edge, and a jump of the lane that is made up where there is room.
  const auto drive = [](bool with_sidewalks) {
    Road a = make_road(1, {0.0, 0.0, 0.0, 0.0, 150.0, Line{}}, 0.0, 2.4),
         b = make_road(2, {0.0, 150.0, 0.0, 0.0, 150.0, Line{}}, 0.0, 3.2);
    if (with_sidewalks)
      for (Road* road : {&a, &b})
        for (auto* side : {&road->sections[0].left, &road->sections[0].right}) {
          roadquery::Lane shoulder = roadquery::test::make_lane(side == &road->sections[0].left ? 2 : -2, 0.5);
          shoulder.type = roadquery::LaneType::shoulder;
          roadquery::Lane sidewalk = roadquery::test::make_lane(side == &road->sections[0].left ? 3 : -3, 2.0);
          sidewalk.type = roadquery::LaneType::sidewalk;
          side->push_back(shoulder), side->push_back(sidewalk);
        }
    link(a, b);
    return simulate_lap(map_of({a, b}), family());
  };
  const DriveResult with = drive(true), without = drive(false);
  ASSERT_EQ(with.samples.size(), without.samples.size());
  for (std::size_t i = 0; i < with.samples.size(); ++i)
    ASSERT_NEAR(with.samples[i].y_m, without.samples[i].y_m, 1e-5) << i;  // what the line's solver leaves
}

TEST(SimulateLap, stops_before_a_hairpin_below_the_turning_circle_and_says_so) {
  // A radius of 1 m: with lanes of 3.5 m the asphalt ends at 4.5 m, and the outer front wheel runs at 5.4 m at least.
  const DriveResult lap = simulate_lap(map_of(make_stadium(1, 0.0, 0.0, 80.0, 1.0)), family());
  EXPECT_FALSE(lap.finished);
  EXPECT_TRUE(has_finding(lap, "drive.too_tight"));
  EXPECT_FALSE(has_finding(lap, "drive.not_finished"));
  EXPECT_EQ(lap.tyre_misses, 0u);
  EXPECT_NEAR(lap.length_m, 80.0, 10.0);
}

TEST(SimulateLap, hairpin_as_narrow_as_the_turning_circle_is_driven_on_the_asphalt) {
  const DriveOptions options = family();
  const vehicle::Body& body = options.car.body;
  const double rear_m = body.wheelbase_m / std::tan(options.car.steering.max_wheel_rad);
  const double turning_m = std::hypot(rear_m + 0.5 * options.car.front.track_m, body.wheelbase_m);
  EXPECT_NEAR(turning_m, 5.0, 0.1);  // the outer front tyre, at full lock
  const DriveResult lap = simulate_lap(map_of(make_stadium(1, 0.0, 0.0, 80.0, 2.2)), options);  // asphalt to 5.7 m
  EXPECT_TRUE(lap.finished);
  EXPECT_EQ(lap.tyre_misses, 0u);
}

TEST(SimulateLap, same_roads_same_samples) {
  const RoadMap map = map_of(make_stadium(1, 458000.0, 5540000.0, 150.0, 30.0));
  const DriveResult a = simulate_lap(map, family()), b = simulate_lap(map, family());
  ASSERT_GT(a.samples.size(), 100u);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  const auto values = [](const DriveSample& s) {
    return std::tuple(s.t_s, s.s_m, s.x_m, s.y_m, s.z_m, s.heading_rad, s.pitch_rad, s.roll_rad, s.speed_mps,
                      s.a_lon_mps2, s.a_lat_mps2, s.curvature_1pm, s.gradient, s.road_id, s.road_s_m, s.road_t_m,
                      s.wheel_z_m, s.load_n, s.slip_ratio, s.slip_angle_rad, s.throttle, s.brake, s.gear);
  };
  for (std::size_t i = 0; i < a.samples.size(); ++i) ASSERT_EQ(values(a.samples[i]), values(b.samples[i])) << i;
}

TEST(LanePath, stays_in_its_lane_to_the_end_of_a_road_driven_backwards) {
  // Some of these lengths, cut into pieces and added up, come out 1e-14 m longer than the road.
  for (int k = 0; k < 60; ++k) {
    const double length_m = 20.0 + k / 7.0;
    const RoadMap map = map_of({make_road(1, {0.0, 0.0, 0.0, 0.0, length_m, Line{}})});
    const LanePath path = path_along_lanes(map, {{{0, false}}, false, "back", length_m});
    for (const Vec2 p : path.points) ASSERT_NEAR(p.y, 1.75, 1e-6) << length_m << " at " << p.x;
  }
}

TEST(SimulateLap, car_that_rolls_back_is_given_up_at_once) {
  // 70 %: two driven wheels do not carry it up; it rolled back on nothing for four times the planned time.
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 100.0, Line{}});
  road.elevation = {{0.0, 0.0, 0.7, 0.0, 0.0}};
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_FALSE(lap.finished);
  EXPECT_NE(message_of(lap, "drive.not_finished").find("rolls back"), std::string::npos);
  EXPECT_EQ(message_of(lap, "drive.open_route").find("drove"), std::string::npos);
  EXPECT_LT(lap.driven_s, 20.0);
  EXPECT_GE(lap.lap_time_s, 0.0);
}

TEST(SimulateLap, car_that_stands_is_given_up_after_a_minute) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 2000.0, Line{}});
  for (auto* side : {&road.sections[0].left, &road.sections[0].right})
    (*side)[0].materials = {{.friction = 1e-3}};  // 2 km on ice: the plan itself takes an hour
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_FALSE(lap.finished);
  EXPECT_NE(message_of(lap, "drive.not_finished").find("stopped or far too slow"), std::string::npos);
  EXPECT_LT(lap.driven_s, 400.0);
}

TEST(SimulateLap, car_drives_on_what_is_hardly_longer_than_itself) {
  for (const double length_m : {6.0, 7.5, 10.0}) {
    const DriveResult lap = simulate_lap(map_of({make_road(1, {0.0, 0.0, 0.0, 0.0, length_m, Line{}})}), family());
    EXPECT_TRUE(lap.finished) << length_m;
    EXPECT_EQ(lap.tyre_misses, 0u) << length_m;
    EXPECT_NEAR(lap.length_m, length_m - family().car.body.wheelbase_m - 1.0, 0.1) << length_m;
  }
}

TEST(SimulateLap, what_is_shorter_than_a_car_is_not_driven_and_said) {
  const DriveResult lap = simulate_lap(map_of({make_road(1, {0.0, 40.0, 20.0, 0.0, 5.0, Line{}})}), family());
  EXPECT_NE(message_of(lap, "drive.too_short").find("only 5.0 m long, need at least 6 m"), std::string::npos);
  ASSERT_EQ(lap.findings.size(), 1u);
  EXPECT_EQ(lap.findings[0].x_m, 40.0);
  EXPECT_EQ(lap.findings[0].y_m, 20.0);
  EXPECT_FALSE(lap.finished);
  EXPECT_TRUE(lap.samples.empty());
  EXPECT_EQ(lap.length_m, 0.0);
}

TEST(SimulateLap, open_road_has_one_lap_whatever_the_car_does) {
  // As esmini's tilted crest: banked by 45 degrees, where every car slides off.
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 20.0, Line{}});
  road.elevation = {{0.0, 0.0, 0.0, 0.15, -0.005}};
  road.superelevation = {{0.0, std::numbers::pi / 4.0, 0.0, 0.0, 0.0}};
  const DriveResult lap = simulate_lap(map_of({road}), family());
  EXPECT_LE(lap.lap_times_s.size(), 1u);
  EXPECT_GT(lap.lap_time_s, 0.0);
}

TEST(SimulateLap, other_peoples_networks_can_be_driven) {
  const std::string folder = paths::in_source("../shared/data/opendrive/samples/").string();
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no sample files at " << folder;
  for (const char* name : {"esmini_fabriksgatan.xodr", "esmini_multi_intersections.xodr", "qc_positive18.xodr"}) {
    const DriveResult lap = simulate_lap(roadquery::read_opendrive(folder + name), family());
    EXPECT_TRUE(lap.finished) << name;
    EXPECT_GT(lap.length_m, 100.0) << name;
    EXPECT_LT(lap.off_road_share, 0.01) << name;
  }
}

}  // namespace
}  // namespace orthodrive

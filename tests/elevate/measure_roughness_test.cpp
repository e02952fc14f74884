// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/measure_roughness.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "elevate/record_measured.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

constexpr double length_m = 600.0;

RoadNetwork straight_road() {
  RoadPath path{.osm_id = 3, .highway = "primary"};
  for (double s = 0.0; s <= length_m; s += 2.0) path.nodes.push_back({.p = {s, 0.0}, .s_m = s, .width_m = 7.0});
  return {{"EPSG:32633"}, {path}};
}

std::vector<RoughnessStretch> stretch(double gd_n0_m3) {
  return {{.osm_id = 3, .s_begin_m = -50.0, .s_end_m = length_m + 50.0, .gd_n0_m3 = gd_n0_m3}};
}

/// State of a quarter car: body and wheel, place and speed.
using State = std::array<double, 4>;
State change(const QuarterCar& car, const State& x, double road_m) {
  const double strut = car.spring_stiffness_1ps2 * (x[2] - x[0]) + car.damping_1ps * (x[3] - x[1]);
  return {x[1], strut, x[3], (car.tyre_stiffness_1ps2 * (road_m - x[2]) - strut) / car.unsprung_mass_ratio};
}

/// Two quarter cars behind each other over the mean of both tracks, in time steps of 1 ms (Runge-Kutta, not the
/// transfer function that the inversion uses); what a sensor between the axles feels at 100 Hz.
DriveRecording drive_over(const RoughnessField& field, double speed_mps, const QuarterCar& car,
                          const MeasureRoughnessOptions& options, double noise_mps2 = 0.0) {
  DriveRecording recording;
  Random random(5);
  constexpr double h = 1e-3;
  // Both tracks, every centimetre: waves shorter than 10 cm are not there.
  constexpr double grid = 0.01, before_m = 10.0;
  std::vector<double> profile;
  for (int i = 0; i * grid < length_m + 2.0 * before_m; ++i) {
    const double s = i * grid - before_m;
    profile.push_back(
        0.5 * (field.height_m(s, -1.0 + 0.5 * options.track_m) + field.height_m(s, -1.0 - 0.5 * options.track_m)));
  }
  std::array<State, 2> axles{};
  for (int i = 0; i * h * speed_mps < length_m - 1.0; ++i) {
    const double t = i * h;
    double acceleration = 0.0;
    for (int k = 0; k < 2; ++k) {
      const auto road = [&](double time) {
        const double s = time * speed_mps - (k == 0 ? 0.0 : options.wheelbase_m) +
                         options.wheelbase_m * (1.0 - options.sensor_from_rear);
        const double x = (s + before_m) / grid;
        const auto i = static_cast<std::size_t>(x);
        return profile[i] + (profile[i + 1] - profile[i]) * (x - static_cast<double>(i));
      };
      State& x = axles[k];
      const auto moved = [&](const State& d, double f) {
        return State{x[0] + f * d[0], x[1] + f * d[1], x[2] + f * d[2], x[3] + f * d[3]};
      };
      const double r0 = road(t), r1 = road(t + 0.5 * h), r2 = road(t + h);
      const State k1 = change(car, x, r0), k2 = change(car, moved(k1, 0.5 * h), r1),
                  k3 = change(car, moved(k2, 0.5 * h), r1), k4 = change(car, moved(k3, h), r2);
      acceleration += (k == 0 ? options.sensor_from_rear : 1.0 - options.sensor_from_rear) * k1[1];
      for (int j = 0; j < 4; ++j) x[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
    }
    if (i % 10 == 0)
      recording.imu.push_back(
          {.time_s = t, .specific_force_mps2 = {0.0, 0.0, 9.81 + acceleration + noise_mps2 * random.normal()}});
    if (i % 50 == 0) recording.poses.push_back({.time_s = t, .p = {t * speed_mps, -1.0}, .speed_mps = speed_mps});
  }
  return recording;
}

std::vector<RoughnessStretch> measured(const DriveRecording& recording, const MeasureRoughnessOptions& options = {}) {
  const RoadNetwork roads = straight_road();
  const MatchLogResult match = LogMatcher(roads).match(recording, "a");
  return measure_roughness(roads, {{&recording, &match.places}}, options);
}

TEST(MeasureRoughness, known_unevenness_comes_back) {
  struct Case {
    char road_class;
    double speed_mps;
  };
  for (const auto& [road_class, speed_mps] : {Case{'A', 22.0}, Case{'B', 12.0}, Case{'D', 17.0}}) {
    const double truth = iso_8608_mean_m3(road_class);
    const MeasureRoughnessOptions options;
    const auto stretches =
        measured(drive_over({stretch(truth), 17, {.waves = 400}}, speed_mps, options.car, options, 0.1), options);
    ASSERT_EQ(stretches.size(), 6u);
    double mean_ln = 0.0, mean_w = 0.0;
    for (const RoughnessStretch& s : stretches) {
      EXPECT_NEAR(std::log(s.gd_n0_m3 / truth), 0.0, std::log(2.0))
          << road_class << " at " << speed_mps << " m/s, " << s.s_begin_m;
      EXPECT_EQ(s.osm_id, 3);
      EXPECT_GE(s.s_end_m - s.s_begin_m, 100.0 - 1e-9);
      mean_ln += std::log(s.gd_n0_m3 / truth) / 6.0, mean_w += s.waviness / 6.0;
    }
    test::record_measured("class %c at %.0f m/s: G_d(n0) by a factor of %.2f, waviness %.2f", road_class, speed_mps,
                          std::exp(mean_ln), mean_w);
    EXPECT_NEAR(mean_ln, 0.0, std::log(1.35)) << road_class << " at " << speed_mps;
    EXPECT_NEAR(mean_w, 2.0, 0.3);
  }
}

TEST(MeasureRoughness, another_car_errs_by_what_it_says) {
  const double truth = iso_8608_mean_m3('B');
  const MeasureRoughnessOptions options;
  const QuarterCar van{
      .tyre_stiffness_1ps2 = 500.0, .spring_stiffness_1ps2 = 45.0, .damping_1ps = 4.0, .unsprung_mass_ratio = 0.12};
  const auto assumed = measured(drive_over({stretch(truth), 17, {.waves = 400}}, 18.0, van, options));
  MeasureRoughnessOptions known;
  known.car = van, known.sigma_ln_car = 0.05;
  const auto right = measured(drive_over({stretch(truth), 17, {.waves = 400}}, 18.0, van, options), known);
  double error_assumed = 0.0, error_known = 0.0;
  for (const auto& s : assumed) {
    error_assumed += std::log(s.gd_n0_m3 / truth) / 6.0;
    EXPECT_GT(s.sigma_ln_gd, 0.5);
  }
  for (const auto& s : right) {
    error_known += std::log(s.gd_n0_m3 / truth) / 6.0;
    EXPECT_LT(s.sigma_ln_gd, 0.4);
  }
  test::record_measured("another car: factor %.2f with the golden car assumed, %.2f with its own numbers",
                        std::exp(error_assumed), std::exp(error_known));
  EXPECT_LT(std::abs(error_assumed), 1.0);
  EXPECT_LT(std::abs(error_known), std::log(1.35));
}

TEST(MeasureRoughness, slow_driving_and_few_samples_say_nothing) {
  const MeasureRoughnessOptions options;
  EXPECT_THAT(measured(drive_over({stretch(64e-6), 17}, 3.0, options.car, options)), testing::IsEmpty());
  DriveRecording recording = drive_over({stretch(64e-6), 17}, 15.0, options.car, options);
  recording.imu.resize(100);
  EXPECT_THAT(measured(recording), testing::IsEmpty());
  recording.imu.clear();
  EXPECT_THAT(measured(recording), testing::IsEmpty());
}

TEST(QuarterCarGain, limits_are_those_of_the_mechanics) {
  const QuarterCar car;
  const auto gain = [&](double hz) { return std::sqrt(body_acceleration_gain2(car, hz)); };
  const double w = 2 * std::numbers::pi * 0.05;
  EXPECT_NEAR(gain(0.05) / (w * w), 1.0, 0.01);  // slow: the body goes with the road
  const double body_hz = std::sqrt(car.spring_stiffness_1ps2 * car.tyre_stiffness_1ps2 /
                                   (car.spring_stiffness_1ps2 + car.tyre_stiffness_1ps2)) /
                         (2 * std::numbers::pi);
  EXPECT_GT(gain(body_hz) / std::pow(2 * std::numbers::pi * body_hz, 2), 1.3);  // resonance of the body near 1.2 Hz
  EXPECT_LT(gain(40.0) / std::pow(2 * std::numbers::pi * 40.0, 2), 0.02);       // fast: it stays at rest
}

TEST(RoughnessField, its_spectrum_and_its_height_are_those_asked_for) {
  const double gd = 64e-6;
  const RoughnessField field(stretch(gd), 5);
  // Power in octaves along the road, by the discrete Fourier transform of long lines.
  constexpr int n = 4096;
  constexpr double step = 0.05;
  std::array<double, 4> octave_power{};
  double square = 0.0;
  int lines = 0;
  for (double t = -3.0; t <= 3.0; t += 1.0, ++lines) {
    std::vector<double> z(n);
    for (int i = 0; i < n; ++i) z[i] = field.height_m(100.0 + step * i, t), square += z[i] * z[i] / n;
    for (int k = 1; k < n / 2; ++k) {
      const double wave_number = k / (n * step);
      const int octave = static_cast<int>(std::floor(std::log2(wave_number / 0.2)));
      if (octave < 0 || octave > 3) continue;
      double re = 0.0, im = 0.0;
      const double turn = 2 * std::numbers::pi * k / n;
      for (int i = 0; i < n; ++i) {
        const double hann = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 0.5) / n);
        re += hann * z[i] * std::cos(turn * i), im += hann * z[i] * std::sin(turn * i);
      }
      octave_power[octave] += 2.0 * (re * re + im * im) / (0.375 * n) / n;
    }
  }
  for (int o = 0; o < 4; ++o) {
    const double low = 0.2 * std::exp2(o), expected = gd * 0.01 * (1.0 / low - 0.5 / low);
    EXPECT_NEAR(octave_power[o] / lines / expected, 1.0, 0.2) << "octave from " << low << " cycles/m";
  }
  const double expected_rms = std::sqrt(gd * 0.01 * (20.0 - 0.1));
  EXPECT_NEAR(field.rms_m(0), expected_rms, 1e-9);
  EXPECT_NEAR(std::sqrt(square / lines), expected_rms, 0.25 * expected_rms);
}

TEST(RoughnessField, it_is_as_rough_across_as_along) {
  // Over many seeds: the mean square difference of heights 0.3 m apart does not know the direction.
  double along = 0.0, across = 0.0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const RoughnessField field(stretch(64e-6), seed);
    for (int i = 0; i < 40; ++i) {
      const double s = 50.0 + 11.3 * i, z = field.height_m(s, 0.0);
      along += std::pow(field.height_m(s + 0.3, 0.0) - z, 2), across += std::pow(field.height_m(s, 0.3) - z, 2);
    }
  }
  EXPECT_NEAR(across / along, 1.0, 0.25);
}

TEST(RoughnessField, it_is_a_function_of_place_and_seed) {
  const RoughnessField a(stretch(64e-6), 5), b(stretch(64e-6), 5), c(stretch(64e-6), 6);
  EXPECT_EQ(a.height_m(12.34, -1.5), b.height_m(12.34, -1.5));
  EXPECT_NE(a.height_m(12.34, -1.5), c.height_m(12.34, -1.5));
  EXPECT_EQ(a.height_m(length_m + 100.0, 0.0), 0.0);
}

TEST(RoughnessField, stretches_go_over_into_each_other) {
  std::vector<RoughnessStretch> two{{.s_begin_m = 0.0, .s_end_m = 100.0, .gd_n0_m3 = 16e-6},
                                    {.s_begin_m = 100.0, .s_end_m = 200.0, .gd_n0_m3 = 256e-6}};
  const RoughnessField field(two, 5);
  const RoughnessField smooth({{.s_begin_m = 0.0, .s_end_m = 200.0, .gd_n0_m3 = 16e-6}}, 5);
  EXPECT_NEAR(field.height_m(60.0, 1.0), smooth.height_m(60.0, 1.0), 1e-12);
  EXPECT_NEAR(field.height_m(160.0, 1.0), 4.0 * smooth.height_m(160.0, 1.0), 1e-12);
  for (double s = -10.0; s < 210.0; s += 0.01)
    EXPECT_LT(std::abs(field.height_m(s + 0.01, 0.0) - field.height_m(s, 0.0)), 2e-3) << s;
}

TEST(RoughnessClass, limits_are_those_of_the_standard) {
  EXPECT_EQ(iso_8608_class(31e-6), 'A');
  EXPECT_EQ(iso_8608_class(33e-6), 'B');
  EXPECT_EQ(iso_8608_class(511e-6), 'C');
  EXPECT_EQ(iso_8608_class(1.0), 'H');
  for (char c = 'A'; c <= 'H'; ++c) EXPECT_EQ(iso_8608_class(iso_8608_mean_m3(c)), c);
  EXPECT_THROW((void)iso_8608_mean_m3('I'), OptionError);
  EXPECT_THROW((void)RoughnessField({{.s_end_m = 50.0, .waviness = 0.5}}, 1), OptionError);
}

}  // namespace
}  // namespace orthodrive

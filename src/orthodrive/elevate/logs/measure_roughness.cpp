// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/logs/measure_roughness.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/median.hpp"

namespace orthodrive {
namespace {

constexpr double imu_noise_mps2_per_root_hz =
    0.02;                                      // white noise of the sensor and of the engine (a phone's accelerometer)
constexpr double slowest_window_mps = 5.0;     // in slower windows the engine shakes more than the road
constexpr double periodogram_s = 2.56;         // half of each overlaps the next
constexpr double shortest_stretch_m = 100.0;   // a shorter path is one stretch
constexpr double greatest_speed_spread = 0.3;  // within a window, of its mean speed: wave numbers smear by it
constexpr double overlap_information = 0.5;    // half overlapping Hann windows hold twice the independent values

/// One value of a periodogram: power, and what a road of G_d(n0) = 1 m3 and w = 0 would give there.
struct SpectralValue {
  double wave_number = 0.0, power = 0.0, gain = 0.0, noise = 0.0;
};
using StretchKey = std::pair<std::size_t, std::size_t>;  // path, number of the stretch

std::size_t stretch_count(const RoadPath& path) {
  return static_cast<std::size_t>(std::max(1.0, std::floor(path.nodes.back().s_m / shortest_stretch_m)));
}

/// |z_body / z_road|^2 of both axles and both tracks. The rear axle follows over the same profile; the tracks are
/// coherent as those of an isotropic surface of waviness 2 are: x K_1(x), x = 2 pi n track (Kamash and Robson, 1978).
double vehicle_share(const MeasureRoughnessOptions& options, double wave_number) {
  const double f = options.sensor_from_rear, x = 2.0 * std::numbers::pi * wave_number * options.track_m;
  const double axles = f * f + (1.0 - f) * (1.0 - f) +
                       2.0 * f * (1.0 - f) * std::cos(2.0 * std::numbers::pi * wave_number * options.wheelbase_m);
  return axles * 0.5 * (1.0 + (x < 30.0 ? x * std::cyl_bessel_k(1.0, x) : 0.0));
}

/// Mean speed of the poses of a window and the place of its middle; none where the car was on no road, slow or braking.
struct WindowPlace {
  double speed_mps = 0.0;
  LogPlace place;
};
std::optional<WindowPlace> place_window(const MatchedRecording& matched, double from_s, double to_s) {
  const auto& poses = matched.recording->poses;
  const auto index_at = [&](double t) {
    const auto at = std::lower_bound(poses.begin(), poses.end(), t,
                                     [](const DrivePose& p, double time) { return p.time_s < time; });
    return static_cast<std::size_t>(std::min(at, poses.end() - 1) - poses.begin());
  };
  const std::size_t a = index_at(from_s), b = index_at(to_s), middle = index_at(0.5 * (from_s + to_s));
  const std::optional<LogPlace>& in_middle = (*matched.places)[middle];
  if (b <= a || !(*matched.places)[a] || !(*matched.places)[b] || !in_middle) return std::nullopt;
  double low = HUGE_VAL, high = 0.0;
  for (std::size_t i = a; i <= b; ++i) {
    double speed = poses[i].speed_mps;
    if (std::isnan(speed)) {
      const std::size_t k = std::min(i + 1, b);
      if (k == i) continue;
      speed = distance(poses[i].p, poses[k].p) / (poses[k].time_s - poses[i].time_s);
    }
    low = std::min(low, speed), high = std::max(high, speed);
  }
  const double mean = 0.5 * (low + high);
  if (!(low >= slowest_window_mps) || high - low > greatest_speed_spread * mean) return std::nullopt;
  return WindowPlace{mean, *in_middle};
}

double usual_step_s(const std::vector<DriveImu>& imu) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < imu.size(); ++i) steps.push_back(imu[i].time_s - imu[i - 1].time_s);
  return median(std::move(steps));
}

/// Periodograms of the vertical acceleration of a recording, sorted by stretch. One-sided, (m/s^2)^2 / Hz.
void add_windows(const RoadNetwork& roads, const MatchedRecording& matched, const MeasureRoughnessOptions& options,
                 std::map<StretchKey, std::vector<SpectralValue>>& values) {
  const auto& imu = matched.recording->imu;
  if (imu.size() < 3 || matched.recording->poses.size() < 2) return;
  const double step_s = usual_step_s(imu);
  const std::size_t n = static_cast<std::size_t>(periodogram_s / step_s);
  const double highest_hz = std::min(options.highest_hz, 0.4 / step_s);  // sensors roll off before half their rate
  if (n < 16 || highest_hz <= options.lowest_hz) return;
  std::vector<double> hann(n);
  double power = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    hann[i] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
    power += hann[i] * hann[i];
  }
  std::vector<double> x(n);
  for (std::size_t begin = 0; begin + n <= imu.size(); begin += n / 2) {
    const double from_s = imu[begin].time_s, to_s = imu[begin + n - 1].time_s;
    if (std::abs((to_s - from_s) / (static_cast<double>(n - 1) * step_s) - 1.0) > 0.02)
      continue;  // samples are missing
    const auto window = place_window(matched, from_s, to_s);
    if (!window) continue;
    double mean = 0.0, slope = 0.0, squares = 0.0;
    const double middle = 0.5 * static_cast<double>(n - 1);
    for (std::size_t i = 0; i < n; ++i) mean += (x[i] = imu[begin + i].specific_force_mps2.z) / static_cast<double>(n);
    if (!std::isfinite(mean)) continue;
    for (std::size_t i = 0; i < n; ++i) {
      const double t = static_cast<double>(i) - middle;
      slope += t * x[i], squares += t * t;
    }
    for (std::size_t i = 0; i < n; ++i)
      x[i] = (x[i] - mean - slope / squares * (static_cast<double>(i) - middle)) * hann[i];
    const RoadPath& path = roads.paths[window->place.path];
    const std::size_t stretches = stretch_count(path);
    const std::size_t stretch =
        std::min(stretches - 1, static_cast<std::size_t>(std::max(0.0, window->place.s_m) / path.nodes.back().s_m *
                                                         static_cast<double>(stretches)));
    auto& list = values[{window->place.path, stretch}];
    const double bin_hz = 1.0 / (static_cast<double>(n) * step_s);
    for (auto k = static_cast<std::size_t>(std::ceil(options.lowest_hz / bin_hz));
         static_cast<double>(k) * bin_hz <= highest_hz; ++k) {
      std::complex<double> sum = 0.0;
      const std::complex<double> turn =
          std::polar(1.0, -2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
      std::complex<double> phase = 1.0;
      for (std::size_t i = 0; i < n; ++i, phase *= turn) sum += phase * x[i];
      const double hz = static_cast<double>(k) * bin_hz, wave_number = hz / window->speed_mps;
      list.push_back(
          {wave_number, 2.0 * std::norm(sum) * step_s / power,
           body_acceleration_gain2(options.car, hz) * vehicle_share(options, wave_number) / window->speed_mps,
           imu_noise_mps2_per_root_hz * imu_noise_mps2_per_root_hz});
    }
  }
}

/// Fisher scoring of Whittle's likelihood in ln G_d(n0) and w, with the prior of w.
RoughnessStretch fit_spectrum(const std::vector<SpectralValue>& values, const MeasureRoughnessOptions& options) {
  double w = options.waviness, sum = 0.0;
  const auto road = [&](const SpectralValue& v) {
    return v.gain * std::pow(v.wave_number / roughness_n0_cycles_per_m, -w);
  };
  for (const SpectralValue& v : values) sum += std::max(1e-3 * v.power, v.power - v.noise) / road(v);
  double ln_g = std::log(std::max(1e-9, sum / static_cast<double>(values.size()))), variance = 0.0;
  const double prior = 1.0 / (options.waviness_sigma * options.waviness_sigma);
  for (int iteration = 0; iteration < 100; ++iteration) {
    double g1 = 0.0, g2 = -prior * (w - options.waviness), h11 = 1e-6, h12 = 0.0, h22 = prior;
    for (const SpectralValue& v : values) {
      const double signal = std::exp(ln_g) * road(v), model = signal + v.noise;
      const double d1 = signal / model, d2 = -std::log(v.wave_number / roughness_n0_cycles_per_m) * d1;
      const double excess = v.power / model - 1.0;
      g1 += overlap_information * excess * d1, g2 += overlap_information * excess * d2;
      h11 += overlap_information * d1 * d1, h12 += overlap_information * d1 * d2, h22 += overlap_information * d2 * d2;
    }
    const double determinant = h11 * h22 - h12 * h12;
    const double step1 = std::clamp((h22 * g1 - h12 * g2) / determinant, -1.0, 1.0),
                 step2 = std::clamp((h11 * g2 - h12 * g1) / determinant, -0.3, 0.3);
    ln_g = std::max(std::log(1e-10), ln_g + step1), w = std::clamp(w + step2, 1.05, 4.0);
    variance = h22 / determinant;
    if (std::abs(step1) + std::abs(step2) < 1e-9) break;
  }
  RoughnessStretch stretch;
  stretch.gd_n0_m3 = std::exp(ln_g), stretch.waviness = w;
  stretch.sigma_ln_gd = std::sqrt(variance + options.sigma_ln_car * options.sigma_ln_car);
  stretch.iso_8608_class = iso_8608_class(stretch.gd_n0_m3);
  return stretch;
}

}  // namespace

double body_acceleration_gain2(const QuarterCar& car, double frequency_hz) {
  const std::complex<double> s(0.0, 2.0 * std::numbers::pi * frequency_hz);
  const std::complex<double> strut = car.spring_stiffness_1ps2 + car.damping_1ps * s;
  const std::complex<double> body =
      strut * car.tyre_stiffness_1ps2 /
      ((s * s + strut) * (car.unsprung_mass_ratio * s * s + car.tyre_stiffness_1ps2 + strut) - strut * strut);
  return std::norm(s * s * body);
}

std::vector<RoughnessStretch> measure_roughness(const RoadNetwork& roads,
                                                const std::vector<MatchedRecording>& recordings,
                                                const MeasureRoughnessOptions& options) {
  if (!(options.lowest_hz > 0.0)) throw OptionError("roughness: the lowest frequency must be positive");
  std::map<StretchKey, std::vector<SpectralValue>> values;
  for (const MatchedRecording& matched : recordings) add_windows(roads, matched, options, values);
  std::vector<RoughnessStretch> stretches;
  for (const auto& [key, list] : values) {
    if (list.empty()) continue;
    const RoadPath& path = roads.paths[key.first];
    const double length = path.nodes.back().s_m / static_cast<double>(stretch_count(path));
    RoughnessStretch stretch = fit_spectrum(list, options);
    stretch.osm_id = path.osm_id, stretch.part = path.part;
    stretch.s_begin_m = static_cast<double>(key.second) * length,
    stretch.s_end_m = static_cast<double>(key.second + 1) * length;
    stretches.push_back(stretch);
  }
  return stretches;
}

}  // namespace orthodrive

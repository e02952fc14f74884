// SPDX-License-Identifier: Apache-2.0
#pragma once
// The roughness of a road from what a car's body felt of it: vertical acceleration through the inverse of a quarter
// car.

#include <vector>

#include "orthodrive/elevate/logs/match_log.hpp"
#include "orthodrive/model/roads/drive_log.hpp"
#include "orthodrive/model/roads/road_roughness.hpp"

namespace orthodrive {

/// Two masses, two springs, one damper. The defaults, divided by the sprung mass, are those of the golden car of the
/// International Roughness Index (Sayers, On the calculation of IRI from longitudinal road profile, 1995).
struct QuarterCar {
  double tyre_stiffness_1ps2 = 653.0;   ///< k_t / m_s
  double spring_stiffness_1ps2 = 63.3;  ///< k_s / m_s
  double damping_1ps = 6.0;             ///< c_s / m_s
  double unsprung_mass_ratio = 0.15;    ///< m_u / m_s
};

/// |a / z|^2: vertical acceleration of the sprung mass for a road displacement of 1 m amplitude, (1/s^2)^2.
[[nodiscard]] double body_acceleration_gain2(const QuarterCar& car, double frequency_hz);

struct MeasureRoughnessOptions {
  QuarterCar car;
  double wheelbase_m = 2.7, track_m = 1.55;
  double sensor_from_rear = 0.6;                ///< of the wheelbase: a phone at the windscreen
  double sigma_ln_car = 0.5;                    ///< of ln G_d for a car that is not known better than by these numbers
  double lowest_hz = 1.0, highest_hz = 20.0;    ///< below the body's resonance braking and slopes, above the engine
  double waviness = 2.0, waviness_sigma = 0.3;  ///< prior of w (ISO 8608: 2; measured roads 1.5 to 2.7)
};

/// A matched recording.
struct MatchedRecording {
  const DriveRecording* recording = nullptr;
  const std::vector<std::optional<LogPlace>>* places = nullptr;
};

/// G_d(n0) and waviness of every stretch that windows lie on, by maximum likelihood (Whittle, Estimation and
/// information in stationary time series, 1953): the spectrum of acceleration is that of the road times what tyres,
/// springs, both axles and both tracks make of it, plus noise. All recordings on a stretch count together. Ordered by
/// path and s.
[[nodiscard]] std::vector<RoughnessStretch> measure_roughness(const RoadNetwork& roads,
                                                              const std::vector<MatchedRecording>& recordings,
                                                              const MeasureRoughnessOptions& options = {});

}  // namespace orthodrive

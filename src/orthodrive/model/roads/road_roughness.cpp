// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/road_roughness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"

namespace orthodrive {
namespace {

constexpr double longest_wave_m = 20.0;  // longer ones are in the profile

}  // namespace

char iso_8608_class(double gd_n0_m3) {
  char road_class = 'A';
  for (double limit = 32e-6; gd_n0_m3 >= limit && road_class < 'H'; limit *= 4.0) ++road_class;
  return road_class;
}

double iso_8608_mean_m3(char road_class) {
  if (road_class < 'A' || road_class > 'H')
    throw OptionError(fmt::format("'{}' is no road class of ISO 8608, need A to H", road_class));
  return 16e-6 * std::pow(4.0, road_class - 'A');
}

RoughnessField::RoughnessField(std::vector<RoughnessStretch> stretches, std::uint64_t seed,
                               const RoughnessFieldOptions& options) {
  if (!(options.shortest_wave_m > 0.0) || !(longest_wave_m > options.shortest_wave_m) || options.waves < 1)
    throw OptionError("roughness: needs 0 < shortest wave < longest wave, a wave at least");
  half_blend_m_ = 0.5 * 10.0;  // one stretch goes over into the next within 10 m; ends go to 0 inside their stretch
  for (const RoughnessStretch& r : stretches) {
    if (!(r.waviness > 1.0)) throw OptionError("roughness: needs a waviness above 1");
    half_blend_m_ = std::min(half_blend_m_, 0.5 * (r.s_end_m - r.s_begin_m));
  }
  const auto touch = [](const RoughnessStretch& a, const RoughnessStretch& b) {
    return b.s_begin_m - a.s_end_m < 1e-6;
  };
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    const RoughnessStretch& r = stretches[i];
    const bool from_other = i > 0 && touch(stretches[i - 1], r),
               to_other = i + 1 < stretches.size() && touch(r, stretches[i + 1]);
    levels_.push_back(
        {r.s_begin_m + (from_other ? 0.0 : half_blend_m_), r.s_end_m - (to_other ? 0.0 : half_blend_m_), {}});
  }
  Random random(seed);
  const double low = 1.0 / longest_wave_m, ratio = longest_wave_m / options.shortest_wave_m;
  for (int i = 0; i < options.waves; ++i) {
    // One wave a band of a logarithmic division, anywhere in it: no common period, no gap in the PSD.
    const double from = low * std::pow(ratio, static_cast<double>(i) / options.waves),
                 to = low * std::pow(ratio, static_cast<double>(i + 1) / options.waves);
    const double n = random.uniform(from, to);
    const double u = 1.0 - random.uniform(), direction = random.uniform();
    const double phase = 2.0 * std::numbers::pi * random.uniform();
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      const double w = stretches[k].waviness;
      const double power = stretches[k].gd_n0_m3 * std::pow(roughness_n0_cycles_per_m, w) *
                           (std::pow(from, 1.0 - w) - std::pow(to, 1.0 - w)) /
                           (w - 1.0);  // integral of G_d(n0) (n / n0)^-w over the band
      // Student's t with w degrees of freedom over sqrt(w): Bailey, Polar generation of random variates with the
      // t-distribution, 1994.
      const double across = n * std::sqrt(std::pow(u, -2.0 / w) - 1.0) * std::cos(2.0 * std::numbers::pi * direction);
      const double limit = 1.0 / options.shortest_wave_m;  // band limited in every direction
      levels_[k].waves.push_back({std::sqrt(2.0 * power), 2.0 * std::numbers::pi * n,
                                  2.0 * std::numbers::pi * std::clamp(across, -limit, limit), phase});
    }
  }
}

double RoughnessField::height_m(double s_m, double t_m) const {
  const auto step = [&](double x) {  // 0 to 1, with two continuous derivatives
    if (half_blend_m_ <= 0.0) return x >= 0.0 ? 1.0 : 0.0;
    const double u = std::clamp(0.5 * (x / half_blend_m_ + 1.0), 0.0, 1.0);
    return u * u * u * (10.0 + u * (6.0 * u - 15.0));
  };
  auto level = std::partition_point(levels_.begin(), levels_.end(),
                                    [&](const Level& l) { return l.falls_m + half_blend_m_ < s_m; });
  double height_m = 0.0;
  for (; level != levels_.end() && level->rises_m - half_blend_m_ <= s_m; ++level) {
    const double share = step(s_m - level->rises_m) - step(s_m - level->falls_m);
    if (share == 0.0) continue;
    double sum = 0.0;
    for (const Wave& wave : level->waves)
      sum += wave.amplitude_m * std::cos(wave.n_s * s_m + wave.n_t * t_m + wave.phase);
    height_m += share * sum;
  }
  return height_m;
}

double RoughnessField::rms_m(std::size_t stretch) const {
  double power = 0.0;
  for (const Wave& wave : levels_.at(stretch).waves) power += 0.5 * wave.amplitude_m * wave.amplitude_m;
  return std::sqrt(power);
}

}  // namespace orthodrive

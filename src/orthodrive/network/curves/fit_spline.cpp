// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/fit_spline.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "orthodrive/math/cubic_spline.hpp"

namespace orthodrive::network {
namespace {

using roadquery::Cubic;

constexpr double first_knots_m = 64.0;  // apart, to begin with

/// Slope at `at` of the parabola through the samples some 4 m and 8 m further in (or of what there is).
double end_slope(const std::vector<ProfileSample>& samples, bool at_back) {
  constexpr double reach_m = 4.0;
  const std::size_t n = samples.size();
  const auto sample = [&](std::size_t i) { return samples[at_back ? n - 1 - i : i]; };
  const auto away = [&](std::size_t i) { return std::abs(sample(i).s - sample(0).s); };
  std::size_t near = 1;
  while (near + 1 < n && away(near) < reach_m) ++near;
  std::size_t far = near;
  while (far + 1 < n && away(far) < 2.0 * reach_m) ++far;
  const auto slope_to = [&](std::size_t i) {
    return (sample(i).value - sample(0).value) / (sample(i).s - sample(0).s);
  };
  if (far == near) return slope_to(near);
  return (slope_to(near) * away(far) - slope_to(far) * away(near)) / (away(far) - away(near));
}

CubicSpline spline_through(const std::vector<ProfileSample>& knots, bool closed, double slope_begin, double slope_end) {
  std::vector<double> s, values;
  s.reserve(knots.size());
  values.reserve(knots.size());
  for (const ProfileSample& knot : knots) s.push_back(knot.s), values.push_back(knot.value);
  return closed ? periodic_spline(std::move(s), std::move(values))
                : clamped_spline(std::move(s), std::move(values), slope_begin, slope_end);
}

Cubic piece(const ProfileSample& a, const ProfileSample& b, double moment_a, double moment_b) {
  const double h = b.s - a.s;
  return {a.s, a.value, (b.value - a.value) / h - h * (2.0 * moment_a + moment_b) / 6.0, 0.5 * moment_a,
          (moment_b - moment_a) / (6.0 * h)};
}

/// Evenly some 64 m apart, at least three around a closed profile, and the ones asked for.
std::vector<std::size_t> first_knots(const std::vector<ProfileSample>& samples, bool closed,
                                     std::span<const double> exact_s) {
  const std::size_t n = samples.size();
  const auto nearest = [&](double s) {
    const auto after = std::lower_bound(samples.begin(), samples.end(), s,
                                        [](const ProfileSample& sample, double x) { return sample.s < x; });
    const auto i = static_cast<std::size_t>(after - samples.begin());
    return i == n || (i > 0 && s - samples[i - 1].s < samples[i].s - s) ? i - 1 : i;
  };
  const double length_m = samples.back().s - samples.front().s,
               wanted = std::max(closed ? 3.0 : 1.0, std::round(length_m / first_knots_m));
  std::vector<std::size_t> at{0, n - 1};
  for (double k = 1.0; k < wanted; k += 1.0) at.push_back(nearest(samples.front().s + length_m * k / wanted));
  for (const double s : exact_s) at.push_back(nearest(s));
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end()), at.end());
  for (std::size_t i = 1; closed && at.size() < 4; ++i)  // the nodes are unevenly apart
    if (!std::binary_search(at.begin(), at.end(), i)) at.insert(std::upper_bound(at.begin(), at.end(), i), i);
  return at;
}

}  // namespace

ProfileFit fit_spline(std::span<const ProfileSample> all, const FitProfileOptions& options,
                      std::span<const double> exact_s) {
  assert(!all.empty());
  const std::vector<ProfileSample> samples = without_repeats(all);
  const std::size_t n = samples.size();
  const bool closed = options.closed && n > 4;
  ProfileFit fit;
  if (n == 1) {
    fit.cubics.push_back({samples[0].s, samples[0].value, 0.0, 0.0, 0.0});
    return fit;
  }
  std::vector<std::size_t> at = first_knots(samples, closed, exact_s);
  const double slope_begin = end_slope(samples, false), slope_end = end_slope(samples, true);
  for (bool fits = false; !fits;) {
    std::vector<ProfileSample> knots;
    knots.reserve(at.size());
    for (const std::size_t i : at) knots.push_back(samples[i]);
    const std::vector<double> moments = spline_through(knots, closed, slope_begin, slope_end).second;
    fit = {};
    std::vector<std::size_t> finer{0};
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
      fit.cubics.push_back(piece(knots[k], knots[k + 1], moments[k], moments[k + 1]));
      double worst = 0.0;
      for (std::size_t i = at[k] + 1; i < at[k + 1]; ++i)
        worst = std::max(worst, std::abs(value_at(fit.cubics.back(), samples[i].s) - samples[i].value));
      fit.max_error = std::max(fit.max_error, worst);
      if (worst > options.tolerance) {  // at the sample nearest to the middle
        const double middle = 0.5 * (knots[k].s + knots[k + 1].s);
        std::size_t i = at[k] + 1;
        while (i + 1 < at[k + 1] && std::abs(samples[i + 1].s - middle) < std::abs(samples[i].s - middle)) ++i;
        finer.push_back(i);
      }
      finer.push_back(at[k + 1]);
    }
    fits = finer.size() == at.size();
    at = std::move(finer);
  }
  return fit;
}

}  // namespace orthodrive::network

#include "orthodrive/network/fit_spline.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

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

/// Thomas algorithm: diagonal d, off-diagonals below[i] (row i, column i - 1) and above[i] (row i, column i + 1).
std::vector<double> solve_tridiagonal(const std::vector<double>& below, std::vector<double> d,
                                      const std::vector<double>& above, std::vector<double> right) {
  for (std::size_t i = 1; i < d.size(); ++i) {
    const double m = below[i] / d[i - 1];
    d[i] -= m * above[i - 1];
    right[i] -= m * right[i - 1];
  }
  for (std::size_t i = d.size(); i-- > 0;)
    right[i] = (right[i] - (i + 1 < d.size() ? above[i] * right[i + 1] : 0.0)) / d[i];
  return right;
}

/// Second derivatives of the spline through the knots.
std::vector<double> open_moments(const std::vector<ProfileSample>& knots, double slope_begin, double slope_end) {
  const std::size_t n = knots.size();
  std::vector<double> below(n, 0.0), d(n, 0.0), above(n, 0.0), right(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const double h0 = i > 0 ? knots[i].s - knots[i - 1].s : 0.0, h1 = i + 1 < n ? knots[i + 1].s - knots[i].s : 0.0;
    const double in = i > 0 ? (knots[i].value - knots[i - 1].value) / h0 : slope_begin;
    const double out = i + 1 < n ? (knots[i + 1].value - knots[i].value) / h1 : slope_end;
    below[i] = h0 / 6.0, d[i] = (h0 + h1) / 3.0, above[i] = h1 / 6.0, right[i] = out - in;
  }
  return solve_tridiagonal(below, std::move(d), above, std::move(right));
}

/// The same around a closed profile, whose last knot is its first: Sherman and Morrison's formula for the two corners.
std::vector<double> closed_moments(const std::vector<ProfileSample>& knots) {
  const std::size_t n = knots.size() - 1;
  std::vector<double> below(n), d(n), above(n), right(n), corner(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : n - 1;
    const double h0 = knots[before + 1].s - knots[before].s, h1 = knots[i + 1].s - knots[i].s;
    below[i] = h0 / 6.0, d[i] = (h0 + h1) / 3.0, above[i] = h1 / 6.0;
    right[i] = (knots[i + 1].value - knots[i].value) / h1 - (knots[before + 1].value - knots[before].value) / h0;
  }
  const double edge = below[0], gamma = -d[0];
  d[0] -= gamma;
  d[n - 1] -= edge * edge / gamma;
  corner[0] = gamma, corner[n - 1] = edge;
  const std::vector<double> y = solve_tridiagonal(below, d, above, right),
                            q = solve_tridiagonal(below, d, above, corner);
  const double share = (y[0] + edge / gamma * y[n - 1]) / (1.0 + q[0] + edge / gamma * q[n - 1]);
  std::vector<double> moments(n);
  for (std::size_t i = 0; i < n; ++i) moments[i] = y[i] - share * q[i];
  moments.push_back(moments.front());
  return moments;
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
    for (const std::size_t i : at) knots.push_back(samples[i]);
    const std::vector<double> moments = closed ? closed_moments(knots) : open_moments(knots, slope_begin, slope_end);
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

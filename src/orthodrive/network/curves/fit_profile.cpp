// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/curves/fit_profile.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace orthodrive::network {
namespace {

using roadquery::Cubic;

constexpr double stencil_m = 5.0;  // slopes look this far to both sides: two node spacings, against node noise

/// The same polynomial written from another start.
Cubic moved_to(const Cubic& cubic, double s) {
  const double ds = s - cubic.s;
  return {s, value_at(cubic, s), slope_at(cubic, s), cubic.c + 3.0 * cubic.d * ds, cubic.d};
}

const Cubic* cubic_at(std::span<const Cubic> cubics, double s) {
  if (cubics.empty()) return nullptr;
  const auto after =
      std::upper_bound(cubics.begin(), cubics.end(), s, [](double v, const Cubic& c) { return v < c.s; });
  return &*(after == cubics.begin() ? after : after - 1);
}

/// Slope at b of the parabola through three samples.
double parabola_slope(ProfileSample a, ProfileSample b, ProfileSample c) {
  const double h1 = b.s - a.s, h2 = c.s - b.s, m1 = (b.value - a.value) / h1, m2 = (c.value - b.value) / h2;
  return (m1 * h2 + m2 * h1) / (h1 + h2);
}

std::vector<double> slopes(const std::vector<ProfileSample>& samples, bool closed) {
  const std::size_t n = samples.size();
  const double period = samples.back().s - samples.front().s;
  // Index i of the samples repeated without end; only closed profiles are asked beyond their ends.
  const auto sample = [&](std::ptrdiff_t i) {
    const auto turns = static_cast<std::ptrdiff_t>(n) - 1;
    std::ptrdiff_t wrapped = i % turns;
    if (wrapped < 0) wrapped += turns;
    const std::ptrdiff_t turned = (i - wrapped) / turns;
    ProfileSample result =
        samples[static_cast<std::size_t>(i >= 0 && i < static_cast<std::ptrdiff_t>(n) ? i : wrapped)];
    if (i < 0 || i >= static_cast<std::ptrdiff_t>(n)) result.s += period * static_cast<double>(turned);
    return result;
  };
  const auto last = static_cast<std::ptrdiff_t>(n) - 1;
  std::vector<double> result(n, 0.0);
  for (std::ptrdiff_t i = 0; i <= last; ++i) {
    const ProfileSample b = sample(i);
    std::ptrdiff_t before = i, after = i;
    while ((closed ? i - before < last : before > 0) && b.s - sample(before).s < stencil_m) --before;
    while ((closed ? after - i < last : after < last) && sample(after).s - b.s < stencil_m) ++after;
    double& slope = result[static_cast<std::size_t>(i)];
    if (before != i && after != i) {
      slope = parabola_slope(sample(before), b, sample(after));
    } else if (before != i || after != i) {
      const ProfileSample c = sample(before != i ? before : after);
      slope = (c.value - b.value) / (c.s - b.s);
    }
  }
  return result;
}

}  // namespace

double value_at(const Cubic& cubic, double s) {
  const double ds = s - cubic.s;
  return cubic.a + ds * (cubic.b + ds * (cubic.c + ds * cubic.d));
}

double slope_at(const Cubic& cubic, double s) {
  const double ds = s - cubic.s;
  return cubic.b + ds * (2.0 * cubic.c + ds * 3.0 * cubic.d);
}

double value_at(std::span<const Cubic> cubics, double s) {
  const Cubic* cubic = cubic_at(cubics, s);
  return cubic ? value_at(*cubic, s) : 0.0;
}

double slope_at(std::span<const Cubic> cubics, double s) {
  const Cubic* cubic = cubic_at(cubics, s);
  return cubic ? slope_at(*cubic, s) : 0.0;
}

std::vector<ProfileSample> without_repeats(std::span<const ProfileSample> samples) {
  constexpr double min_step_m = 0.01;
  std::vector<ProfileSample> kept{samples.front()};
  for (const ProfileSample& sample : samples.subspan(1))
    if (sample.s - kept.back().s >= min_step_m) kept.push_back(sample);
  // The end counts more than the one before it.
  if (kept.size() > 1 && kept.back().s < samples.back().s) kept.back() = samples.back();
  return kept;
}

Cubic hermite(double s0, double s1, double v0, double v1, double slope0, double slope1) {
  const double l = s1 - s0, mean = (v1 - v0) / l;
  return {s0, v0, slope0, (3.0 * mean - 2.0 * slope0 - slope1) / l, (slope0 + slope1 - 2.0 * mean) / (l * l)};
}

void add_cubic(std::vector<Cubic>& cubics, const Cubic& more, double end) {
  constexpr double same_joint_m = 1e-6;
  const auto from_later = [](const Cubic& c, double s) {
    return Cubic{s, value_at(c, s), slope_at(c, s), c.c + 3.0 * c.d * (s - c.s), c.d};
  };
  if (cubics.empty()) cubics.push_back({});
  for (const double s : {more.s, end}) {
    const auto after = std::ranges::upper_bound(cubics, s + same_joint_m, {}, &Cubic::s);
    if (after != cubics.begin() && s - (after - 1)->s >= same_joint_m)
      cubics.insert(after, from_later(*(after - 1), s));
  }
  for (Cubic& c : cubics) {
    if (c.s < more.s - same_joint_m || c.s >= end - same_joint_m) continue;
    const Cubic here = from_later(more, c.s);
    c.a += here.a, c.b += here.b, c.c += here.c, c.d += here.d;
  }
}

ProfileFit fit_profile(std::span<const ProfileSample> all, const FitProfileOptions& options) {
  assert(!all.empty());
  const std::vector<ProfileSample> samples = without_repeats(all);
  const std::size_t n = samples.size();
  ProfileFit fit;
  if (n == 1) {
    fit.cubics.push_back({samples[0].s, samples[0].value, 0.0, 0.0, 0.0});
    return fit;
  }
  std::vector<double> slope = slopes(samples, options.closed);
  if (options.level_ends) slope.front() = slope.back() = 0.0;
  const auto piece = [&](std::size_t i, std::size_t j) {
    return hermite(samples[i].s, samples[j].s, samples[i].value, samples[j].value, slope[i], slope[j]);
  };
  const auto error = [&](std::size_t i, std::size_t j) {
    const Cubic cubic = piece(i, j);
    double worst = 0.0;
    for (std::size_t k = i + 1; k < j; ++k)
      worst = std::max(worst, std::abs(value_at(cubic, samples[k].s) - samples[k].value));
    return worst;
  };
  for (std::size_t i = 0; i + 1 < n;) {
    std::size_t good = i + 1, step = 1;
    while (good + step < n && error(i, good + step) <= options.tolerance) good += step, step *= 2;
    for (; step > 0; step /= 2)
      if (good + step < n && error(i, good + step) <= options.tolerance) good += step;
    fit.max_error = std::max(fit.max_error, error(i, good));
    fit.cubics.push_back(piece(i, good));
    i = good;
  }
  return fit;
}

std::vector<Cubic> slice_profile(std::span<const Cubic> cubics, double s0, double s1) {
  constexpr double sliver_m = 1e-6;  // shorter pieces are left to their neighbour
  std::vector<Cubic> result;
  for (std::size_t i = 0; i < cubics.size(); ++i) {
    const bool first = result.empty();
    if (i + 1 < cubics.size() && cubics[i + 1].s <= s0 + sliver_m) continue;
    if (!first && cubics[i].s >= s1 - sliver_m) break;
    Cubic part = first ? moved_to(cubics[i], s0) : cubics[i];
    part.s -= s0;
    result.push_back(part);
  }
  return result;
}

std::vector<Cubic> simplify_profile(std::span<const Cubic> cubics, double length, double tolerance) {
  constexpr int samples = 8;  // of each piece
  const std::size_t n = cubics.size();
  const auto end_of = [&](std::size_t i) { return i + 1 < n ? cubics[i + 1].s : length; };
  // One cubic for pieces i to j, from the value and slope of the first to those of the last.
  const auto joined = [&](std::size_t i, std::size_t j) {
    const double end = end_of(j);
    return hermite(cubics[i].s, end, cubics[i].a, value_at(cubics[j], end), cubics[i].b, slope_at(cubics[j], end));
  };
  const auto fits = [&](std::size_t i, std::size_t j) {
    const Cubic cubic = joined(i, j);
    for (std::size_t k = i; k <= j; ++k)
      for (int m = 1; m <= samples; ++m) {
        const double s = cubics[k].s + (end_of(k) - cubics[k].s) * m / samples;
        if (std::abs(value_at(cubic, s) - value_at(cubics[k], s)) > tolerance) return false;
      }
    return true;
  };
  std::vector<Cubic> result;
  for (std::size_t i = 0; i < n;) {
    std::size_t last = i;
    while (last + 1 < n && fits(i, last + 1)) ++last;
    result.push_back(last == i ? cubics[i] : joined(i, last));
    i = last + 1;
  }
  return result;
}

std::vector<Cubic> reverse_profile(std::span<const Cubic> cubics, double length, double sign) {
  std::vector<Cubic> result;
  for (std::size_t i = cubics.size(); i-- > 0;) {
    const double end = i + 1 < cubics.size() ? cubics[i + 1].s : length;
    const Cubic from_end = moved_to(cubics[i], end);
    result.push_back({length - end, sign * from_end.a, -sign * from_end.b, sign * from_end.c, -sign * from_end.d});
  }
  return result;
}

}  // namespace orthodrive::network

#include "orthodrive/synth/spline.hpp"

#include <algorithm>
#include <cstddef>

namespace orthodrive::synth {
namespace {
/// Second derivatives of the natural cubic spline (Thomas algorithm).
std::vector<double> natural_spline(const std::vector<double>& s, const std::vector<double>& z) {
  const std::size_t n = s.size();
  std::vector<double> second(n, 0.0), upper(n, 0.0), value(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = s[i] - s[i - 1], h1 = s[i + 1] - s[i];
    const double rhs = 6.0 * ((z[i + 1] - z[i]) / h1 - (z[i] - z[i - 1]) / h0);
    const double pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / pivot, value[i] = (rhs - h0 * value[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) second[i] = value[i] - upper[i] * second[i + 1];
  return second;
}

std::size_t interval(const std::vector<double>& knots, double s) {
  const auto it = std::upper_bound(knots.begin(), knots.end(), s);
  return std::min(static_cast<std::size_t>(std::max<long>(0, it - knots.begin() - 1)), knots.size() - 2);
}
}  // namespace

Spline make_spline(std::vector<double> s, std::vector<double> z, bool closed) {
  if (!closed) {
    std::vector<double> second = natural_spline(s, z);
    return {std::move(s), std::move(z), std::move(second)};
  }
  // Periodic by repetition: the influence of the ends fades by 0.27 a knot.
  const std::size_t wrap = std::min<std::size_t>(40, s.size() - 1), n = s.size();
  const double length = s.back();
  std::vector<double> s_long, z_long;
  for (std::size_t i = n - 1 - wrap; i + 1 < n; ++i) s_long.push_back(s[i] - length), z_long.push_back(z[i]);
  s_long.insert(s_long.end(), s.begin(), s.end());
  z_long.insert(z_long.end(), z.begin(), z.end());
  for (std::size_t i = 1; i <= wrap; ++i) s_long.push_back(s[i] + length), z_long.push_back(z[i]);
  const std::vector<double> second = natural_spline(s_long, z_long);
  return {std::move(s),
          std::move(z),
          {second.begin() + static_cast<long>(wrap), second.begin() + static_cast<long>(wrap + n)}};
}

double Spline::at(double s) const {
  const std::size_t i = interval(knots, s);
  const double h = knots[i + 1] - knots[i], a = (knots[i + 1] - s) / h, b = 1.0 - a;
  return a * values[i] + b * values[i + 1] +
         ((a * a * a - a) * second[i] + (b * b * b - b) * second[i + 1]) * h * h / 6.0;
}

double Spline::slope(double s) const {
  const std::size_t i = interval(knots, s);
  const double h = knots[i + 1] - knots[i], a = (knots[i + 1] - s) / h, b = 1.0 - a;
  return (values[i + 1] - values[i]) / h +
         ((3.0 * b * b - 1.0) * second[i + 1] - (3.0 * a * a - 1.0) * second[i]) * h / 6.0;
}

double Spline::bend(double s) const {
  const std::size_t i = interval(knots, s);
  const double h = knots[i + 1] - knots[i], b = (s - knots[i]) / h;
  return (1.0 - b) * second[i] + b * second[i + 1];
}

}  // namespace orthodrive::synth

#include "orthodrive/network/crown_shape.hpp"

#include <algorithm>
#include <cmath>

#include "roadquery/road_surface.hpp"

namespace orthodrive::network {
namespace {

constexpr double reach_m = 30.0;          // to the right; wider than any road. The left half has no end
constexpr double fall_tolerance = 1e-4;   // 0.4 mm at the edge of two lanes
constexpr double max_rate_jump = 2.5e-4;  // 1/m: 0.1 % of gradient, 4 m off the reference line
constexpr double min_knot_distance_m = 0.01;

/// Knots of a piece from its start to, but without, its end.
void add_knots(const roadquery::Cubic& cubic, double end, std::vector<double>& knots) {
  const double length = end - cubic.s;
  const double bend = std::max(std::abs(2.0 * cubic.c), std::abs(2.0 * cubic.c + 6.0 * cubic.d * length));
  const double step = bend > 0.0 ? std::min(std::sqrt(8.0 * fall_tolerance / bend), max_rate_jump / bend) : length;
  const int count = std::max(1, static_cast<int>(std::ceil(length / step - 1e-9)));
  for (int k = 0; k < count; ++k) knots.push_back(cubic.s + length * k / count);
}

}  // namespace

std::vector<roadquery::ShapeCubic> crown_shape(std::span<const roadquery::Cubic> fall, double length_m) {
  std::vector<double> knots;
  for (std::size_t i = 0; i < fall.size(); ++i) {
    const double end = i + 1 < fall.size() ? fall[i + 1].s : length_m;
    if (end > fall[i].s) add_knots(fall[i], std::min(end, length_m), knots);
  }
  knots.push_back(length_m);
  std::vector<roadquery::ShapeCubic> shape;
  double before_last = 0.0, last = 0.0, last_s = -1.0;
  bool any = false;
  const auto add = [&](double s, double value) {
    shape.push_back({s, -reach_m, -reach_m * value, value, 0.0, 0.0});
    shape.push_back({s, 0.0, 0.0, -value, 0.0, 0.0});
  };
  for (const double s : knots) {
    if (s - last_s < min_knot_distance_m && !shape.empty()) continue;
    const double value = roadquery::evaluate(fall, s);
    // Of knots with the same fall only the first and the last are needed; the last is not before others follow.
    if (shape.size() >= 4 && value == last && last == before_last) shape.resize(shape.size() - 2);
    add(s, value);
    any = any || value != 0.0;
    before_last = last, last = value, last_s = s;
  }
  if (!any) return {};
  if (shape.size() == 4 && before_last == last) shape.resize(2);
  return shape;
}

}  // namespace orthodrive::network

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/baselines/label_strips.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace orthodrive::baselines {

LabelCosts label_costs(const ClassTable& classes, double unlabelled_cost) {
  LabelCosts costs;
  costs.outside.fill(0.0F);
  costs.inside.fill(static_cast<float>(unlabelled_cost));
  for (std::size_t i = 0; i < std::min<std::size_t>(classes.classes.size(), label_nodata); ++i) {
    const ClassInfo& info = classes.classes[i];
    costs.outside[i] = static_cast<float>(info.cost_false_positive);
    costs.inside[i] = info.role == Role::vegetation ? 1.0F : static_cast<float>(info.cost_false_negative);
  }
  return costs;
}

namespace {
/// The distance weight as a linear function of a pixel's centre: |value|, at most 1.
struct DistanceWeight {
  double at_origin = 0.0, per_col = 0.0, per_row = 0.0;
};

DistanceWeight distance_weight(Vec2 a, Vec2 b, double width_px) {
  const Vec2 along = normalized(b - a);
  return {cross(along, Vec2{} - a) / width_px, -along.y / width_px, along.x / width_px};
}
}  // namespace

void add_strip(const LabelMap& labels, const std::array<float, 256>& costs, const LabelStrip& strip, StripSum& sum) {
  const GridFrame& frame = labels.frame;
  const std::array<Vec2, 4> corners{frame.pixel_from_world(strip.border_a), frame.pixel_from_world(strip.border_b),
                                    frame.pixel_from_world(strip.far_b), frame.pixel_from_world(strip.far_a)};
  const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y, corners[3].y});
  // Clamped as doubles: far away from the labels an int would overflow. Rows are half open, as in geo/polygon.
  const auto first_after = [](double x) { return static_cast<int>(std::clamp(std::ceil(x - 0.5), -1e9, 1e9)); };
  const int first_row = first_after(low), end_row = first_after(high);
  const DistanceWeight weight = distance_weight(corners[0], corners[1], strip.width_m / frame.gsd_m);

  double cost_sum = 0.0, weight_sum = 0.0;
  for (int row = first_row; row < end_row; ++row) {
    const double y = row + 0.5;
    std::array<double, 4> crossings;
    crossings.fill(std::numeric_limits<double>::infinity());  // what is not set is sorted behind
    std::size_t count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 a = corners[i], b = corners[(i + 1) % 4];
      if ((a.y <= y) != (b.y <= y)) crossings[count++] = a.x + (y - a.y) * (b.x - a.x) / (b.y - a.y);
    }
    std::ranges::sort(crossings);
    const bool is_row = row >= 0 && row < frame.height;
    const std::uint8_t* const line = is_row ? &labels.labels.data[labels.labels.index(0, row)] : nullptr;
    const double at_row = weight.at_origin + weight.per_row * y;
    for (std::size_t i = 0; i + 1 < count; i += 2) {
      const int end_col = first_after(crossings[i + 1]);
      for (int col = first_after(crossings[i]); col < end_col; ++col) {
        const std::uint8_t label = line && col >= 0 && col < frame.width ? line[col] : label_nodata;
        const double d = std::min(1.0, std::abs(at_row + weight.per_col * (col + 0.5)));
        weight_sum += d;
        cost_sum += d * costs[label];
        sum.labelled |= label != label_nodata;
      }
    }
  }
  sum.cost += cost_sum;
  sum.weight += weight_sum;
}

}  // namespace orthodrive::baselines

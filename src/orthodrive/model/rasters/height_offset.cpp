// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/height_offset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "orthodrive/core/median.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"

namespace orthodrive {
namespace {

constexpr std::size_t least_places = 50;

struct TwoHeights {
  Vec2 p;
  double a_m = 0.0, b_m = 0.0;
};
using HeightDifferences = std::vector<TwoHeights>;

void add_known(HeightDifferences& differences, const TwoHeights& two) {
  if (!std::isnan(two.a_m) && !std::isnan(two.b_m)) differences.push_back(two);
}

Box2 common_part(const Box2& a, const Box2& b) {
  return {std::max(a.min_x, b.min_x), std::max(a.min_y, b.min_y), std::min(a.max_x, b.max_x),
          std::min(a.max_y, b.max_y)};
}

HeightDifferences where_both_are(const HeightGrid& a, const HeightGrid& b, const Box2& box) {
  constexpr int places = 60;  // along each side
  HeightDifferences differences;
  const Box2 common = common_part(box, common_part(a.frame.bounds(), b.frame.bounds()));
  if (common.width() <= 0.0 || common.height() <= 0.0) return differences;
  for (int i = 0; i < places; ++i)
    for (int j = 0; j < places; ++j) {
      const Vec2 p{common.min_x + common.width() * (i + 0.5) / places,
                   common.min_y + common.height() * (j + 0.5) / places};
      add_known(differences, {p, sample_bilinear(a, p), sample_bilinear(b, p)});
    }
  return differences;
}

/// Where `a` ends: a continued along its slope by a pixel of the coarser model, and b there. The slope of the ground
/// must not look like a step.
HeightDifferences beyond_border(const HeightGrid& a, const HeightGrid& b, const Box2& box) {
  HeightDifferences differences;
  const double step_m = std::max(a.frame.gsd_m, b.frame.gsd_m);
  constexpr std::array<std::array<int, 2>, 4> sides{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};  // column, row
  for (int row = 0; row < a.frame.height; ++row)
    for (int col = 0; col < a.frame.width; ++col) {
      const auto z = static_cast<double>(a.height_m.at(col, row));
      if (std::isnan(z)) continue;
      for (const auto [right, down] : sides) {
        const bool goes_on =
            a.height_m.inside(col + right, row + down) && !std::isnan(a.height_m.at(col + right, row + down));
        if (goes_on) continue;
        const Vec2 here = a.frame.center_of(col, row), out = Vec2{1.0 * right, -1.0 * down} * step_m;
        if (!box.contains(here + out)) continue;
        add_known(differences, {here, 2.0 * z - sample_bilinear(a, here - out), sample_bilinear(b, here + out)});
      }
    }
  return differences;
}

double quantile(std::vector<double>& values, double q) {
  return at_rank(values, static_cast<std::size_t>(q * static_cast<double>(values.size() - 1)));
}

/// By the ratio where both are well over the sea. In lowlands by the relief: what is left after conversion must be much
/// less than what is left without.
bool is_in_feet(const HeightDifferences& differences, bool first) {
  constexpr double foot_m = 0.3048, least_height_m = 20.0, tolerance = 0.02, largest_spread = 0.05;
  constexpr double least_relief_m = 0.2, largest_rest_m = 0.3;
  std::vector<double> ratios, steps, rests;  // the last in feet
  for (const TwoHeights& two : differences) {
    const double feet = first ? two.a_m : two.b_m, metres = first ? two.b_m : two.a_m;
    if (feet > least_height_m && metres > least_height_m) ratios.push_back(feet / metres);
    steps.push_back(feet - metres);
    rests.push_back(feet - metres / foot_m);
  }
  const auto spread = [](std::vector<double>& values) { return quantile(values, 0.75) - quantile(values, 0.25); };
  if (ratios.size() >= least_places) {
    const double ratio = quantile(ratios, 0.5);
    return std::abs(ratio * foot_m - 1.0) < tolerance && spread(ratios) < largest_spread * ratio;
  }
  return spread(steps) > least_relief_m && spread(rests) < 0.5 * spread(steps) &&
         std::abs(quantile(rests, 0.5)) < largest_rest_m + 0.1 * spread(steps);
}

HeightOffset offset_of(const HeightDifferences& differences) {
  HeightOffset offset;
  std::vector<double> steps_m;
  for (const TwoHeights& two : differences) {
    offset.middle = offset.middle + two.p;
    steps_m.push_back(two.a_m - two.b_m);
  }
  offset.middle = offset.middle * (1.0 / static_cast<double>(differences.size()));
  offset.low_m = quantile(steps_m, 0.25), offset.median_m = quantile(steps_m, 0.5);
  offset.high_m = quantile(steps_m, 0.75);
  offset.first_in_feet = is_in_feet(differences, true);
  offset.second_in_feet = !offset.first_in_feet && is_in_feet(differences, false);
  return offset;
}

}  // namespace

double HeightOffset::sigma_m() const { return (high_m - low_m) / 1.349; }

std::optional<HeightOffset> height_offset(const HeightGrid& a, const HeightGrid& b, const Box2& box) {
  if (a.height_m.empty() || b.height_m.empty()) return std::nullopt;
  const HeightDifferences common = where_both_are(a, b, box);
  if (common.size() >= least_places) return offset_of(common);
  HeightDifferences at_border = beyond_border(a, b, box);
  for (const TwoHeights& two : beyond_border(b, a, box)) at_border.push_back({two.p, two.b_m, two.a_m});
  if (at_border.size() < least_places) return std::nullopt;
  HeightOffset offset = offset_of(at_border);
  offset.along_border = true;
  return offset;
}

}  // namespace orthodrive

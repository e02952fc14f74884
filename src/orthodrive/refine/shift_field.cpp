// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/shift_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive::refine {
namespace {

constexpr double reach_sigmas = 2.5;  // a sample further away counts for nothing
constexpr int reweightings = 6;

/// The symmetric system of a weighted fit of a vector s to n . s = offset.
struct Normal {
  double xx = 0.0, xy = 0.0, yy = 0.0, bx = 0.0, by = 0.0;
  void add(const ShiftSample& sample, double weight) {
    const Vec2 n = sample.normal;
    xx += weight * n.x * n.x, xy += weight * n.x * n.y, yy += weight * n.y * n.y;
    bx += weight * n.x * sample.offset_m, by += weight * n.y * sample.offset_m;
  }
  [[nodiscard]] Shift solve() const {
    const double determinant = xx * yy - xy * xy;
    return {{(yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant},
            yy / determinant,
            -xy / determinant,
            xx / determinant};
  }
};

struct Weighted {
  const ShiftSample* sample = nullptr;
  double weight = 0.0;
};

Shift fit_shift(const std::vector<Weighted>& near, const ShiftFieldOptions& options) {
  Shift shift;
  double scale_m = 4.0 * options.outlier_m;  // from coarse to fine: the first guess is none
  for (int round = 0; round < reweightings; ++round, scale_m = std::max(options.outlier_m, 0.6 * scale_m)) {
    Normal normal{.xx = 1.0 / (options.prior_m * options.prior_m), .yy = 1.0 / (options.prior_m * options.prior_m)};
    for (const auto [sample, weight] : near) {
      const double r = (sample->offset_m - dot(sample->normal, shift.shift_m)) / scale_m;
      normal.add(*sample, weight / (1.0 + r * r));
    }
    shift = normal.solve();
  }
  return shift;
}

}  // namespace

std::vector<Shift> shift_at(const std::vector<Vec2>& places, const std::vector<ShiftSample>& samples, int threads,
                            const ShiftFieldOptions& options) {
  // Sums run square by square, within a square in the order given: another order would change the last digits.
  const double square_m = reach_sigmas * options.reach_m;
  const auto square_of = [&](const ShiftSample* sample) {
    return std::pair(std::floor(sample->p.y / square_m), std::floor(sample->p.x / square_m));
  };
  std::vector<const ShiftSample*> sorted;
  sorted.reserve(samples.size());
  for (const ShiftSample& sample : samples) sorted.push_back(&sample);
  std::ranges::stable_sort(sorted, {}, square_of);
  std::vector<Box2> boxes;
  boxes.reserve(sorted.size());
  for (const ShiftSample* sample : sorted) boxes.push_back({sample->p.x, sample->p.y, sample->p.x, sample->p.y});
  const SpatialIndex index(boxes);
  std::vector<Shift> shifts(places.size());
  parallel_for(places.size(), threads, [&](std::size_t i) {
    std::vector<Weighted> near;
    for (const std::uint32_t k : index.near(places[i], reach_sigmas * options.reach_m)) {
      const ShiftSample* sample = sorted[k];
      if (const double d = distance(sample->p, places[i]) / options.reach_m; d <= reach_sigmas)
        near.push_back({sample, sample->weight * std::exp(-0.5 * d * d) / (sample_sigma_m * sample_sigma_m)});
    }
    shifts[i] = fit_shift(near, options);
  });
  return shifts;
}

}  // namespace orthodrive::refine

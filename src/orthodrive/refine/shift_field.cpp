#include "orthodrive/refine/shift_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "orthodrive/core/parallel.hpp"

namespace orthodrive {
namespace {

constexpr double reach_sigmas = 2.5;  // a sample further away counts for nothing
constexpr int reweightings = 6;

using Cell = std::pair<std::int64_t, std::int64_t>;

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
  const double cell_m = reach_sigmas * options.reach_m;
  const auto cell_of = [&](Vec2 p) {
    return Cell{static_cast<std::int64_t>(std::floor(p.x / cell_m)),
                static_cast<std::int64_t>(std::floor(p.y / cell_m))};
  };
  std::map<Cell, std::vector<const ShiftSample*>> cells;
  for (const ShiftSample& sample : samples) cells[cell_of(sample.p)].push_back(&sample);
  std::vector<Shift> shifts(places.size());
  parallel_for(places.size(), threads, [&](std::size_t i) {
    const auto [col, row] = cell_of(places[i]);
    std::vector<Weighted> near;
    for (std::int64_t y = row - 1; y <= row + 1; ++y)
      for (std::int64_t x = col - 1; x <= col + 1; ++x)
        if (const auto found = cells.find({x, y}); found != cells.end())
          for (const ShiftSample* sample : found->second)
            if (const double d = distance(sample->p, places[i]) / options.reach_m; d <= reach_sigmas)
              near.push_back({sample, sample->weight * std::exp(-0.5 * d * d) /
                                          (options.sample_sigma_m * options.sample_sigma_m)});
    shifts[i] = fit_shift(near, options);
  });
  return shifts;
}

}  // namespace orthodrive

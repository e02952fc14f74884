// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/ground/height_field.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/math/cholesky.hpp"

namespace orthodrive::synth {
namespace {
constexpr double grid_m = 10.0, reach_m = 250.0;
// Web height services answer from coarse cells: the heights of the Red Bull Ring are level for 250 m, then jump by up
// to 29 m within 13 m. Whole metres (0.29 m) are the least of it.
constexpr double noise_m = 6.0;

double covariance(double square_m2, double variance) {
  return variance * std::exp(-0.5 * square_m2 / (reach_m * reach_m));
}

std::vector<double> solve(std::vector<double> matrix, std::vector<double> right) {
  const SymmetricMatrix a = SymmetricMatrix::dense(matrix.data(), right.size(), right.size());
  if (!factorize(a)) throw Error("height field: the covariance is not positive definite");
  solve_factored(a, right);
  return right;
}
}  // namespace

HeightField fit_heights(const std::vector<Vec3>& points, const Box2& box) {
  assert(!points.empty());
  const std::size_t n = points.size();
  Vec3 mean;
  for (const Vec3& p : points) mean = mean + p * (1.0 / static_cast<double>(n));
  // Plane by least squares; a millionth of a square metre keeps it level where all points lie on one line.
  std::vector<double> normal(4, 0.0), right(2, 0.0);
  for (const Vec3& q : points) {
    const Vec3 d = q - mean;
    normal[0] += d.x * d.x, normal[1] += d.x * d.y, normal[3] += d.y * d.y;
    right[0] += d.x * d.z, right[1] += d.y * d.z;
  }
  normal[2] = normal[1], normal[0] += 1e-6, normal[3] += 1e-6;
  const std::vector<double> slope = solve(normal, right);
  const auto plane = [&](double x, double y) { return mean.z + slope[0] * (x - mean.x) + slope[1] * (y - mean.y); };

  std::vector<double> residual, kernel(n * n);
  double variance = 0.0;
  for (const Vec3& p : points) residual.push_back(p.z - plane(p.x, p.y));
  for (const double r : residual) variance += r * r / static_cast<double>(n);
  variance = std::max(variance, noise_m * noise_m);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) {
      const double dx = points[i].x - points[j].x, dy = points[i].y - points[j].y;
      kernel[i * n + j] = covariance(dx * dx + dy * dy, variance) + (i == j ? noise_m * noise_m : 0.0);
    }
  const std::vector<double> weight = solve(std::move(kernel), residual);

  HeightField field;
  field.frame = covering_grid(box.grown(3.0 * grid_m), grid_m);  // bicubic looks two cells away
  for (int row = 0; row < field.frame.height; ++row)
    for (int col = 0; col < field.frame.width; ++col) {
      const Vec2 p = field.frame.center_of(col, row);
      double z = plane(p.x, p.y);
      for (std::size_t i = 0; i < n; ++i) {
        const double dx = p.x - points[i].x, dy = p.y - points[i].y;
        z += weight[i] * covariance(dx * dx + dy * dy, variance);
      }
      field.height_m.push_back(z);
    }
  return field;
}

double HeightField::at(Vec2 p) const {
  const Vec2 q = frame.pixel_from_world(p) - Vec2{0.5, 0.5};
  const int col = std::clamp(static_cast<int>(std::floor(q.x)), 1, frame.width - 3),
            row = std::clamp(static_cast<int>(std::floor(q.y)), 1, frame.height - 3);
  const auto factors = [](double t) {
    return std::array{0.5 * t * (t * (2.0 - t) - 1.0), 0.5 * (t * t * (3.0 * t - 5.0) + 2.0),
                      0.5 * t * (t * (4.0 - 3.0 * t) + 1.0), 0.5 * t * t * (t - 1.0)};
  };
  const auto u = factors(q.x - col), v = factors(q.y - row);
  double z = 0.0;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      z += u[static_cast<std::size_t>(i)] * v[static_cast<std::size_t>(j)] *
           height_m[static_cast<std::size_t>(row + j - 1) * static_cast<std::size_t>(frame.width) +
                    static_cast<std::size_t>(col + i - 1)];
  return z;
}

}  // namespace orthodrive::synth

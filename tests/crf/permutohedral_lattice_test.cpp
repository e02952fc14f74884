// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/crf/permutohedral_lattice.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "crf/scalar_crf.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

template <int D>
PermutohedralLattice<D> make_lattice(const Features<D>& points) {
  typename PermutohedralLattice<D>::Range range;
  range.low.fill(std::numeric_limits<double>::max());
  range.high.fill(std::numeric_limits<double>::lowest());
  for (const auto& p : points)
    for (int f = 0; f < D; ++f) {
      range.low[f] = std::min(range.low[f], p[f]);
      range.high[f] = std::max(range.high[f], p[f]);
    }
  return PermutohedralLattice<D>(points.size(), range, [&](std::size_t first, std::size_t count, double* features) {
    for (std::size_t i = 0; i < count; ++i)
      for (int f = 0; f < D; ++f)
        features[static_cast<std::size_t>(f) * PermutohedralLattice<D>::block + i] = points[first + i][f];
  });
}

template <int D>
Features<D> random_points(std::size_t count, double extent, std::uint64_t seed) {
  Random random(seed);
  Features<D> points(count);
  for (auto& p : points)
    for (double& x : p) x = random.uniform(-extent, extent);
  return points;
}

std::vector<float> random_values(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.uniform());
  return values;
}

template <int D>
void expect_equal_to_scalar_lattice(const Features<D>& points) {
  const PermutohedralLattice<D> lattice = make_lattice<D>(points);
  const ScalarLattice<D> scalar(points);
  ASSERT_EQ(lattice.vertices(), scalar.vertices());
  const std::vector<float> values = random_values(points.size(), 7);
  for (const bool transposed : {false, true}) {
    const auto fast = lattice.filter(values, transposed ? BlurOrder::transposed : BlurOrder::forward);
    const auto slow = scalar.filter({values.begin(), values.end()}, transposed);
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_NEAR(fast[i], slow[i], 2e-6 * (1.0 + slow[i])) << i;
  }
}

TEST(PermutohedralLattice, equals_a_scalar_lattice) {
  expect_equal_to_scalar_lattice<2>(random_points<2>(700, 5.0, 1));
  expect_equal_to_scalar_lattice<5>(random_points<5>(700, 1.5, 2));  // most vertices have neighbours
  expect_equal_to_scalar_lattice<5>(random_points<5>(500, 8.0, 3));  // hardly any
}

// Coordinates with equal rests: which of them ranks higher decides which vertices exist.
TEST(PermutohedralLattice, ties_at_the_origin_and_on_the_axes) {
  expect_equal_to_scalar_lattice<2>({{0, 0}, {0, 1}, {1, 0}, {0, -3}, {0, 0}});
  expect_equal_to_scalar_lattice<5>({{0, 0, 0, 0, 0}, {0, 2, 0, 0, 0}, {0, 0, 0, 0, 1}, {3, 0, 0, 0, 0}});
}

TEST(PermutohedralLattice, one_point_and_none) {
  expect_equal_to_scalar_lattice<5>({{0.3, -0.2, 0.1, 4.0, 5.0}});
  EXPECT_TRUE(PermutohedralLattice<5>(0, {}, {}).filter({}).empty());
}

TEST(PermutohedralLattice, transposed_is_the_exact_transpose_where_vertices_are_missing) {
  const auto points = random_points<5>(400, 3.0, 4);
  const auto lattice = make_lattice<5>(points);
  const auto a = random_values(points.size(), 5), b = random_values(points.size(), 6);
  const auto dot = [](const std::vector<float>& x, const std::vector<float>& y) {
    return std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
  };
  const double forward = dot(a, lattice.filter(b)), transposed = dot(lattice.filter(a, BlurOrder::transposed), b);
  EXPECT_NEAR(forward, transposed, 1e-6 * forward);
  EXPECT_GT(std::abs(forward - dot(lattice.filter(a), b)), 1e-4 * forward);  // else the test shows nothing
}

TEST(PermutohedralLattice, weights_are_barycentric) {
  const auto lattice = make_lattice<5>(random_points<5>(1000, 20.0, 8));
  for (const auto& point : lattice.points()) {
    double sum = 0.0;
    for (const float weight : point.weight) {
      EXPECT_GE(weight, -1e-6F);
      sum += static_cast<double>(weight);
    }
    EXPECT_NEAR(sum, 1.0, 1e-6);
  }
}

// What the lattice stands for. On a grid all vertices exist; the splat and slice widen the kernel a little.
TEST(PermutohedralLattice, is_about_a_gaussian) {
  Features<2> points;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) points.push_back({x / 3.0, y / 3.0});
  const auto lattice = make_lattice<2>(points);
  std::vector<float> impulse(points.size());
  const std::size_t centre = 20 * 40 + 20;
  impulse[centre] = 1.0F;
  const auto response = lattice.filter(impulse);
  double sum = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double dx = points[i][0] - points[centre][0], dy = points[i][1] - points[centre][1];
    sum += static_cast<double>(response[i]);
    variance += static_cast<double>(response[i]) * 0.5 * (dx * dx + dy * dy);
  }
  EXPECT_NEAR(variance / sum, 1.0, 0.12);
}

TEST(PermutohedralLattice, refuses_more_cells_than_keys) {
  const Features<5> points{{0, 0, 0, 0, 0}, {1e5, 1e5, 1e5, 1e5, 1e5}};
  EXPECT_THROW((void)make_lattice<5>(points), OptionError);
  EXPECT_THROW((void)make_lattice<2>({{0, 0}, {std::numeric_limits<double>::infinity(), 0}}), OptionError);
}

}  // namespace
}  // namespace orthodrive

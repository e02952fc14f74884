// SPDX-License-Identifier: Apache-2.0
// The published heights (thesis table 3.6) on a lap as theirs: hills of the Red Bull Ring's steepness, a 10 m grid with
// one gross error, nodes 2 m apart (sec. 3.3.3). The size of the error follows from what table 3.6 says of the
// averages.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "orthodrive/baselines/reference_heights.hpp"
#include "orthodrive/model/rasters/sample_height.hpp"

namespace orthodrive {
namespace {

constexpr double lap_m = 4320.0, spacing_m = 2.0, gsd_m = 10.0;
constexpr double road_y_m = 38.0;  // not on the centres of pixels

double hill_m(double x) { return 700.0 + 7.8 * std::sin(2.0 * std::numbers::pi * x / 720.0); }

/// 5.5 m too low within 12 m of the middle of the lap where `with_error`.
HeightGrid terrain(bool with_error) {
  HeightGrid grid{.frame = {.west_m = -50.0, .north_m = 80.0, .gsd_m = gsd_m, .width = 442, .height = 8},
                  .height_m = Raster<float>(442, 8)};
  for (int row = 0; row < 8; ++row)
    for (int col = 0; col < 442; ++col) {
      const Vec2 p = grid.frame.center_of(col, row);
      const bool wrong = with_error && distance(p, {0.5 * lap_m, road_y_m}) < 12.0;
      grid.height_m.at(col, row) = static_cast<float>(hill_m(p.x) - (wrong ? 5.5 : 0.0));
    }
  return grid;
}

struct DentTest : testing::TestWithParam<HeightSampling> {
  DentTest() {
    roads.paths.emplace_back();
    for (int i = 0; i * spacing_m <= lap_m; ++i) {
      const Vec2 p{i * spacing_m, road_y_m};
      roads.paths[0].nodes.push_back({.p = p});
      given.push_back(sample_height(with_error, p, GetParam()));
      corrected.push_back(sample_height(without, p, GetParam()));
    }
  }
  [[nodiscard]] std::vector<double> average(int window) const { return moving_average(roads, {given}, window)[0]; }
  [[nodiscard]] std::vector<double> nlo(double loss_m = ReferenceHeightsOptions{}.loss_m) const {
    return reference_heights(roads, {given}, {.loss_m = loss_m}).z_m[0];
  }
  static double error_energy(const std::vector<double>& a, const std::vector<double>& b) {  // eq. 3.12
    double sum = 0.0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += (a[n] - b[n]) * (a[n] - b[n]);
    return sum / static_cast<double>(a.size());
  }
  static double gradient_energy(const std::vector<double>& z) {  // eq. 3.13, 1e-4
    double sum = 0.0;
    for (std::size_t n = 1; n < z.size(); ++n) sum += std::pow((z[n] - z[n - 1]) / spacing_m, 2);
    return 1e4 * sum / static_cast<double>(z.size() - 1);
  }

  HeightGrid with_error = terrain(true), without = terrain(false);
  RoadNetwork roads;
  std::vector<double> given, corrected;
};
INSTANTIATE_TEST_SUITE_P(Samplings, DentTest, testing::Values(HeightSampling::bilinear, HeightSampling::cubic));

void expect_within(double ours, double published, double factor, const char* what) {
  EXPECT_LE(ours, factor * published) << what;
  EXPECT_GE(ours, published / factor) << what;
}

TEST_P(DentTest, the_error_is_as_that_of_the_published_terrain) {
  const bool cubic = GetParam() == HeightSampling::cubic;
  expect_within(error_energy(given, corrected), cubic ? 0.136 : 0.120, 1.25, "as sampled");
  expect_within(gradient_energy(given), cubic ? 39.54 : 36.21, 1.25, "E_RG as sampled");
  const struct {
    int window;
    double gradient, given, corrected;
  } published[2][3] = {{{11, 28.37, 0.009, 0.088}, {35, 23.77, 0.089, 0.047}, {67, 23.32, 0.203, 0.109}},
                       {{11, 29.64, 0.012, 0.096}, {35, 23.80, 0.112, 0.051}, {67, 23.29, 0.229, 0.113}}};
  for (const auto& row : published[cubic ? 1 : 0]) {
    const std::vector<double> z = average(row.window);
    expect_within(gradient_energy(z), row.gradient, 1.25, "E_RG of an average");
    expect_within(error_energy(z, given), row.given, 1.4, "an average against the terrain");
    expect_within(error_energy(z, corrected), row.corrected, 1.4, "an average against the corrected terrain");
  }
}

TEST_P(DentTest, heights_of_the_reference_are_within_a_factor_of_two_of_the_published_ones) {
  const bool cubic = GetParam() == HeightSampling::cubic;
  const std::vector<double> z = nlo();
  expect_within(gradient_energy(z), cubic ? 22.81 : 22.45, 2.0, "E_RG");
  expect_within(error_energy(z, given), cubic ? 0.093 : 0.121, 2.0, "E_h to the terrain");
  EXPECT_LE(error_energy(z, corrected), 2.0 * (cubic ? 0.028 : 0.001)) << "E_h to the corrected terrain";
}

TEST_P(DentTest, heights_hang_on_what_the_loss_is_of_and_not_on_its_size) {
  for (const double loss_m : {0.25, 1.0}) EXPECT_LT(error_energy(nlo(loss_m), corrected), 0.004) << loss_m;
  const double of_residual_m = 0.5 / 0.2;  // the other reading of "a normalization value of 0.5"
  EXPECT_GT(error_energy(nlo(of_residual_m), corrected), 15 * 0.001);
}

}  // namespace
}  // namespace orthodrive

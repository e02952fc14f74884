// SPDX-License-Identifier: Apache-2.0
// The kernels of banking: pixels of a terrain model across a road, and the fit along one chain.

#include "orthodrive/elevate/banking/fit_banking.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/random.hpp"
#include "test_roads.hpp"

namespace orthodrive::elevate {
namespace {

/// A road of 200 m to the east along y = 100, 6 m wide, at z = 50.
RoadNetwork flat_road() {
  RoadNetwork roads{test::road_crs, {test::straight_road(1, {0, 100}, {200, 100})}};
  for (RoadNode& node : roads.paths[0].nodes) node.z_m = 50.0;
  return roads;
}

TEST(TerrainAcross, takes_the_pixels_of_the_carriageway_with_their_offset) {
  const NetworkStations network = make_stations(flat_road());
  const HeightGrid dtm = test::terrain_grid([](double, double y) { return 50.0 + 0.03 * (y - 100.0); }, 1.0);
  const auto samples = gather_across_samples(network, std::vector{dtm}, 2.0);
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_NEAR(static_cast<double>(samples[0].size()), 200.0 * 6.0, 40.0) << "one a square metre";
  for (const AcrossSample& sample : samples[0]) {
    EXPECT_LE(std::abs(sample.t_m), 3.0);
    EXPECT_NEAR(sample.rise_m, 0.03 * sample.t_m, 1e-4) << "positive to the left";
  }
  EXPECT_TRUE(gather_across_samples(network, std::vector{dtm}, 0.5)[0].empty()) << "coarser than asked for";
}

TEST(TerrainAcross, leaves_out_other_roads_and_structures) {
  RoadNetwork roads = flat_road();
  roads.paths.push_back(test::straight_road(2, {100, 20}, {100, 180}));
  for (RoadNode& node : roads.paths[1].nodes) node.z_m = 50.0;
  const HeightGrid dtm = test::terrain_grid([](double, double) { return 50.0; }, 1.0);
  const NetworkStations network = make_stations(roads);
  const auto samples = gather_across_samples(network, std::vector{dtm}, 2.0);
  EXPECT_FALSE(samples[0].empty());
  for (const AcrossSample& sample : samples[0]) {
    const double x = network.chains[0].stations[sample.station].p.x;
    EXPECT_GT(std::abs(x - 100.0), 2.5) << "on the carriageway of the road that crosses";
  }
  roads = flat_road();
  roads.paths[0].bridge = true;
  EXPECT_TRUE(gather_across_samples(make_stations(roads), std::vector{dtm}, 2.0)[0].empty());
}

struct Chain {
  NetworkStations network = make_stations(flat_road());
  [[nodiscard]] const StationChain& chain() const { return network.chains[0]; }
  [[nodiscard]] DesignBanking design(double crown) const {
    const std::size_t n = chain().stations.size();
    return {std::vector<double>(n, 0.0), std::vector<double>(n, crown)};
  }
  /// Pixels of 1 m over the whole carriageway with 3 cm of noise, `first_m` to `last_m` along it.
  [[nodiscard]] std::vector<AcrossSample> samples(const std::function<double(double s, double t)>& rise,
                                                  double first_m = 0.0, double last_m = 200.0) const {
    Random random(4);
    std::vector<AcrossSample> samples;
    for (std::uint32_t i = 0; i < chain().stations.size(); ++i) {
      const double s = chain().stations[i].s_m;
      for (double t = -2.5; t < 3.0 && s >= first_m && s <= last_m; t += 1.0)
        samples.push_back({i, static_cast<float>(t), static_cast<float>(rise(s, t) + 0.03 * random.normal()), 1.0F});
    }
    return samples;
  }
};

TEST(FitBanking, measures_a_slope_and_no_crown_on_a_plane) {
  const Chain c;
  const BankingFit fit =
      fit_banking(c.chain(), c.samples([](double, double t) { return 0.04 * t; }), c.design(0.025), {}, {});
  for (std::size_t i = 10; i + 10 < fit.slope.size(); ++i) {
    EXPECT_NEAR(fit.slope[i], 0.04, 0.006);
    EXPECT_EQ(fit.crown[i], 0.0) << "a plane, not a roof";
    EXPECT_EQ(fit.source[i], BankingSource::dtm);
    EXPECT_LT(fit.sigma_slope[i], 0.01);
  }
}

TEST(FitBanking, measures_a_crown_on_a_roof) {
  const Chain c;
  const BankingFit fit =
      fit_banking(c.chain(), c.samples([](double, double t) { return -0.03 * std::abs(t); }), c.design(0.0), {}, {});
  for (std::size_t i = 10; i + 10 < fit.slope.size(); ++i) {
    EXPECT_NEAR(fit.crown[i], 0.03, 0.01);
    EXPECT_NEAR(fit.slope[i], 0.0, 0.006);
  }
}

TEST(FitBanking, single_pixels_on_a_wall_count_for_little) {
  const Chain c;
  auto samples = c.samples([](double, double t) { return 0.02 * t; });
  for (std::size_t k = 0; k < samples.size(); k += 12) samples[k].rise_m += 2.0F;
  const BankingFit fit = fit_banking(c.chain(), samples, c.design(0.025), {}, {});
  for (std::size_t i = 10; i + 10 < fit.slope.size(); ++i) EXPECT_NEAR(fit.slope[i], 0.02, 0.01);
}

TEST(FitBanking, without_pixels_it_is_the_design) {
  const Chain c;
  const BankingFit fit = fit_banking(c.chain(), {}, c.design(0.025), {}, {});
  for (std::size_t i = 0; i < fit.slope.size(); ++i) {
    EXPECT_NEAR(fit.slope[i], 0.0, 1e-4);
    EXPECT_NEAR(fit.crown[i], 0.025, 1e-3);
    EXPECT_EQ(fit.source[i], BankingSource::design);
    EXPECT_GE(fit.sigma_slope[i], 0.02);
  }
}

TEST(FitBanking, gaps_are_interpolated_and_what_lies_far_beyond_follows_the_design) {
  const Chain c;
  auto samples = c.samples([](double, double t) { return 0.04 * t; }, 0.0, 40.0);
  for (const AcrossSample& sample : c.samples([](double, double t) { return 0.04 * t; }, 100.0, 120.0))
    samples.push_back(sample);
  const BankingFit fit = fit_banking(c.chain(), samples, c.design(0.0), {}, {});
  EXPECT_EQ(fit.source[35], BankingSource::interpolated);  // 70 m: between
  EXPECT_NEAR(fit.slope[35], 0.04, 0.01);
  EXPECT_EQ(fit.source[95], BankingSource::design);  // 190 m: 70 m beyond
  EXPECT_NEAR(fit.slope[95], 0.0, 0.01);
}

TEST(FitBanking, lies_in_the_plane_of_its_anchor) {
  const Chain c;
  const BankingFit fit = fit_banking(c.chain(), {}, c.design(0.025), {{.station = 0, .slope = 0.05}}, {});
  EXPECT_NEAR(fit.slope[0], 0.05, 2e-3);
  EXPECT_NEAR(fit.crown[0], 0.0, 4e-3);
  EXPECT_NEAR(fit.slope[50], 0.0, 2e-3) << "run out long before";
}

}  // namespace
}  // namespace orthodrive::elevate

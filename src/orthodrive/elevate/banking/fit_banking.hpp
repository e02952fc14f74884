// SPDX-License-Identifier: Apache-2.0
#pragma once
// Banking along one chain from terrain pixels across it: one banded least-squares problem.

#include <vector>

#include "orthodrive/elevate/banking/design_banking.hpp"
#include "orthodrive/elevate/banking/estimate_banking.hpp"
#include "orthodrive/elevate/terrain/terrain_across.hpp"

namespace orthodrive::elevate {

/// At this station the surface is that of a higher ranked road, the plane that the roads of a junction have in
/// common, or one surface with a road beside it.
struct BankingAnchor {
  std::size_t station = 0;
  double slope = 0.0;
  bool is_main = false;  ///< the most important road of the junction, or a road beside another one: it keeps its
                         ///< crown, and turns no faster there
};

/// A road turns into the plane of a junction over this length: 5 % at the relative gradient of 0.65 % for 50 km/h, over
/// half a street of 5 - 6 m.
inline constexpr double banking_runout_m = 20.0;

struct BankingFit {
  std::vector<double> slope, crown, sigma_slope;  ///< [station]; tangents; slope positive = left side higher
  std::vector<BankingSource> source;
};

[[nodiscard]] BankingFit fit_banking(const StationChain& chain, const std::vector<AcrossSample>& samples,
                                     const DesignBanking& design, const std::vector<BankingAnchor>& anchors,
                                     const BankingOptions& options);

}  // namespace orthodrive::elevate

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Searches weights of the road refinement by cross-validation: what was tuned on some sites is judged on others.
//
// A search is a seeded random walk that only goes downhill ((1+1) evolution strategy with a fixed step; Rechenberg,
// Evolutionsstrategie, 1973): weights act by their ratios, so a trial multiplies a few of them by exp(N(0, step)) and
// is taken when the loss falls. Losses of roads have steps (which way the first guess goes), so there is no gradient to
// use.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/core/monitor.hpp"
#include "orthodrive/refine/refine_roads.hpp"

namespace orthodrive {

/// Loss of a site with these weights, in metres. Called from several threads; must depend on its arguments only. NaN is
/// never taken.
using WeightLoss = std::function<double(const RefineWeights& weights, std::size_t site)>;

struct SearchWeightsOptions {
  RefineWeights start;       ///< the shipped ones
  int trials = 60;           ///< of each search
  double step = 0.5;         ///< sigma of the logarithm of a factor
  double share = 1.0 / 3.0;  ///< of the weights that a trial changes
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
};

/// Mean loss of a set of sites, before and after tuning.
struct SetLoss {
  std::vector<std::size_t> sites;
  double start_m = 0.0, tuned_m = 0.0;
  [[nodiscard]] double gain_m() const { return start_m - tuned_m; }
};
struct TunedWeights {
  std::string held_out_fold;  ///< empty: none, tuned on all sites
  RefineWeights weights;      ///< three significant digits where they differ from the start
  int accepted = 0;           ///< of the trials
  SetLoss training, held_out;
};
struct WeightSearch {
  std::vector<TunedWeights> folds;  ///< by the name of the fold
  TunedWeights all;                 ///< what one would ship
  std::size_t evaluations = 0;      ///< refinements of one site

  /// Means over the folds. Over-fitting is what the gain loses on sites that were not used.
  [[nodiscard]] double training_gain_m() const;
  [[nodiscard]] double held_out_gain_m() const;
  [[nodiscard]] double overfitting_m() const { return training_gain_m() - held_out_gain_m(); }
};

/// `fold_of_site` names the fold of each site; sites of one fold are held out together. Throws OptionError for fewer
/// than two folds and when a site has no loss to start with. All searches draw the same random numbers and share what
/// they have evaluated, so folds that have taken the same trials cost nothing more.
[[nodiscard]] WeightSearch search_weights(std::span<const std::string> fold_of_site, const WeightLoss& loss,
                                          const SearchWeightsOptions& options = {}, Monitor* monitor = nullptr);

}  // namespace orthodrive

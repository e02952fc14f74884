// SPDX-License-Identifier: Apache-2.0
#pragma once
// Weights of the default road refinement, searched by cross-validation on sites with truth, and what came of it.

#include <string>
#include <vector>

#include "orthodrive/lab/tuning/tune_sites.hpp"
#include "orthodrive/pipeline/score/score_json.hpp"
#include "orthodrive/refine/search_weights.hpp"

namespace orthodrive {

struct TunedSite {
  std::string name, fold;
  RoadLoss osm, start, tuned;  ///< not refined; with the weights to start from; with those tuned on all sites
};
struct TuneResult {
  WeightSearch search;
  std::vector<TunedSite> sites;
  SearchWeightsOptions options;
};
[[nodiscard]] TuneResult tune_refine(const TuneSites& sites, const SearchWeightsOptions& options = {},
                                     Monitor* monitor = nullptr);

/// False when tuning gains nothing where it has not looked: then the weights to start from should stay.
[[nodiscard]] bool tuning_helps(const TuneResult& result);
/// A sentence: what tuning gains on its own sites and on held-out ones; a second one when it does not help.
[[nodiscard]] std::string verdict(const TuneResult& result);
/// Metres and per cent to four decimals; null where there is no number.
[[nodiscard]] ScoreJson to_json(const TuneResult& result);
[[nodiscard]] std::string to_table(const TuneResult& result);
/// The weights tuned on all sites, as read_refine_weights reads them, with the verdict above.
[[nodiscard]] std::string to_weights_file(const TuneResult& result);

}  // namespace orthodrive

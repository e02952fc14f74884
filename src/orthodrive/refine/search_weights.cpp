// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/search_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/refine/weight_table.hpp"

namespace orthodrive {
namespace {

using Values = std::vector<double>;  // in the order of the weight table

Values values_of(const RefineWeights& weights) {
  Values values;
  for (const NamedWeight& weight : refine_weight_table()) values.push_back(weights.*weight.value);
  return values;
}

RefineWeights weights_of(const Values& values) {
  RefineWeights weights;
  for (std::size_t i = 0; i < values.size(); ++i) weights.*refine_weight_table()[i].value = values[i];
  return weights;
}

/// Three digits: the file of the weights says exactly what was tried.
double rounded(double value) {
  const std::string text = fmt::format("{:.3g}", value);
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// Losses that are known already.
class LossCache {
 public:
  LossCache(const WeightLoss& loss, int threads) : loss_(loss), threads_(threads) {}

  using Wish = std::pair<Values, std::size_t>;  ///< weights, site
  /// Evaluates what is not known yet, in parallel.
  void evaluate(const std::set<Wish>& wishes) {
    std::vector<Wish> unknown;
    for (const Wish& wish : wishes)
      if (!known_.contains(wish)) unknown.push_back(wish);
    std::vector<double> losses(unknown.size());
    parallel_for(unknown.size(), threads_,
                 [&](std::size_t i) { losses[i] = loss_(weights_of(unknown[i].first), unknown[i].second); });
    for (std::size_t i = 0; i < unknown.size(); ++i) known_.emplace(std::move(unknown[i]), losses[i]);
  }
  [[nodiscard]] double mean(const Values& values, const std::vector<std::size_t>& sites) const {
    double sum = 0.0;
    for (const std::size_t site : sites) sum += known_.at({values, site});
    return sum / static_cast<double>(sites.size());
  }
  [[nodiscard]] std::size_t size() const { return known_.size(); }

 private:
  const WeightLoss& loss_;
  int threads_;
  std::map<Wish, double> known_;
};

/// One search, a trial at a time: propose, have the loss of its training sites evaluated, decide.
class Walk {
 public:
  Walk(std::string held_out_fold, std::span<const std::string> fold_of_site, const SearchWeightsOptions& options)
      : options_(options), random_(options.seed), start_(values_of(options.start)), best_(start_), proposal_(start_) {
    result_.held_out_fold = std::move(held_out_fold);
    for (std::size_t site = 0; site < fold_of_site.size(); ++site)
      (fold_of_site[site] == result_.held_out_fold ? result_.held_out : result_.training).sites.push_back(site);
  }

  /// Draws the same numbers whatever was taken before.
  void propose() {
    const std::uint64_t always = random_.below(best_.size());  // else some trials would change nothing
    for (std::size_t i = 0; i < best_.size(); ++i) {
      const bool changed = random_.uniform() < options_.share || i == always;
      const double factor = std::exp(options_.step * random_.normal());
      proposal_[i] = changed ? rounded(best_[i] * factor) : best_[i];
    }
  }
  void wish_proposal(std::set<LossCache::Wish>& wishes) const { wish(proposal_, result_.training, wishes); }
  void decide(const LossCache& losses) {
    if (!(losses.mean(proposal_, result_.training.sites) < losses.mean(best_, result_.training.sites))) return;
    best_ = proposal_;
    ++result_.accepted;
  }

  /// The held-out sites are looked at when all is decided.
  void wish_held_out(std::set<LossCache::Wish>& wishes) const {
    wish(start_, result_.held_out, wishes);
    wish(best_, result_.held_out, wishes);
  }
  [[nodiscard]] TunedWeights result(const LossCache& losses) const {
    TunedWeights result = result_;
    result.weights = weights_of(best_);
    for (SetLoss* set : {&result.training, &result.held_out}) {
      if (set->sites.empty()) continue;
      set->start_m = losses.mean(start_, set->sites);
      set->tuned_m = losses.mean(best_, set->sites);
    }
    return result;
  }

 private:
  static void wish(const Values& values, const SetLoss& set, std::set<LossCache::Wish>& wishes) {
    for (const std::size_t site : set.sites) wishes.emplace(values, site);
  }

  const SearchWeightsOptions& options_;
  Random random_;
  TunedWeights result_;
  Values start_, best_, proposal_;
};

void check_folds(const std::set<std::string>& folds, const SearchWeightsOptions& options) {
  if (folds.contains("")) throw OptionError("tune: a fold has no name");
  if (folds.size() < 2) throw OptionError("tune: need sites of at least two folds, one to tune on and one to hold out");
  if (options.trials < 0 || !(options.step > 0.0) || !(options.share >= 0.0 && options.share <= 1.0))
    throw OptionError("tune: need trials >= 0, a step above 0 and a share of 0 to 1");
}

double mean_over_folds(const std::vector<TunedWeights>& folds, SetLoss TunedWeights::*set) {
  double sum = 0.0;
  for (const TunedWeights& fold : folds) sum += (fold.*set).gain_m();
  return sum / static_cast<double>(folds.size());
}

}  // namespace

double WeightSearch::training_gain_m() const { return mean_over_folds(folds, &TunedWeights::training); }
double WeightSearch::held_out_gain_m() const { return mean_over_folds(folds, &TunedWeights::held_out); }

WeightSearch search_weights(std::span<const std::string> fold_of_site, const WeightLoss& loss,
                            const SearchWeightsOptions& options, Monitor* monitor) {
  const std::set<std::string> folds(fold_of_site.begin(), fold_of_site.end());
  check_folds(folds, options);
  std::vector<Walk> walks;
  walks.reserve(folds.size());
  for (const std::string& fold : folds) walks.emplace_back(fold, fold_of_site, options);
  walks.emplace_back("", fold_of_site, options);  // no fold has this name: all sites

  LossCache losses(loss, options.threads);
  const auto evaluate = [&](const auto& add_wishes) {
    std::set<LossCache::Wish> wishes;
    for (const Walk& walk : walks) add_wishes(walk, wishes);
    losses.evaluate(wishes);
  };
  evaluate([](const Walk& walk, auto& wishes) { walk.wish_proposal(wishes); });  // still the start
  for (std::size_t site = 0; site < fold_of_site.size(); ++site)
    if (std::isnan(losses.mean(values_of(options.start), {site})))
      throw OptionError(fmt::format("tune: site {} has no loss with the weights to start from", site + 1));

  for (int trial = 0; trial < options.trials; ++trial) {
    if (monitor && monitor->cancelled()) throw Error("tune: cancelled");
    if (monitor) monitor->progress(static_cast<double>(trial) / options.trials, "tune");
    for (Walk& walk : walks) walk.propose();
    evaluate([](const Walk& walk, auto& wishes) { walk.wish_proposal(wishes); });
    for (Walk& walk : walks) walk.decide(losses);
  }
  evaluate([](const Walk& walk, auto& wishes) { walk.wish_held_out(wishes); });

  WeightSearch search;
  for (const Walk& walk : walks) search.folds.push_back(walk.result(losses));
  search.all = std::move(search.folds.back());
  search.folds.pop_back();
  search.evaluations = losses.size();
  return search;
}

}  // namespace orthodrive

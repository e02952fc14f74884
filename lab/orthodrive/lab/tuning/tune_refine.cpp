// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/lab/tuning/tune_refine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/pipeline/files/refine_files.hpp"
#include "orthodrive/refine/weight_table.hpp"

namespace orthodrive {

TuneResult tune_refine(const TuneSites& sites, const SearchWeightsOptions& options, Monitor* monitor) {
  const auto loss_of = [&](const RefineWeights& weights, std::size_t s) {
    const TuneSite& site = sites.sites[s];
    // One thread each: sites and trials run side by side.
    return road_loss(refine_roads(site.osm, sites.evidence[site.evidence], {.weights = weights, .threads = 1}).roads,
                     site);
  };
  std::vector<std::string> folds;
  folds.reserve(sites.sites.size());
  for (const TuneSite& site : sites.sites) folds.push_back(site.fold);
  TuneResult result{.options = options};
  result.search = search_weights(
      folds, [&](const RefineWeights& weights, std::size_t s) { return loss_of(weights, s).loss_m; }, options, monitor);
  result.sites.resize(sites.sites.size());
  parallel_for(sites.sites.size(), options.threads, [&](std::size_t s) {
    const TuneSite& site = sites.sites[s];
    result.sites[s] = {site.name, site.fold, road_loss(site.osm, site), loss_of(options.start, s),
                       loss_of(result.search.all.weights, s)};
  });
  return result;
}

bool tuning_helps(const TuneResult& result) { return result.search.held_out_gain_m() > 0.0; }

namespace {

/// Per cent of `of`; NaN where that is nothing.
double percent(double part, double of) {
  return of > 0.0 ? 100.0 * part / of : std::numeric_limits<double>::quiet_NaN();
}
/// Of the gain on what was tuned on, so much is not there on held-out sites.
double overfitting_percent(const WeightSearch& search) {
  return percent(search.overfitting_m(), search.training_gain_m());
}

ScoreJson number(double value) {
  if (!std::isfinite(value)) return nullptr;
  const double stepped = std::round(value * 1e4) / 1e4;
  return stepped == 0.0 ? 0.0 : stepped;  // no -0
}

ScoreJson to_json(const RefineWeights& weights) {
  ScoreJson json = ScoreJson::object();
  for (const NamedWeight& weight : refine_weight_table()) json[std::string(weight.name)] = weights.*weight.value;
  return json;
}
ScoreJson to_json(const RoadLoss& loss) {
  return {{"loss_m", number(loss.loss_m)},
          {"offset_m", number(loss.offset_m)},
          {"width_m", number(loss.width_m)},
          {"surface_iou", number(loss.surface_iou)},
          {"unmatched_share", number(loss.unmatched_share)}};
}
ScoreJson to_json(const SetLoss& set, const std::vector<TunedSite>& sites) {
  ScoreJson names = ScoreJson::array();
  for (const std::size_t site : set.sites) names.push_back(sites[site].name);
  return {{"sites", names},
          {"start_m", number(set.start_m)},
          {"tuned_m", number(set.tuned_m)},
          {"gain_m", number(set.gain_m())},
          {"gain_percent", number(percent(set.gain_m(), set.start_m))}};
}
}  // namespace

ScoreJson to_json(const TuneResult& result) {
  const WeightSearch& search = result.search;
  ScoreJson folds = ScoreJson::array(), sites = ScoreJson::array();
  for (const TunedWeights& fold : search.folds)
    folds.push_back({{"held_out_fold", fold.held_out_fold},
                     {"accepted", fold.accepted},
                     {"training", to_json(fold.training, result.sites)},
                     {"held_out", to_json(fold.held_out, result.sites)},
                     {"weights", to_json(fold.weights)}});
  for (const TunedSite& site : result.sites)
    sites.push_back({{"name", site.name},
                     {"fold", site.fold},
                     {"osm", to_json(site.osm)},
                     {"start", to_json(site.start)},
                     {"tuned", to_json(site.tuned)}});
  return {{"verdict", verdict(result)},
          {"tuning_helps", tuning_helps(result)},
          {"training_gain_m", number(search.training_gain_m())},
          {"held_out_gain_m", number(search.held_out_gain_m())},
          {"overfitting_m", number(search.overfitting_m())},
          {"overfitting_percent", number(overfitting_percent(search))},
          {"trials", result.options.trials},
          {"seed", result.options.seed},
          {"evaluations", search.evaluations},
          {"folds", folds},
          {"all", {{"accepted", search.all.accepted}, {"training", to_json(search.all.training, result.sites)}}},
          {"start_weights", to_json(result.options.start)},
          {"weights", to_json(search.all.weights)},
          {"sites", sites}};
}

std::string verdict(const TuneResult& result) {
  const WeightSearch& search = result.search;
  std::string text =
      fmt::format("Tuned weights gain {:.3f} m on what they were tuned on and {:.3f} m on held-out sites",
                  search.training_gain_m(), search.held_out_gain_m());
  if (search.training_gain_m() > 0.0)
    text += fmt::format(": over-fitting {:.3f} m, {:.0f} % of the gain", search.overfitting_m(),
                        overfitting_percent(search));
  text += '.';
  if (!tuning_helps(result))
    text += " Warning: on held-out sites nothing is gained, so the shipped weights should stay.";
  return text;
}

namespace {

std::string row_of(const std::string& held_out, const char* set, const SetLoss& loss) {
  return fmt::format("{:<24}{:<10}{:>6}{:>9.3f}{:>9.3f}{:>9.3f}{:>8.1f}\n", held_out, set, loss.sites.size(),
                     loss.start_m, loss.tuned_m, loss.gain_m(), percent(loss.gain_m(), loss.start_m));
}
std::string row_of(const std::string& site, const char* roads, const RoadLoss& loss) {
  return fmt::format("{:<24}{:<10}{:>9.3f}{:>9.3f}{:>9.3f}{:>9.3f}{:>8.1f}\n", site, roads, loss.loss_m, loss.offset_m,
                     loss.width_m, loss.surface_iou, 100.0 * loss.unmatched_share);
}
}  // namespace

std::string to_table(const TuneResult& result) {
  std::string table = fmt::format("{:<24}{:<10}{:>6}{:>9}{:>9}{:>9}{:>8}\n", "fold held out", "loss of", "sites",
                                  "start m", "tuned m", "gain m", "gain %");
  for (const TunedWeights& fold : result.search.folds) {
    table += row_of(fold.held_out_fold, "training", fold.training);
    table += row_of("", "held out", fold.held_out);
  }
  table += row_of("(none)", "all", result.search.all.training);

  table += fmt::format("\n{:<24}{:<10}{:>9}{:>9}{:>9}{:>9}{:>8}\n", "site", "roads", "loss m", "offset m", "width m",
                       "IoU", "none %");
  for (const TunedSite& site : result.sites) {
    table += row_of(site.name, "osm", site.osm);
    table += row_of("", "start", site.start);
    table += row_of("", "tuned", site.tuned);
  }

  table += fmt::format("\n{:<24}{:>10}{:>10}", "weight", "start", "tuned");
  for (const TunedWeights& fold : result.search.folds) table += fmt::format("  without {}", fold.held_out_fold);
  table += '\n';
  for (const NamedWeight& weight : refine_weight_table()) {
    table += fmt::format("{:<24}{:>10.3g}{:>10.3g}", weight.name, result.options.start.*weight.value,
                         result.search.all.weights.*weight.value);
    for (const TunedWeights& fold : result.search.folds)
      table += fmt::format("{:>{}.3g}", fold.weights.*weight.value, fold.held_out_fold.size() + 10);
    table += '\n';
  }
  return table + "\n" + verdict(result) + "\n";
}

std::string to_weights_file(const TuneResult& result) {
  return fmt::format("# Weights of `orthodrive refine`, tuned on {} sites ({} trials, seed {}).\n# {}\n",
                     result.sites.size(), result.options.trials, result.options.seed, verdict(result)) +
         refine_weights_toml(result.search.all.weights);
}

}  // namespace orthodrive

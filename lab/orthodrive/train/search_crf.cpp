// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/search_crf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "orthodrive/core/parallel.hpp"

namespace orthodrive {
namespace {

double merit(const CrfTrial& trial) { return 0.5 * (trial.pixel_accuracy + trial.mean_iou); }

/// Weights of one lattice to try together, since building it costs as much as using it.
struct Weights {
  float appearance = 0.0F, smoothness = 0.0F;
};

std::vector<CrfTrial> try_weights(std::span<const CrfSample> samples, int classes, const CrfWidths& widths,
                                  const std::vector<Weights>& weights, int iterations,
                                  const CrfSearchOptions& options) {
  std::vector<double> vertices(samples.size(), 0.0), pixels(samples.size(), 0.0);
  std::vector<std::vector<LabelScore>> scores(samples.size(),
                                              std::vector<LabelScore>(weights.size(), LabelScore(classes)));
  parallel_for(samples.size(), options.threads, [&](std::size_t s) {
    const CrfSample& sample = samples[s];
    const DenseCrf crf({.width = sample.rgb.width, .height = sample.rgb.height, .rgb = sample.rgb.data.data()}, widths);
    const auto n = static_cast<std::size_t>(classes);
    vertices[s] = static_cast<double>(crf.appearance().vertices());
    std::vector<float> marginals(sample.unary.size());
    std::vector<std::uint8_t> labels(marginals.size() / n);
    pixels[s] = static_cast<double>(labels.size());
    for (std::size_t w = 0; w < weights.size(); ++w) {
      crf.infer(potts_crf(classes, weights[w].appearance, weights[w].smoothness, iterations), sample.unary, marginals);
      for (std::size_t i = 0; i < labels.size(); ++i) {
        const float* p = &marginals[i * n];
        labels[i] = static_cast<std::uint8_t>(std::max_element(p, p + n) - p);
      }
      scores[s][w].add(labels, sample.allowed.data);
    }
  });
  std::vector<CrfTrial> trials;
  for (std::size_t w = 0; w < weights.size(); ++w) {
    LabelScore all(classes);
    for (const auto& of_sample : scores) all.add(of_sample[w]);
    trials.push_back(
        {widths, weights[w].appearance, weights[w].smoothness, iterations,
         std::accumulate(vertices.begin(), vertices.end(), 0.0) / std::accumulate(pixels.begin(), pixels.end(), 0.0),
         all.pixel_accuracy(), all.mean_iou()});
  }
  return trials;
}

/// The smallest lattice of all trials so far that keep enough of the best gain; among equals the best.
CrfTrial smallest_lattice(const std::vector<CrfTrial>& trials) {
  const CrfTrial& none = trials.front();
  const CrfTrial& top = *std::ranges::max_element(trials, {}, merit);
  if (merit(top) <= merit(none)) return none;
  const double enough = merit(top) - tolerated_loss * (merit(top) - merit(none));
  const CrfTrial* best = nullptr;
  for (const CrfTrial& trial : trials) {
    if (merit(trial) < enough) continue;
    if (best == nullptr || trial.vertices_per_pixel < best->vertices_per_pixel ||
        (trial.vertices_per_pixel == best->vertices_per_pixel && merit(trial) > merit(*best)))
      best = &trial;
  }
  return *best;
}

/// Values of the best trial at the end of what was tried of them.
std::vector<std::string> values_at_edges(const CrfTrial& best, const CrfSearchOptions& options) {
  std::vector<std::string> at_edges;
  const auto tell_edge = [&](const char* name, auto value, const auto& tried) {
    const auto [least, most] = std::ranges::minmax(tried);
    if (least != most && (value == least || value == most))
      at_edges.push_back(fmt::format("{} = {} of {} to {}", name, value, least, most));
  };
  if (best.appearance_weight > 0.0F) {
    tell_edge("theta_alpha_px", best.widths.theta_alpha_px, options.theta_alpha_px);
    tell_edge("theta_beta", best.widths.theta_beta, options.theta_beta);
    tell_edge("appearance_weight", best.appearance_weight, options.appearance_weight);
  }
  if (best.smoothness_weight > 0.0F) {
    tell_edge("theta_gamma_px", best.widths.theta_gamma_px, options.theta_gamma_px);
    tell_edge("smoothness_weight", best.smoothness_weight, options.smoothness_weight);
  }
  return at_edges;
}

}  // namespace

CrfSearch search_crf(std::span<const CrfSample> samples, int classes, const CrfSearchOptions& options) {
  CrfSearch search;
  const auto add = [&](const std::vector<CrfTrial>& trials) {
    search.trials.insert(search.trials.end(), trials.begin(), trials.end());
  };
  add(try_weights(samples, classes, {}, {{0.0F, 0.0F}}, options.iterations, options));
  std::vector<Weights> weights;
  weights.reserve(options.appearance_weight.size());
  for (const float w : options.appearance_weight) weights.push_back({w, 0.0F});
  for (const double alpha : options.theta_alpha_px)
    for (const double beta : options.theta_beta)
      add(try_weights(samples, classes, {alpha, beta, 1.0}, weights, options.iterations, options));
  const CrfTrial appearance = smallest_lattice(search.trials);
  std::vector<CrfTrial> with_smoothness{appearance};
  weights.clear();
  for (const float w : options.smoothness_weight) weights.push_back({appearance.appearance_weight, w});
  for (const double gamma : options.theta_gamma_px) {
    const CrfWidths widths{appearance.widths.theta_alpha_px, appearance.widths.theta_beta, gamma};
    const std::vector<CrfTrial> trials = try_weights(samples, classes, widths, weights, options.iterations, options);
    with_smoothness.insert(with_smoothness.end(), trials.begin(), trials.end());
    add(trials);
  }
  CrfTrial best = *std::ranges::max_element(with_smoothness, {}, merit);
  const double enough = merit(best) - tolerated_loss * (merit(best) - merit(search.trials.front()));
  for (const int iterations : options.fewer_iterations) {
    if (iterations >= best.iterations) continue;
    const Weights one{best.appearance_weight, best.smoothness_weight};
    const CrfTrial trial = try_weights(samples, classes, best.widths, {one}, iterations, options).front();
    add({trial});
    if (merit(trial) >= enough) best = trial;
  }
  search.best = {best.widths, potts_crf(classes, best.appearance_weight, best.smoothness_weight, best.iterations)};
  search.at_edges = values_at_edges(best, options);
  return search;
}

}  // namespace orthodrive

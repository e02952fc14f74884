#include "orthodrive/segment/search_crf.hpp"

#include <algorithm>

#include "orthodrive/core/parallel.hpp"

namespace orthodrive {
namespace {

double merit(const CrfTrial& trial) { return 0.5 * (trial.pixel_accuracy + trial.mean_iou); }

/// Weights of one lattice to try together, since building it costs as much as using it.
struct Weights {
  float appearance = 0.0F, smoothness = 0.0F;
};

std::vector<CrfTrial> try_weights(std::span<const CrfSample> samples, int classes, const CrfWidths& widths,
                                  const std::vector<Weights>& weights, const CrfSearchOptions& options) {
  std::vector<std::vector<LabelScore>> scores(samples.size(),
                                              std::vector<LabelScore>(weights.size(), LabelScore(classes)));
  parallel_for(samples.size(), options.threads, [&](std::size_t s) {
    const CrfSample& sample = samples[s];
    const DenseCrf crf({.width = sample.rgb.width, .height = sample.rgb.height, .rgb = sample.rgb.data.data()}, widths);
    const auto n = static_cast<std::size_t>(classes);
    std::vector<float> marginals(sample.unary.size());
    std::vector<std::uint8_t> labels(marginals.size() / n);
    for (std::size_t w = 0; w < weights.size(); ++w) {
      crf.infer(potts_crf(classes, weights[w].appearance, weights[w].smoothness, options.iterations), sample.unary,
                marginals);
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
    trials.push_back({widths, weights[w].appearance, weights[w].smoothness, all.pixel_accuracy(), all.mean_iou()});
  }
  return trials;
}

}  // namespace

CrfSearch search_crf(std::span<const CrfSample> samples, int classes, const CrfSearchOptions& options) {
  CrfSearch search;
  CrfTrial best;
  const auto keep = [&](const std::vector<CrfTrial>& trials) {
    for (const CrfTrial& trial : trials) {
      if (search.trials.empty() || merit(trial) > merit(best)) best = trial;
      search.trials.push_back(trial);
    }
  };
  keep(try_weights(samples, classes, {}, {{0.0F, 0.0F}}, options));
  std::vector<Weights> weights;
  for (const float w : options.appearance_weight) weights.push_back({w, 0.0F});
  for (const double alpha : options.theta_alpha_px)
    for (const double beta : options.theta_beta)
      keep(try_weights(samples, classes, {alpha, beta, 1.0}, weights, options));
  weights.clear();
  for (const float w : options.smoothness_weight) weights.push_back({best.appearance_weight, w});
  const CrfWidths appearance = best.widths;
  for (const double gamma : options.theta_gamma_px)
    keep(try_weights(samples, classes, {appearance.theta_alpha_px, appearance.theta_beta, gamma}, weights, options));
  search.best = {best.widths, potts_crf(classes, best.appearance_weight, best.smoothness_weight, options.iterations)};
  return search;
}

}  // namespace orthodrive

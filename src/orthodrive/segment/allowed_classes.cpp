#include "orthodrive/segment/allowed_classes.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace orthodrive {
namespace {

float weight_of(ClassSet allowed, const AllowedLossOptions& options) {
  if (allowed == unknown_class) return 0.0F;
  if (!std::has_single_bit(allowed)) return options.set_weight;
  return options.class_weights[static_cast<std::size_t>(std::countr_zero(allowed))];
}

}  // namespace

double allowed_class_loss(std::span<const float> scores, std::span<const ClassSet> allowed,
                          const AllowedLossOptions& options, std::span<float> gradient) {
  const std::size_t classes = options.class_weights.size();
  assert(classes <= 8 && scores.size() == allowed.size() * classes && gradient.size() == scores.size());
  double total_weight = 0.0, loss = 0.0;
  for (const ClassSet set : allowed) total_weight += weight_of(set, options);
  std::fill(gradient.begin(), gradient.end(), 0.0F);
  if (total_weight == 0.0) return 0.0;
  for (std::size_t i = 0; i < allowed.size(); ++i) {
    if (allowed[i] == unknown_class) continue;
    const float* s = &scores[i * classes];
    const float top = *std::max_element(s, s + classes);
    float exps[8], all = 0.0F, inside = 0.0F;
    for (std::size_t c = 0; c < classes; ++c) {
      exps[c] = std::exp(s[c] - top);
      all += exps[c];
      if (allowed[i] >> c & 1U) inside += exps[c];
    }
    // Scores so far apart that exp underflows still need a slope back to the allowed classes.
    inside = std::max(inside, 1e-30F);
    const auto weight = static_cast<float>(weight_of(allowed[i], options) / total_weight);
    loss += static_cast<double>(weight) * (std::log(all) - std::log(inside));
    for (std::size_t c = 0; c < classes; ++c) {
      const float target = allowed[i] >> c & 1U ? exps[c] / inside : 0.0F;
      gradient[i * classes + c] = weight * (exps[c] / all - target);
    }
  }
  return loss;
}

LabelScore::LabelScore(int class_count)
    : hit_(static_cast<std::size_t>(class_count)), missed_(hit_.size()), wrong_(hit_.size()) {}

void LabelScore::add(std::span<const std::uint8_t> labels, std::span<const ClassSet> allowed) {
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (allowed[i] == unknown_class || labels[i] >= hit_.size()) continue;
    const bool right = allowed[i] >> labels[i] & 1U, single = std::has_single_bit(allowed[i]);
    ++known_;
    if (right) ++right_;
    if (single && right) ++hit_[labels[i]];
    if (single && !right) ++missed_[static_cast<std::size_t>(std::countr_zero(allowed[i]))];
    if (!right) ++wrong_[labels[i]];
  }
}

double LabelScore::iou(int label) const {
  const auto c = static_cast<std::size_t>(label);
  const std::uint64_t sum = hit_[c] + missed_[c] + wrong_[c];
  const bool in_truth = hit_[c] + missed_[c] > 0;
  return in_truth ? static_cast<double>(hit_[c]) / static_cast<double>(sum) : std::numeric_limits<double>::quiet_NaN();
}

double LabelScore::mean_iou() const {
  double sum = 0.0;
  int count = 0;
  for (std::size_t c = 0; c < hit_.size(); ++c) {
    const double value = iou(static_cast<int>(c));
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / count;
}

double LabelScore::pixel_accuracy() const {
  return known_ == 0 ? std::numeric_limits<double>::quiet_NaN()
                     : static_cast<double>(right_) / static_cast<double>(known_);
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/allowed_classes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace orthodrive {
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

void LabelScore::add(const LabelScore& other) {
  for (std::size_t c = 0; c < hit_.size(); ++c) {
    hit_[c] += other.hit_[c];
    missed_[c] += other.missed_[c];
    wrong_[c] += other.wrong_[c];
  }
  known_ += other.known_;
  right_ += other.right_;
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

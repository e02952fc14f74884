// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/labels/label_comparison.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {
/// Appends to `common` what only `prediction` has; where its labels land in that list.
std::vector<std::uint16_t> match_by_name(std::vector<ClassInfo>& common, const ClassTable& prediction) {
  std::vector<std::uint16_t> indices;
  for (const ClassInfo& predicted : prediction.classes) {
    const auto at =
        std::find_if(common.begin(), common.end(), [&](const ClassInfo& c) { return c.name == predicted.name; });
    indices.push_back(static_cast<std::uint16_t>(at - common.begin()));
    if (at == common.end()) common.push_back(predicted);
  }
  return indices;
}
}  // namespace

LabelComparisonView::LabelComparisonView(const LabelMap& prediction, const LabelMap& truth,
                                         const ComparisonOptions& options)
    : prediction_(prediction), truth_(truth), region_(region_mask(truth.frame, options.region)) {
  std::vector<ClassInfo> common = truth.classes.classes;
  common_of_prediction_ = match_by_name(common, prediction.classes);
  merged_ = merge_classes(common, options.merge);
  if (prediction.crs != truth.crs) prediction_from_truth_.emplace(truth.crs, prediction.crs);
}

LabelPair LabelComparisonView::at(int col, int row) const {
  LabelPair pair;
  if (!region_.at(col, row)) return pair;
  const std::uint8_t expected = truth_.labels.at(col, row);
  pair.state = PixelState::truth_open;
  if (expected == label_nodata) return pair;
  pair.expected = merged_.from_old[expected];
  pair.state = PixelState::not_predicted;
  const Vec2 p = truth_.frame.center_of(col, row);
  const Vec2 q =
      prediction_.frame.pixel_from_world(prediction_from_truth_ ? prediction_from_truth_->target_from_source(p) : p);
  const double pcol = std::floor(q.x), prow = std::floor(q.y);
  // Compared as doubles: far beyond the grid they do not fit an int.
  if (!(pcol >= 0 && prow >= 0 && pcol < prediction_.frame.width && prow < prediction_.frame.height)) return pair;
  pair.prediction_col = static_cast<int>(pcol), pair.prediction_row = static_cast<int>(prow);
  const std::uint8_t label = prediction_.labels.at(pair.prediction_col, pair.prediction_row);
  if (label == label_nodata) return pair;
  const std::uint16_t common = common_of_prediction_[label];
  pair.predicted = merged_.from_old[common];
  pair.right_before_merge = common == expected;
  pair.state = PixelState::compared;
  return pair;
}

}  // namespace orthodrive

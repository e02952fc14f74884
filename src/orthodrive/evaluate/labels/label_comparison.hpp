// SPDX-License-Identifier: Apache-2.0
#pragma once
// Truth and prediction side by side, pixel for pixel. Scores and pictures both look through this.

#include <cstdint>
#include <optional>
#include <vector>

#include "orthodrive/evaluate/labels/merge_classes.hpp"
#include "orthodrive/evaluate/labels/scores.hpp"
#include "orthodrive/model/rasters/rasters.hpp"

namespace orthodrive {

enum class PixelState : std::uint8_t {
  outside,        ///< not in the region that is scored
  truth_open,     ///< the truth has no class here
  not_predicted,  ///< nodata, or beyond the prediction's grid
  compared,
};

/// What both say about one pixel: indices into the view's classes, set as far as the state goes.
struct LabelPair {
  PixelState state = PixelState::outside;
  std::uint16_t expected = 0, predicted = 0;
  bool right_before_merge = false;
  int prediction_col = 0, prediction_row = 0;  ///< set when compared
  [[nodiscard]] bool right() const { return expected == predicted; }
};

struct ComparisonOptions {
  ScoreRegion region;  ///< in the truth's CRS
  MergeTable merge;    ///< classes taken together after both maps are matched by name
};

/// Does not own the maps; nothing is resampled or copied but a byte a pixel for the region. The classes are the truth's
/// table, then those that only the prediction has, merged. CRSs may differ.
class LabelComparisonView {
 public:
  LabelComparisonView(const LabelMap& prediction, const LabelMap& truth, const ComparisonOptions& options = {});

  [[nodiscard]] const std::vector<ClassInfo>& classes() const { return merged_.classes; }
  [[nodiscard]] const Crs& crs() const { return truth_.crs; }
  [[nodiscard]] const GridFrame& frame() const { return truth_.frame; }  ///< of the truth
  [[nodiscard]] const LabelMap& prediction() const { return prediction_; }
  [[nodiscard]] LabelPair at(int col, int row) const;

 private:
  const LabelMap& prediction_;
  const LabelMap& truth_;
  Raster<std::uint8_t> region_;                      ///< 1 where the region counts
  std::vector<std::uint16_t> common_of_prediction_;  ///< its labels as indices into the classes before merging
  MergedClasses merged_;
  std::optional<CoordinateTransform> prediction_from_truth_;
};

}  // namespace orthodrive

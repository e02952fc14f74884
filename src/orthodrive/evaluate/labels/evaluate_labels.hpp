// SPDX-License-Identifier: Apache-2.0
#pragma once
// How well a label map agrees with the truth.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/evaluate/labels/label_comparison.hpp"

namespace orthodrive {

/// Pixel counts: rows are the truth, columns the prediction.
struct ConfusionMatrix {
  std::size_t classes = 0;
  std::vector<std::size_t> counts;
  ConfusionMatrix() = default;
  explicit ConfusionMatrix(std::size_t n) : classes(n), counts(n * n) {}
  [[nodiscard]] std::size_t& at(std::size_t truth, std::size_t predicted) {
    return counts[truth * classes + predicted];
  }
  [[nodiscard]] std::size_t at(std::size_t truth, std::size_t predicted) const {
    return counts[truth * classes + predicted];
  }
};

struct ClassScore {
  ClassInfo info;
  double iou = 0.0;        ///< thesis eq. 2.18; NaN when neither has the class, 0 when only one of them has it
  double precision = 0.0;  ///< share of its predicted pixels that are right; NaN when never predicted
  double recall = 0.0;     ///< share of its true pixels that are found; NaN when absent from the truth
  std::size_t truth_pixels = 0, predicted_pixels = 0;
};

/// Do the stated probabilities hold? Of pixels labelled with confidence 0.8, 80 % should be right. Guo et al.,
/// On Calibration of Modern Neural Networks, 2017, eq. 3.
struct CalibrationBin {
  std::size_t pixels = 0;
  double mean_confidence = 0.0, accuracy = 0.0;  ///< NaN without pixels
};
struct Calibration {
  std::array<CalibrationBin, 10> bins;  ///< of equal width; a confidence of 1 is in the last
  std::size_t pixels = 0;
  double mean_confidence = 0.0, accuracy = 0.0;  ///< of all; before any merge: the probability is that of one class
  double expected_error = 0.0;  ///< mean of |accuracy - mean confidence| of the bins, weighted by their pixels
};

struct LabelScores {
  double pixel_accuracy = 0.0;  ///< NaN when nothing was compared
  double mean_iou = 0.0;        ///< over the classes that truth or prediction has: one wrong pixel of a class that the
                                ///< truth has not puts a zero into it (thesis sec. 2.3, class 'water')
  double mean_iou_of_truth = 0.0;   ///< over the classes that the truth has
  std::vector<ClassScore> classes;  ///< of the truth's table, then those only the prediction has
  double road_iou = 0.0;            ///< of all classes with the role road together
  std::size_t pixels = 0;           ///< compared
  std::size_t truth_nodata = 0;     ///< pixels in the region that the truth leaves open
  std::size_t not_predicted =
      0;  ///< pixels with truth where there is no prediction (nodata, or beyond its grid): not compared
  ConfusionMatrix confusion;  ///< of `classes`
  std::optional<Calibration> calibration;
};

/// Parts of the truth that are scored on their own as well. `index` lies on the truth's grid: 0 is no piece, i + 1 is
/// names[i].
struct TruthPieces {
  std::vector<std::string> names;
  Raster<std::uint16_t> index;
};
struct PieceScores {
  std::string name;
  LabelScores scores;
};

struct EvaluateLabelsOptions {
  const ConfidenceMap* confidence = nullptr;  ///< on the prediction's grid: fills `calibration`
};
/// Compares at the truth's pixel centres with the label of the prediction's pixel there.
[[nodiscard]] LabelScores evaluate_labels(const LabelComparisonView& view, const EvaluateLabelsOptions& options = {});
[[nodiscard]] LabelScores evaluate_labels(const LabelMap& prediction, const LabelMap& truth,
                                          const ScoreRegion& region = {});
/// One entry a name, in their order; those without a compared pixel have `pixels` 0 and NaN scores.
[[nodiscard]] std::vector<PieceScores> evaluate_pieces(const LabelComparisonView& view, const TruthPieces& pieces);

/// The score of the road role alone, for truth that knows only roads.
struct RoadRoleScores {
  double road_iou = 0.0, precision = 0.0, recall = 0.0;  ///< NaN when nothing was compared
  std::size_t pixels = 0;
};
/// Compares at the prediction's pixel centres; outside the polygons there is no road. The region is in the prediction's
/// CRS.
[[nodiscard]] RoadRoleScores evaluate_road_role(const LabelMap& prediction, const MultiPolygon& roads,
                                                const ScoreRegion& region = {});

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/labels/evaluate_labels.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/evaluate/labels/no_value.hpp"

namespace orthodrive {
namespace {

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? no_value : static_cast<double>(part) / static_cast<double>(whole);
}

void count(LabelScores& scores, const LabelPair& pair) {
  scores.truth_nodata += pair.state == PixelState::truth_open ? 1 : 0;
  scores.not_predicted += pair.state == PixelState::not_predicted ? 1 : 0;
  if (pair.state != PixelState::compared) return;
  ++scores.confusion.at(pair.expected, pair.predicted);
  ++scores.pixels;
}

/// Pixels and right ones of each of the 256 stored confidences: all that calibration needs, in whole numbers.
struct ConfidenceCounts {
  std::array<std::size_t, 256> pixels{}, right{};
};

Calibration calibration_of(const ConfidenceCounts& counts) {
  Calibration calibration;
  std::size_t all_right = 0;
  double all_stated = 0.0, error = 0.0;
  std::array<std::size_t, 10> right{};
  std::array<double, 10> stated{};
  for (std::size_t value = 0; value < 256; ++value) {
    const std::size_t bin = std::min<std::size_t>(9, value * 10 / 255);
    calibration.bins[bin].pixels += counts.pixels[value];
    right[bin] += counts.right[value];
    stated[bin] += static_cast<double>(value) / 255.0 * static_cast<double>(counts.pixels[value]);
  }
  for (std::size_t b = 0; b < 10; ++b) {
    CalibrationBin& bin = calibration.bins[b];
    calibration.pixels += bin.pixels, all_right += right[b], all_stated += stated[b];
    bin.accuracy = ratio(right[b], bin.pixels);
    bin.mean_confidence = bin.pixels == 0 ? no_value : stated[b] / static_cast<double>(bin.pixels);
    if (bin.pixels > 0) error += std::abs(static_cast<double>(right[b]) - stated[b]);
  }
  calibration.accuracy = ratio(all_right, calibration.pixels);
  calibration.mean_confidence =
      calibration.pixels == 0 ? no_value : all_stated / static_cast<double>(calibration.pixels);
  calibration.expected_error = calibration.pixels == 0 ? no_value : error / static_cast<double>(calibration.pixels);
  return calibration;
}

/// Intersection over union of the classes that `of` selects, taken as one.
template <typename Selects>
double iou(const ConfusionMatrix& confusion, Selects&& of) {
  std::size_t both = 0, either = 0;
  for (std::size_t t = 0; t < confusion.classes; ++t)
    for (std::size_t p = 0; p < confusion.classes; ++p) {
      if (of(t) && of(p)) both += confusion.at(t, p);
      if (of(t) || of(p)) either += confusion.at(t, p);
    }
  return ratio(both, either);
}

/// Everything that follows from the confusion matrix.
void fill_scores(LabelScores& scores, const std::vector<ClassInfo>& classes) {
  const ConfusionMatrix& confusion = scores.confusion;
  std::size_t right = 0, occurring = 0, in_truth = 0;
  double sum = 0.0;
  for (std::size_t c = 0; c < classes.size(); ++c) {
    ClassScore score{.info = classes[c]};
    for (std::size_t other = 0; other < classes.size(); ++other) {
      score.truth_pixels += confusion.at(c, other);
      score.predicted_pixels += confusion.at(other, c);
    }
    const std::size_t both = confusion.at(c, c);
    score.iou = ratio(both, score.truth_pixels + score.predicted_pixels - both);
    score.precision = ratio(both, score.predicted_pixels);
    score.recall = ratio(both, score.truth_pixels);
    right += both;
    if (!std::isnan(score.iou)) sum += score.iou, ++occurring;  // a class absent from the truth adds 0 to the sum
    in_truth += score.truth_pixels > 0 ? 1 : 0;
    scores.classes.push_back(std::move(score));
  }
  scores.pixel_accuracy = ratio(right, scores.pixels);
  scores.mean_iou = occurring == 0 ? no_value : sum / static_cast<double>(occurring);
  scores.mean_iou_of_truth = in_truth == 0 ? no_value : sum / static_cast<double>(in_truth);
  scores.road_iou = iou(confusion, [&](std::size_t c) { return classes[c].role == Role::road; });
}
}  // namespace

LabelScores evaluate_labels(const LabelComparisonView& view, const EvaluateLabelsOptions& options) {
  const ConfidenceMap* confidence = options.confidence;
  if (confidence && (confidence->crs != view.prediction().crs || confidence->frame != view.prediction().frame))
    throw OptionError(
        "the confidence raster does not lie on the label map's grid; take both from one `orthodrive segment`");
  LabelScores scores;
  scores.confusion = ConfusionMatrix(view.classes().size());
  ConfidenceCounts counts;
  for (int row = 0; row < view.frame().height; ++row)
    for (int col = 0; col < view.frame().width; ++col) {
      const LabelPair pair = view.at(col, row);
      count(scores, pair);
      if (!confidence || pair.state != PixelState::compared) continue;
      const std::uint8_t stated = confidence->confidence.at(pair.prediction_col, pair.prediction_row);
      ++counts.pixels[stated];
      counts.right[stated] += pair.right_before_merge ? 1 : 0;
    }
  fill_scores(scores, view.classes());
  if (confidence) scores.calibration = calibration_of(counts);
  return scores;
}

LabelScores evaluate_labels(const LabelMap& prediction, const LabelMap& truth, const ScoreRegion& region) {
  return evaluate_labels(LabelComparisonView(prediction, truth, {.region = region}));
}

std::vector<PieceScores> evaluate_pieces(const LabelComparisonView& view, const TruthPieces& pieces) {
  std::vector<PieceScores> all;
  all.reserve(pieces.names.size());
  for (const std::string& name : pieces.names) {
    all.push_back({.name = name});
    all.back().scores.confusion = ConfusionMatrix(view.classes().size());
  }
  if (all.empty()) return all;
  for (int row = 0; row < view.frame().height; ++row)
    for (int col = 0; col < view.frame().width; ++col)
      if (const std::uint16_t piece = pieces.index.at(col, row); piece != 0)
        count(all[piece - std::size_t{1}].scores, view.at(col, row));
  for (PieceScores& piece : all) fill_scores(piece.scores, view.classes());
  return all;
}

RoadRoleScores evaluate_road_role(const LabelMap& prediction, const MultiPolygon& roads, const ScoreRegion& region) {
  const Raster<std::uint8_t> mask = region_mask(prediction.frame, region);
  Raster<std::uint8_t> truth(prediction.frame.width, prediction.frame.height);
  for (const Polygon& road : roads) fill_polygon(truth, prediction.frame, road, std::uint8_t{1});
  std::size_t both = 0, predicted = 0, expected = 0, pixels = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const std::uint8_t label = prediction.labels.data[i];
    if (!mask.data[i] || label == label_nodata) continue;
    const bool is = prediction.classes.classes.at(label).role == Role::road, should = truth.data[i] != 0;
    ++pixels;
    both += is && should ? 1 : 0;
    predicted += is ? 1 : 0;
    expected += should ? 1 : 0;
  }
  return {ratio(both, predicted + expected - both), ratio(both, predicted), ratio(both, expected), pixels};
}

}  // namespace orthodrive

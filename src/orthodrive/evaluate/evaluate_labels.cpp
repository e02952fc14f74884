#include "orthodrive/evaluate/evaluate_labels.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

namespace orthodrive {
namespace {
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? nan : static_cast<double>(part) / static_cast<double>(whole);
}

/// 1 where the region counts.
Raster<std::uint8_t> region_mask(const GridFrame& frame, const ScoreRegion& region) {
  Raster<std::uint8_t> mask(frame.width, frame.height, 1, region.area ? 0 : 1);
  if (region.area)
    for (const Polygon& polygon : *region.area) fill_polygon(mask, frame, polygon, std::uint8_t{1});
  for (const Polygon& polygon : region.ignore) fill_polygon(mask, frame, polygon, std::uint8_t{0});
  return mask;
}

/// The truth's classes, then those that only the prediction has; and where its labels land in that list.
struct CommonClasses {
  std::vector<ClassInfo> classes;
  std::array<std::size_t, 256> from_prediction{};
};

CommonClasses common_classes(const ClassTable& truth, const ClassTable& prediction) {
  CommonClasses common{.classes = truth.classes};
  for (std::size_t label = 0; label < prediction.classes.size(); ++label) {
    const auto at = std::find_if(common.classes.begin(), common.classes.end(),
                                 [&](const ClassInfo& c) { return c.name == prediction.classes[label].name; });
    common.from_prediction.at(label) = static_cast<std::size_t>(at - common.classes.begin());
    if (at == common.classes.end()) common.classes.push_back(prediction.classes[label]);
  }
  return common;
}

/// Rows are the truth, columns the prediction.
struct Confusion {
  std::size_t classes = 0;
  std::vector<std::size_t> counts;
  explicit Confusion(std::size_t n) : classes(n), counts(n * n) {}
  std::size_t& at(std::size_t truth, std::size_t predicted) { return counts[truth * classes + predicted]; }
};

/// Intersection over union of the classes that `of` selects, taken as one.
template <typename Selects>
double iou(Confusion& confusion, Selects&& of) {
  std::size_t both = 0, either = 0;
  for (std::size_t t = 0; t < confusion.classes; ++t)
    for (std::size_t p = 0; p < confusion.classes; ++p) {
      if (of(t) && of(p)) both += confusion.at(t, p);
      if (of(t) || of(p)) either += confusion.at(t, p);
    }
  return ratio(both, either);
}

void fill_scores(LabelScores& scores, Confusion& confusion, const std::vector<ClassInfo>& classes) {
  std::size_t right = 0, occurring = 0;
  double sum = 0.0;
  for (std::size_t c = 0; c < classes.size(); ++c) {
    right += confusion.at(c, c);
    ClassScore score{.name = classes[c].name, .iou = iou(confusion, [c](std::size_t other) { return other == c; })};
    for (std::size_t p = 0; p < classes.size(); ++p) score.truth_pixels += confusion.at(c, p);
    if (score.iou == score.iou) sum += score.iou, ++occurring;
    scores.classes.push_back(std::move(score));
  }
  scores.pixel_accuracy = ratio(right, scores.pixels);
  scores.mean_iou = occurring == 0 ? nan : sum / static_cast<double>(occurring);
  scores.road_iou = iou(confusion, [&](std::size_t c) { return classes[c].role == Role::road; });
}
}  // namespace

LabelScores evaluate_labels(const LabelMap& prediction, const LabelMap& truth, const ScoreRegion& region) {
  const CommonClasses common = common_classes(truth.classes, prediction.classes);
  const Raster<std::uint8_t> mask = region_mask(truth.frame, region);
  std::optional<CoordinateTransform> prediction_from_truth;
  if (prediction.crs != truth.crs) prediction_from_truth.emplace(truth.crs, prediction.crs);
  Confusion confusion(common.classes.size());
  LabelScores scores;
  for (int row = 0; row < truth.frame.height; ++row)
    for (int col = 0; col < truth.frame.width; ++col) {
      if (!mask.at(col, row)) continue;
      const std::uint8_t expected = truth.labels.at(col, row);
      if (expected == label_nodata) {
        ++scores.truth_nodata;
        continue;
      }
      const Vec2 p = truth.frame.center_of(col, row);
      const Vec2 q =
          prediction.frame.pixel_from_world(prediction_from_truth ? prediction_from_truth->target_from_source(p) : p);
      const int pcol = static_cast<int>(std::floor(q.x)), prow = static_cast<int>(std::floor(q.y));
      if (!prediction.labels.inside(pcol, prow) || prediction.labels.at(pcol, prow) == label_nodata) {
        ++scores.not_predicted;
        continue;
      }
      ++confusion.at(expected, common.from_prediction[prediction.labels.at(pcol, prow)]);
      ++scores.pixels;
    }
  fill_scores(scores, confusion, common.classes);
  return scores;
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

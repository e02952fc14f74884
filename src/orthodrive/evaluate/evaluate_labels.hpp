#pragma once
// How well a label map agrees with the truth.

#include <cstddef>
#include <string>
#include <vector>

#include "orthodrive/evaluate/scores.hpp"
#include "orthodrive/model/rasters.hpp"

namespace orthodrive {

struct ClassScore {
  std::string name;
  double iou = 0.0;  ///< NaN when neither the prediction nor the truth has the class
  std::size_t truth_pixels = 0;
};

struct LabelScores {
  double pixel_accuracy = 0.0;      ///< NaN when nothing was compared
  double mean_iou = 0.0;            ///< over the classes that occur
  std::vector<ClassScore> classes;  ///< of the truth's table, then those only the prediction has
  double road_iou = 0.0;            ///< of all classes with the role road together
  std::size_t pixels = 0;           ///< compared
  std::size_t truth_nodata = 0;     ///< pixels in the region that the truth leaves open
  std::size_t not_predicted =
      0;  ///< pixels with truth where there is no prediction (nodata, or beyond its grid): not compared
};

/// Compares at the truth's pixel centres with the label of the prediction's pixel there. Classes are matched by name.
/// The CRSs may differ; the region is in the truth's.
[[nodiscard]] LabelScores evaluate_labels(const LabelMap& prediction, const LabelMap& truth,
                                          const ScoreRegion& region = {});

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

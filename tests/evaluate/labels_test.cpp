// Label scores from maps small enough to count by hand.

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/evaluate/evaluate_labels.hpp"

namespace orthodrive {
namespace {

const Crs utm33{"EPSG:32633"};
const Vec2 origin{500000.0, 5540000.0};

LabelMap map_of(int width, int height, double gsd_m, std::uint8_t label) {
  return {utm33,
          {origin.x, origin.y, gsd_m, width, height},
          Raster<std::uint8_t>(width, height, 1, label),
          default_class_table()};
}
void paint(LabelMap& map, int col0, int row0, int col1, int row1, std::uint8_t label) {
  for (int row = row0; row < row1; ++row)
    for (int col = col0; col < col1; ++col) map.labels.at(col, row) = label;
}
double iou_of(const LabelScores& scores, const std::string& name) {
  for (const ClassScore& c : scores.classes)
    if (c.name == name) return c.iou;
  ADD_FAILURE() << name;
  return -1.0;
}
Polygon rectangle(double x0, double y0, double x1, double y1) {  // metres east and south of the origin
  return {{origin + Vec2{x0, -y0}, origin + Vec2{x1, -y0}, origin + Vec2{x1, -y1}, origin + Vec2{x0, -y1}}, {}};
}

TEST(EvaluateLabels, equal_maps_are_perfect) {
  LabelMap map = map_of(10, 10, 1.0, 0);
  paint(map, 2, 2, 5, 5, 1);
  const LabelScores scores = evaluate_labels(map, map);
  EXPECT_DOUBLE_EQ(scores.pixel_accuracy, 1.0);
  EXPECT_DOUBLE_EQ(scores.mean_iou, 1.0);
  EXPECT_DOUBLE_EQ(scores.road_iou, 1.0);
  EXPECT_EQ(scores.pixels, 100u);
  EXPECT_TRUE(std::isnan(iou_of(scores, "water"))) << "occurs nowhere: no score, and not in the mean";
}

TEST(EvaluateLabels, shifted_rectangle) {
  LabelMap truth = map_of(20, 10, 1.0, 0), prediction = truth;
  paint(truth, 2, 0, 10, 10, 1);       // 80 px
  paint(prediction, 4, 0, 12, 10, 1);  // shifted by 2: 60 in common, 100 in either
  const LabelScores scores = evaluate_labels(prediction, truth);
  EXPECT_DOUBLE_EQ(scores.road_iou, 0.6);
  EXPECT_DOUBLE_EQ(iou_of(scores, "road"), 0.6);
  EXPECT_DOUBLE_EQ(iou_of(scores, "ground"), 100.0 / 140.0);
  EXPECT_DOUBLE_EQ(scores.mean_iou, 0.5 * (0.6 + 100.0 / 140.0));
  EXPECT_DOUBLE_EQ(scores.pixel_accuracy, 160.0 / 200.0);
}

TEST(EvaluateLabels, grids_of_different_size_and_extent) {
  LabelMap truth = map_of(10, 10, 1.0, 1), prediction = map_of(7, 20, 0.5, 1);  // covers 3.5 m x 10 m
  paint(prediction, 0, 0, 7, 10, 0);                                            // northern half wrong
  const LabelScores scores = evaluate_labels(prediction, truth);
  EXPECT_EQ(scores.pixels, 30u) << "centres of columns 0, 1, 2";
  EXPECT_EQ(scores.not_predicted, 70u);
  EXPECT_DOUBLE_EQ(scores.pixel_accuracy, 0.5);
}

TEST(EvaluateLabels, nodata_on_either_side_is_left_out_and_counted) {
  LabelMap truth = map_of(10, 10, 1.0, 1), prediction = truth;
  paint(truth, 0, 0, 10, 1, label_nodata);
  paint(prediction, 0, 0, 10, 3, label_nodata);
  const LabelScores scores = evaluate_labels(prediction, truth);
  EXPECT_EQ(scores.truth_nodata, 10u);
  EXPECT_EQ(scores.not_predicted, 20u);
  EXPECT_EQ(scores.pixels, 70u);
}

TEST(EvaluateLabels, area_and_ignore) {
  const LabelMap truth = map_of(10, 10, 1.0, 1), prediction = map_of(10, 10, 1.0, 0);
  const ScoreRegion region{MultiPolygon{rectangle(0, 0, 10, 4)}, {rectangle(0, 0, 5, 10)}};
  EXPECT_EQ(evaluate_labels(prediction, truth, region).pixels, 20u);
}

TEST(EvaluateLabels, classes_are_matched_by_name_not_by_number) {
  LabelMap truth = map_of(4, 4, 1.0, 0);
  truth.classes = {"mine", {{"road", {}, Role::road}, {"canal", {}, Role::water}}};  // road is 0 here
  paint(truth, 0, 0, 4, 1, 1);
  const LabelMap prediction = map_of(4, 4, 1.0, 1);  // road is 1 there
  const LabelScores scores = evaluate_labels(prediction, truth);
  EXPECT_DOUBLE_EQ(scores.road_iou, 0.75);
  EXPECT_DOUBLE_EQ(iou_of(scores, "canal"), 0.0) << "never predicted";
}

TEST(EvaluateLabels, other_crs_is_looked_up_point_by_point) {
  LabelMap truth = map_of(40, 40, 1.0, 0);
  paint(truth, 10, 10, 20, 30, 1);
  // The same picture in zone 32, on a fine grid.
  const Crs utm32{"EPSG:32632"};
  const CoordinateTransform utm32_from_utm33(utm33, utm32);
  const Vec2 corner = utm32_from_utm33.target_from_source(origin + Vec2{-5, 5});
  LabelMap prediction = map_of(500, 500, 0.125, 0);
  prediction.crs = utm32, prediction.frame.west_m = corner.x, prediction.frame.north_m = corner.y;
  for (int row = 0; row < 500; ++row)
    for (int col = 0; col < 500; ++col) {
      const Vec2 q =
          truth.frame.pixel_from_world(utm32_from_utm33.source_from_target(prediction.frame.center_of(col, row)));
      if (q.x >= 10 && q.x < 20 && q.y >= 10 && q.y < 30) prediction.labels.at(col, row) = 1;
    }
  EXPECT_DOUBLE_EQ(evaluate_labels(prediction, truth).road_iou, 1.0);
}

TEST(EvaluateLabels, nothing_in_common_gives_no_score) {
  LabelMap truth = map_of(4, 4, 1.0, 0), prediction = truth;
  prediction.frame.west_m += 1000.0;
  const LabelScores scores = evaluate_labels(prediction, truth);
  EXPECT_EQ(scores.pixels, 0u);
  EXPECT_TRUE(std::isnan(scores.pixel_accuracy));
  EXPECT_TRUE(std::isnan(scores.road_iou));
}

TEST(EvaluateRoadRole, counts_road_pixels_against_polygons) {
  LabelMap prediction = map_of(20, 10, 1.0, 0);
  paint(prediction, 4, 0, 12, 10, 1);
  prediction.labels.at(0, 0) = label_nodata;
  const RoadRoleScores scores = evaluate_road_role(prediction, {rectangle(2, 0, 10, 10)});
  EXPECT_DOUBLE_EQ(scores.road_iou, 0.6);
  EXPECT_DOUBLE_EQ(scores.precision, 0.75);
  EXPECT_DOUBLE_EQ(scores.recall, 0.75);
  EXPECT_EQ(scores.pixels, 199u);
}

TEST(Summarize, bias_mean_and_p95) {
  std::vector<double> errors;
  for (int i = 1; i <= 100; ++i) errors.push_back(i % 2 == 0 ? i : -i);
  const ErrorSummary summary = summarize(errors);
  EXPECT_DOUBLE_EQ(summary.bias, 0.5);
  EXPECT_DOUBLE_EQ(summary.mean_abs, 50.5);
  EXPECT_DOUBLE_EQ(summary.p95, 95.0);
  EXPECT_DOUBLE_EQ(summarize({3.0}).p95, 3.0);
  EXPECT_TRUE(std::isnan(summarize({}).bias));
}

}  // namespace
}  // namespace orthodrive

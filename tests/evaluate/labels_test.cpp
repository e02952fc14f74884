// SPDX-License-Identifier: Apache-2.0
// Label scores from maps small enough to count by hand.

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/evaluate/labels/evaluate_labels.hpp"

namespace orthodrive {
namespace {

const Crs utm33{"EPSG:32633"};
const Vec2 photo_origin{500000.0, 5540000.0};

LabelMap map_of(int width, int height, double gsd_m, std::uint8_t label) {
  return {utm33,
          {photo_origin.x, photo_origin.y, gsd_m, width, height},
          Raster<std::uint8_t>(width, height, 1, label),
          default_class_table()};
}
void paint(LabelMap& map, int col0, int row0, int col1, int row1, std::uint8_t label) {
  for (int row = row0; row < row1; ++row)
    for (int col = col0; col < col1; ++col) map.labels.at(col, row) = label;
}
ClassScore class_of(const LabelScores& scores, const std::string& name) {
  for (const ClassScore& c : scores.classes)
    if (c.info.name == name) return c;
  ADD_FAILURE() << name;
  return {};
}
double iou_of(const LabelScores& scores, const std::string& name) { return class_of(scores, name).iou; }
Polygon rectangle(double x0, double y0, double x1, double y1) {  // metres east and south of the photo_origin
  return {{photo_origin + Vec2{x0, -y0}, photo_origin + Vec2{x1, -y0}, photo_origin + Vec2{x1, -y1},
           photo_origin + Vec2{x0, -y1}},
          {}};
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
  const Vec2 corner = utm32_from_utm33.target_from_source(photo_origin + Vec2{-5, 5});
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

TEST(EvaluateLabels, confusion_precision_and_recall_by_hand) {
  LabelMap truth = map_of(10, 10, 1.0, 0), prediction = truth;
  paint(truth, 0, 0, 4, 10, 1);       // 40 px road in the truth
  paint(prediction, 2, 0, 8, 10, 1);  // 60 px road in the prediction, 20 of them right
  const LabelScores scores = evaluate_labels(prediction, truth);
  EXPECT_EQ(scores.confusion.at(0, 0), 20u);
  EXPECT_EQ(scores.confusion.at(0, 1), 40u) << "row: truth ground, column: predicted road";
  EXPECT_EQ(scores.confusion.at(1, 0), 20u);
  EXPECT_EQ(scores.confusion.at(1, 1), 20u);
  const ClassScore road = class_of(scores, "road");
  EXPECT_EQ(road.truth_pixels, 40u);
  EXPECT_EQ(road.predicted_pixels, 60u);
  EXPECT_DOUBLE_EQ(road.precision, 20.0 / 60.0);
  EXPECT_DOUBLE_EQ(road.recall, 20.0 / 40.0);
  EXPECT_DOUBLE_EQ(road.iou, 20.0 / 80.0);
}

TEST(EvaluateLabels, one_pixel_of_a_class_the_truth_has_not_counts_as_zero_in_the_mean) {
  // The reference's class 'water': its one wrong pixel costs half of the mean here.
  const LabelMap truth = map_of(4, 4, 1.0, 1);
  LabelMap prediction = truth;
  prediction.labels.at(0, 0) = 6;
  const LabelScores scores = evaluate_labels(prediction, truth);
  const ClassScore water = class_of(scores, "water");
  EXPECT_DOUBLE_EQ(water.iou, 0.0);
  EXPECT_DOUBLE_EQ(water.precision, 0.0);
  EXPECT_TRUE(std::isnan(water.recall));
  EXPECT_DOUBLE_EQ(scores.mean_iou, 0.5 * (15.0 / 16.0 + 0.0));
  EXPECT_DOUBLE_EQ(scores.mean_iou_of_truth, 15.0 / 16.0);
}

TEST(EvaluateLabels, class_that_is_never_predicted_counts_in_both_means) {
  LabelMap truth = map_of(4, 4, 1.0, 1);
  paint(truth, 0, 0, 4, 1, 7);
  const LabelScores scores = evaluate_labels(map_of(4, 4, 1.0, 1), truth);
  const ClassScore rail = class_of(scores, "rail");
  EXPECT_DOUBLE_EQ(rail.iou, 0.0);
  EXPECT_DOUBLE_EQ(rail.recall, 0.0);
  EXPECT_TRUE(std::isnan(rail.precision));
  EXPECT_DOUBLE_EQ(scores.mean_iou, 0.375);
  EXPECT_DOUBLE_EQ(scores.mean_iou_of_truth, 0.375);
}

TEST(EvaluateLabels, prediction_far_beyond_the_numbers_of_pixels_is_not_predicted) {
  const LabelMap truth = map_of(4, 4, 1.0, 0);
  LabelMap prediction = truth;
  prediction.frame.west_m = -1e13;
  EXPECT_EQ(evaluate_labels(prediction, truth).not_predicted, 16u);
}

TEST(MergeClasses, confused_pair_is_one_class_afterwards) {
  LabelMap truth = map_of(10, 10, 1.0, 0);
  truth.classes = {"houses",
                   {{"shed", {}, Role::building}, {"detached", {}, Role::building}, {"lane", {}, Role::road}}};
  LabelMap prediction = truth;
  paint(truth, 0, 0, 4, 10, 1), paint(truth, 8, 0, 10, 10, 2);            // 40 shed, 40 detached, 20 lane
  paint(prediction, 4, 0, 8, 10, 1), paint(prediction, 7, 0, 10, 10, 2);  // houses the wrong way round, lane too wide
  const LabelScores apart = evaluate_labels(prediction, truth);
  EXPECT_DOUBLE_EQ(apart.pixel_accuracy, 0.2);
  const LabelComparisonView view(prediction, truth, {.merge = {{"shed", "detached"}}});
  const LabelScores merged = evaluate_labels(view);
  ASSERT_EQ(merged.classes.size(), 2u);
  EXPECT_DOUBLE_EQ(merged.pixel_accuracy, 0.9);
  EXPECT_DOUBLE_EQ(iou_of(merged, "detached"), 70.0 / 80.0);
  EXPECT_DOUBLE_EQ(iou_of(merged, "lane"), 20.0 / 30.0);
  EXPECT_DOUBLE_EQ(merged.road_iou, 20.0 / 30.0);
  EXPECT_EQ(merged.confusion.at(0, 1), 10u);
}

TEST(MergeClasses, into_a_new_class_and_the_order_that_results) {
  const std::vector<ClassInfo> classes{{"a", {1, 1, 1}}, {"b", {2, 2, 2}, Role::road}, {"c"}, {"d", {4, 4, 4}}, {"e"}};
  const MergedClasses merged = merge_classes(classes, {{"b", "bd"}, {"d", "bd"}, {"a", "e"}});
  std::string order;
  for (const ClassInfo& c : merged.classes) order += c.name + " ";
  EXPECT_EQ(order, "bd c e ") << "the new class stands where its first old one stood, e where it was";
  EXPECT_EQ(merged.classes[0].color[0], 2) << "and looks like it";
  EXPECT_EQ(merged.classes[0].role, Role::road);
  EXPECT_EQ(merged.from_old, (std::vector<std::uint16_t>{2, 0, 1, 0, 2}));
}

TEST(MergeClasses, tables_that_cannot_be_meant) {
  const std::vector<ClassInfo> classes{{"a"}, {"b"}, {"c"}};
  EXPECT_THROW(static_cast<void>(merge_classes(classes, {{"x", "a"}})), OptionError) << "nobody has x";
  EXPECT_THROW(static_cast<void>(merge_classes(classes, {{"a", "b"}, {"b", "c"}})), OptionError) << "a chain";
  EXPECT_EQ(merge_classes(classes, {}).classes.size(), 3u);
  EXPECT_EQ(merge_classes(classes, {{"a", "a"}}).classes.size(), 3u);
}

/// 20 x 10 px: 100 with confidence 0.8, 50 with 1, 50 with 0.4; right are 80, 50, 10 of them.
struct CalibrationScene {
  LabelMap truth = map_of(20, 10, 1.0, 1), prediction = truth;
  ConfidenceMap confidence{utm33, truth.frame, Raster<std::uint8_t>(20, 10, 1, 204)};
  CalibrationScene() {
    for (int row = 0; row < 10; ++row)
      for (int col = 10; col < 20; ++col) confidence.confidence.at(col, row) = col < 15 ? 255 : 102;
    paint(prediction, 0, 0, 10, 2, 0);
    paint(prediction, 15, 0, 20, 8, 0);
  }
};

TEST(Calibration, of_constructed_confidences) {
  const CalibrationScene scene;
  const LabelScores scores =
      evaluate_labels(LabelComparisonView(scene.prediction, scene.truth), {.confidence = &scene.confidence});
  ASSERT_TRUE(scores.calibration);
  const Calibration& calibration = *scores.calibration;
  EXPECT_EQ(calibration.pixels, 200u);
  EXPECT_NEAR(calibration.mean_confidence, 0.75, 1e-12);
  EXPECT_DOUBLE_EQ(calibration.accuracy, 0.7);
  EXPECT_NEAR(calibration.expected_error, 50.0 * 0.2 / 200.0, 1e-12) << "0.4 is stated, 0.2 are right";
  EXPECT_EQ(calibration.bins[8].pixels, 100u) << "0.8 is in [0.8, 0.9)";
  EXPECT_NEAR(calibration.bins[8].mean_confidence, 0.8, 1e-12);
  EXPECT_DOUBLE_EQ(calibration.bins[8].accuracy, 0.8);
  EXPECT_EQ(calibration.bins[9].pixels, 50u) << "1 is in the last";
  EXPECT_EQ(calibration.bins[4].pixels, 50u);
  EXPECT_DOUBLE_EQ(calibration.bins[4].accuracy, 0.2);
  EXPECT_TRUE(std::isnan(calibration.bins[0].accuracy));
}

TEST(Calibration, is_of_the_class_before_merging_and_of_compared_pixels_only) {
  CalibrationScene scene;
  paint(scene.truth, 0, 8, 20, 10, label_nodata);
  const LabelComparisonView view(scene.prediction, scene.truth, {.merge = {{"road", "ground"}}});
  const LabelScores scores = evaluate_labels(view, {.confidence = &scene.confidence});
  EXPECT_DOUBLE_EQ(scores.pixel_accuracy, 1.0);
  ASSERT_TRUE(scores.calibration.has_value());
  EXPECT_EQ(scores.calibration->pixels, 160u);
  EXPECT_DOUBLE_EQ(scores.calibration->accuracy, (60.0 + 40.0 + 0.0) / 160.0);
}

TEST(Calibration, other_grid_or_nothing_to_compare) {
  CalibrationScene scene;
  scene.confidence.frame.west_m += 0.5;
  const LabelComparisonView view(scene.prediction, scene.truth);
  EXPECT_THROW(static_cast<void>(evaluate_labels(view, {.confidence = &scene.confidence})), OptionError);
  const CalibrationScene same;
  const LabelMap nowhere = map_of(20, 10, 1.0, label_nodata);
  const LabelScores scores =
      evaluate_labels(LabelComparisonView(same.prediction, nowhere), {.confidence = &same.confidence});
  ASSERT_TRUE(scores.calibration.has_value());
  EXPECT_EQ(scores.calibration->pixels, 0u);
  EXPECT_TRUE(std::isnan(scores.calibration->expected_error));
}

TEST(EvaluatePieces, each_on_its_own) {
  LabelMap truth = map_of(20, 10, 1.0, 1), prediction = truth;
  paint(prediction, 0, 0, 3, 10, 0);               // 30 px wrong
  paint(prediction, 15, 0, 20, 10, label_nodata);  // the third piece is not predicted
  TruthPieces pieces{{"west", "middle", "east"}, Raster<std::uint16_t>(20, 10)};
  for (int row = 0; row < 10; ++row)
    for (int col = 0; col < 20; ++col) pieces.index.at(col, row) = col < 5 ? 1 : col < 10 ? 2 : col < 15 ? 0 : 3;
  const std::vector<PieceScores> scores = evaluate_pieces(LabelComparisonView(prediction, truth), pieces);
  ASSERT_EQ(scores.size(), 3u);
  EXPECT_EQ(scores[0].name, "west");
  EXPECT_DOUBLE_EQ(scores[0].scores.road_iou, 0.4);
  EXPECT_DOUBLE_EQ(scores[0].scores.pixel_accuracy, 0.4);
  EXPECT_DOUBLE_EQ(scores[0].scores.mean_iou, 0.2) << "ground is absent from the truth and counts as zero";
  EXPECT_DOUBLE_EQ(scores[1].scores.mean_iou, 1.0);
  EXPECT_EQ(scores[2].scores.pixels, 0u);
  EXPECT_EQ(scores[2].scores.not_predicted, 50u);
  EXPECT_TRUE(evaluate_pieces(LabelComparisonView(prediction, truth), {}).empty());
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

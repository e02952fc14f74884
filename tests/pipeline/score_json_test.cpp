// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/score/score_json.hpp"

#include <gtest/gtest.h>

#include "evaluate/road_lines.hpp"
#include "orthodrive/evaluate/roads/evaluate_roads.hpp"

namespace orthodrive {
namespace {

TEST(ScoreJson, of_roads_has_all_keys) {
  const RoadNetwork truth{utm33, {path_along(straight(0, 0, 100, 0), 6.0)}};
  const ScoreJson json = to_json(evaluate_roads(truth, road_truth(truth, utm33), {.before = &truth}));
  for (const char* key : {"surface_iou", "offset_m", "width_m", "sigma_coverage", "matched_share", "samples"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_NEAR(json["width_variance_m2"].get<double>(), 0.0, 1e-12);
  EXPECT_NEAR(json["largest_curvature_jump"]["per_m"].get<double>(), 0.0, 1e-9);
  EXPECT_EQ(json["largest_curvature_jump"]["osm_id"], 1);
  EXPECT_EQ(json["moved_away"]["share"], 0.0);
  EXPECT_EQ(json["moved_away"]["share_by_more_than_0_3_m"], 0.0);
  EXPECT_EQ(json["moved_away"]["n"], 50);
  EXPECT_FALSE(to_json(evaluate_roads(truth, road_truth(truth, utm33))).contains("moved_away"));
}

}  // namespace
}  // namespace orthodrive

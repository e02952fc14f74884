// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/allowed_classes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace orthodrive {
namespace {

TEST(LabelScore, counts_by_hand) {
  LabelScore score(3);
  //                 hit     miss 0, wrong 1   unknown  in the set  outside it: wrong 0   nodata
  const std::vector<std::uint8_t> labels{0, 1, 2, 1, 0, 255};
  const std::vector<ClassSet> allowed{only(0), only(0), 0, 0b110, 0b110, only(1)};
  score.add(labels, allowed);
  EXPECT_DOUBLE_EQ(score.iou(0), 1.0 / 3.0);  // 1 hit, 1 missed, 1 wrong
  EXPECT_TRUE(std::isnan(score.iou(1)));      // only predicted
  EXPECT_TRUE(std::isnan(score.iou(2)));
  EXPECT_DOUBLE_EQ(score.mean_iou(), 1.0 / 3.0);  // only class 0 is in the truth
  EXPECT_DOUBLE_EQ(score.pixel_accuracy(), 0.5);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/road_pictures.hpp"

#include <gtest/gtest.h>

#include <array>

#include "evaluate/road_lines.hpp"

namespace orthodrive {
namespace {

Polygon box(double x0, double y0, double x1, double y1) {
  return {{origin + Vec2{x0, y0}, origin + Vec2{x1, y0}, origin + Vec2{x1, y1}, origin + Vec2{x0, y1}}, {}};
}

TEST(RoadPictures, false_positives_are_red_and_false_negatives_blue) {
  const RoadSurfaces surfaces{{box(0, 0, 60, 10)}, {box(20, 0, 80, 10)}};
  const ScoreRegion region{.ignore = {box(-20, 5, 100, 20)}};
  const GridFrame frame = road_picture_frame(surfaces, region);
  EXPECT_EQ(frame.gsd_m, 0.25);
  EXPECT_NEAR(frame.width, (80 + 2 * 10) / 0.25, 2);
  const Canvas canvas = picture_of_road_errors(surfaces, region, frame, nullptr);
  const auto color = [&](double x, double y) {
    const Vec2 q = frame.pixel_from_world(origin + Vec2{x, y});
    std::array<int, 3> rgb;
    for (int k = 0; k < 3; ++k)
      rgb[static_cast<std::size_t>(k)] = canvas.rgb.at(static_cast<int>(q.x), static_cast<int>(q.y), k);
    return rgb;
  };
  const auto red = color(10, 2), blue = color(70, 2), yellow = color(40, 2), nothing = color(40, -5),
             ignored = color(10, 8);
  EXPECT_TRUE(red[0] > 150 && red[1] < 100 && red[2] < 100);
  EXPECT_TRUE(blue[2] > 150 && blue[0] < 100 && blue[1] < 120);
  EXPECT_TRUE(yellow[0] > 200 && yellow[1] > 200 && yellow[2] < yellow[0]);
  EXPECT_TRUE(nothing[0] == nothing[1] && nothing[1] == nothing[2]);
  EXPECT_TRUE(ignored[0] == ignored[1] && ignored[0] > nothing[0]) << "pale outside the region";
}

TEST(RoadPictures, large_places_get_coarser_pixels) {
  const GridFrame frame = road_picture_frame({{box(0, 0, 20000, 10)}, {box(0, 0, 10, 8000)}}, {});
  EXPECT_LE(frame.width, 4000);
  EXPECT_GT(frame.width, 3900);
  EXPECT_NEAR(frame.gsd_m, 20020.0 / 3998.0, 1e-9);
  const GridFrame small =
      road_picture_frame({{box(0, 0, 20000, 10)}, {}}, {.area = MultiPolygon{box(100, -50, 200, 50)}});
  EXPECT_LT(small.width, 410) << "the area limits it";
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/paint_labels.hpp"

#include <gtest/gtest.h>

#include <string>

namespace orthodrive {
namespace {

constexpr ClassSet ground_class = only(0), road_class = only(1), parking_class = only(2), building = only(3);

/// One letter a pixel, rows from north to south.
std::string drawing(const Raster<ClassSet>& sets) {
  std::string text;
  for (int row = 0; row < sets.height; ++row) {
    for (int col = 0; col < sets.width; ++col) {
      const ClassSet set = sets.at(col, row);
      text += set == 0                              ? '.'
              : set == ground_class                 ? 'g'
              : set == road_class                   ? 'r'
              : set == parking_class                ? 'p'
              : set == building                     ? 'b'
              : set == (road_class | parking_class) ? 'x'
                                                    : '?';
    }
    text += '\n';
  }
  return text;
}

PaintShape box(double west, double south, double east, double north) {
  return {.polygons = {{{{west, south}, {east, south}, {east, north}, {west, north}}, {}}}};
}

TEST(PaintLabels, a_tiny_town) {
  const GridFrame frame{100.0, 210.0, 1.0, 12, 10};
  const PaintLayer car_park{.shapes = {box(100, 204, 104, 210)}, .classes = parking_class};
  const PaintLayer house{.shapes = {box(107, 205, 111, 209)}, .classes = building, .unknown_outside_m = 0.6};
  const PaintLayer service{.shapes = {{.line = {{98.0, 207.5}, {105.9, 207.5}}, .width_m = 1.0}},
                           .classes = road_class,
                           .merge_over = parking_class};
  const PaintLayer street{.shapes = {{.line = {{90.0, 201.5}, {120.0, 201.5}}, .width_m = 3.0}},
                          .classes = road_class,
                          .unknown_inside_m = 0.9,
                          .unknown_outside_m = 0.4};
  EXPECT_EQ(drawing(paint_labels(frame, ground_class, {car_park, house, service, street})),
            "ppppggg....g\n"
            "ppppgg.bbbb.\n"
            "xxxxrr.bbbb.\n"
            "ppppgg.bbbb.\n"
            "ppppgg.bbbb.\n"
            "ppppggg....g\n"
            "gggggggggggg\n"
            "............\n"
            "rrrrrrrrrrrr\n"
            "............\n");
}

TEST(PaintLabels, bands_do_not_cut_shapes_of_the_same_layer_that_touch) {
  const GridFrame frame{0.0, 3.0, 1.0, 6, 3};
  const PaintLayer roads{.shapes = {{.line = {{-5.0, 1.5}, {11.0, 1.5}}, .width_m = 1.0},
                                    {.line = {{2.5, -5.0}, {2.5, 8.0}}, .width_m = 1.0}},
                         .classes = road_class,
                         .unknown_outside_m = 1.0};
  EXPECT_EQ(drawing(paint_labels(frame, ground_class, {roads})),
            "..r...\n"
            "rrrrrr\n"
            "..r...\n");
}

TEST(PaintLabels, holes_points_and_things_outside) {
  const GridFrame frame{0.0, 5.0, 1.0, 5, 5};
  PaintShape ring = box(0, 0, 5, 5);
  ring.polygons[0].holes.push_back({{1, 1}, {1, 4}, {4, 4}, {4, 1}});
  const PaintLayer yard{.shapes = {ring}, .classes = building};
  const PaintLayer post{.shapes = {{.line = {{2.5, 2.5}}, .width_m = 1.0}}, .classes = parking_class};
  const PaintLayer far_away{.shapes = {box(50, 50, 60, 60), {.line = {{-90.0, 0.0}, {-80.0, 0.0}}, .width_m = 4.0}},
                            .classes = road_class};
  EXPECT_EQ(drawing(paint_labels(frame, ground_class, {yard, post, far_away})),
            "bbbbb\n"
            "bgggb\n"
            "bgpgb\n"
            "bgggb\n"
            "bbbbb\n");
}

TEST(PaintLabels, a_line_thinner_than_its_doubt_leaves_only_doubt) {
  const GridFrame frame{0.0, 3.0, 1.0, 3, 3};
  const PaintLayer path{.shapes = {{.line = {{-1.0, 1.5}, {4.0, 1.5}}, .width_m = 1.0}},
                        .classes = road_class,
                        .unknown_inside_m = 0.6,
                        .unknown_outside_m = 0.0};
  EXPECT_EQ(drawing(paint_labels(frame, ground_class, {path})), "ggg\n...\nggg\n");
}

}  // namespace
}  // namespace orthodrive

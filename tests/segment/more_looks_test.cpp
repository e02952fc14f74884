// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/more_looks.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nets/shipped_model.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/segment/mirror_beyond.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {
namespace {

constexpr int road = 1;

TEST(Mirrored, twice_is_what_was) {
  Raster<std::uint8_t> raster(7, 3, 3);
  for (std::size_t i = 0; i < raster.data.size(); ++i) raster.data[i] = static_cast<std::uint8_t>(i);
  const Raster<std::uint8_t> once = mirrored(raster);
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 7; ++col)
      for (int c = 0; c < 3; ++c) EXPECT_EQ(once.at(col, row, c), raster.at(6 - col, row, c));
  EXPECT_EQ(mirrored(once).data, raster.data);
  EXPECT_TRUE(mirrored_map({}).empty());
}

TEST(Mirrored, vectors_of_a_map_point_to_the_mirrored_road) {
  const GridFrame frame{0.0, 60.0, 1.0, 60, 60};
  const MapLines west({{{{9.25, -100.0}, {15.5, 100.0}}, 2.0}}), east({{{{50.75, -100.0}, {44.5, 100.0}}, 2.0}});
  const Raster<std::uint8_t> seen = mirrored_map(west.read(frame, pixels_of(frame))),
                             truth = east.read(frame, pixels_of(frame));
  for (std::size_t i = 0; i < seen.data.size(); ++i) ASSERT_NEAR(seen.data[i], truth.data[i], 1) << i;
}

/// Grass with a grey road of 8 m that winds from north to south, west of the middle; 0.2 m/px.
Photo photo_of_road(int size) {
  Photo photo{{"EPSG:32633"},
              {500000.0, 6400000.0, 0.2, size, size},
              Raster<std::uint8_t>(size, size, 3),
              Raster<std::uint8_t>(size, size, 1, 1)};
  Random random(6);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col) {
      const bool is_road = std::abs(0.2 * col - 30.0 - 6.0 * std::sin(0.2 * row / 15.0)) < 4.0;
      const int base[3] = {is_road ? 115 : 90, 115, is_road ? 118 : 70};
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(col, row, c) = static_cast<std::uint8_t>(std::clamp(base[c] + 4.0 * random.normal(), 0.0, 255.0));
    }
  return photo;
}

/// Of the road's score over all others, moved by some pixels, with that of `truth`.
double agreement(const Raster<float>& scores, const Raster<float>& truth, int cols, int rows) {
  constexpr int edge = 40;
  const auto is_road = [](const float* s) {
    float other = -1e9F;
    for (int k = 0; k < 8; ++k)
      if (k != road) other = std::max(other, s[k]);
    return s[road] > other;
  };
  int same = 0, all = 0;
  for (int row = edge; row < truth.height - edge; ++row)
    for (int col = edge; col < truth.width - edge; ++col, ++all)
      same += is_road(&scores.at(col + cols, row + rows)) == is_road(&truth.at(col, row)) ? 1 : 0;
  return static_cast<double>(same) / all;
}

TEST(MoreLooks, see_the_road_where_it_is) {
  const Photo photo = photo_of_road(500);
  const InferenceNetwork& network = *shipped_model().without_map;
  const MoreLooks looks(source_of(photo), 0.4);
  EXPECT_EQ(looks.finest_scale(), 0.75);
  const PixelBox all = pixels_of(photo.frame);
  Raster<float> truth(all.width, all.height, network.class_count()), scores = truth;
  for (int row = 0; row < all.height; ++row)
    for (int col = 0; col < all.width; ++col) truth.at(col, row, photo.rgb.at(col, row, 2) > 94 ? road : 5) = 1.0F;
  CellMemory memory;
  looks.average(network, nullptr, photo.frame, all, scores, memory);
  const double here = agreement(scores, truth, 0, 0);
  EXPECT_GT(here, 0.97);
  for (const auto& [cols, rows] : {std::pair{3, 0}, {-3, 0}, {0, 12}, {0, -12}})
    EXPECT_LT(agreement(scores, truth, cols, rows), here) << cols << ", " << rows;
}

TEST(MoreLooks, a_part_has_the_scores_of_the_whole) {
  const Photo photo = photo_of_road(400);
  const InferenceNetwork& network = *shipped_model().without_map;
  const MoreLooks looks(source_of(photo), 0.4);
  const PixelBox all = pixels_of(photo.frame), part{131, 57, 90, 77};
  Raster<float> whole(all.width, all.height, network.class_count(), 3.0F),
      some(part.width, part.height, network.class_count(), 3.0F);
  CellMemory memory;
  looks.average(network, nullptr, photo.frame, all, whole, memory);
  looks.average(network, nullptr, photo.frame, part, some, memory);
  for (int row = 0; row < part.height; ++row)
    for (int col = 0; col < part.width; ++col)
      for (int k = 0; k < network.class_count(); ++k)
        ASSERT_NEAR(some.at(col, row, k), whole.at(131 + col, 57 + row, k), 1e-3);
}

TEST(MoreLooks, none_leave_scores_as_they_are) {
  Raster<float> scores(4, 3, 8, 1.5F);
  CellMemory memory;
  MoreLooks().average(*shipped_model().without_map, nullptr, {0.0, 0.0, 0.2, 4, 3}, {0, 0, 4, 3}, scores, memory);
  for (const float s : scores.data) EXPECT_EQ(s, 1.5F);
}

}  // namespace
}  // namespace orthodrive

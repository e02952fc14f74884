// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/remote/tiles/tile_matrix.hpp"

#include <gtest/gtest.h>

#include <set>

#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/remote/tiles/tile_plan.hpp"

namespace orthodrive::remote {
namespace {

TEST(TileMatrix, quad_has_the_tile_that_everybody_has) {
  // Tile 17/71242/44368 of OpenStreetMap holds 15.7005 east, 50.0305 north.
  const TileMatrix m = web_mercator_quad(17, 17).matrices.front();
  const CoordinateTransform mercator(Crs{"EPSG:4326"}, Crs{"EPSG:3857"});
  const Vec2 p = mercator.target_from_source({15.7005, 50.0305});
  const double n = 131072.0, pi = 3.14159265358979323846, latitude = 50.0305 * pi / 180.0;
  const TileAddress expected{static_cast<std::int64_t>((15.7005 + 180.0) / 360.0 * n),
                             static_cast<std::int64_t>((1.0 - std::asinh(std::tan(latitude)) / pi) / 2.0 * n)};
  const auto tiles = tiles_over(m, {{p, {p.x + 0.01, p.y}, {p.x + 0.01, p.y + 0.01}}, {}}, 10);
  ASSERT_TRUE(tiles && tiles->size() == 1);
  EXPECT_EQ(tiles->front(), expected);
  EXPECT_TRUE(bounds_of_tile(m, expected).contains(p));
}

TEST(TileMatrix, tiles_cover_slanted_areas_and_no_tile_is_idle) {
  const TileMatrix m{"a", 1.0, 0.0, 10000.0, 10, 20, 1000, 500};
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Polygon area{{{random.uniform(100, 400), random.uniform(9000, 9900)},
                        {random.uniform(500, 900), random.uniform(9000, 9400)},
                        {random.uniform(500, 900), random.uniform(9500, 9900)}},
                       {}};
    const auto tiles = tiles_over(m, area, 100000);
    ASSERT_TRUE(tiles);
    EXPECT_TRUE(std::is_sorted(tiles->begin(), tiles->end(),
                               [](auto a, auto b) { return std::pair(a.row, a.column) < std::pair(b.row, b.column); }));
    const std::set<TileAddress> found(tiles->begin(), tiles->end());
    std::set<TileAddress> seen;
    for (int i = 0; i < 20000; ++i) {
      const Vec2 p{random.uniform(0, 1000), random.uniform(8900, 10000)};
      const TileAddress tile{static_cast<std::int64_t>(p.x / 10), static_cast<std::int64_t>((10000 - p.y) / 20)};
      if (!contains(area, p)) continue;
      EXPECT_TRUE(found.contains(tile));
      seen.insert(tile);
    }
    EXPECT_GT(static_cast<double>(seen.size()), 0.6 * static_cast<double>(found.size()));  // rims are thin
  }
}

TEST(TileMatrix, areas_beyond_the_grid_and_too_many_tiles) {
  const TileMatrix m{"a", 1.0, 0.0, 100.0, 10, 10, 10, 10};
  EXPECT_EQ(tiles_over(m, {{{-1000, -1000}, {1000, -1000}, {1000, 1000}, {-1000, 1000}}, {}}, 1000)->size(), 100U);
  EXPECT_EQ(tiles_over(m, {{{200, 0}, {300, 0}, {300, 50}}, {}}, 1000)->size(), 0U);
  EXPECT_FALSE(tiles_over(m, {{{0, 0}, {100, 0}, {100, 100}, {0, 100}}, {}}, 99));
  const TileMatrix huge{"h", 1e-9, 0.0, 1e9, 1, 1, std::int64_t{1} << 40, std::int64_t{1} << 40};
  EXPECT_FALSE(tiles_over(huge, {{{0, 0}, {1e9, 0}, {1e9, 1e9}}, {}}, 1000));
}

TEST(TileMatrix, zoom_is_the_coarsest_that_is_fine_enough) {
  const TileMatrixSet set = web_mercator_quad(3, 20);
  EXPECT_EQ(set.matrices[fine_enough(set, 0.6)].identifier, "18");  // 0.597 m
  EXPECT_EQ(set.matrices[fine_enough(set, 0.59)].identifier, "19");
  EXPECT_EQ(set.matrices[fine_enough(set, 0.001)].identifier, "20");  // none is: the finest
  EXPECT_EQ(set.matrices[fine_enough(set, 1e9)].identifier, "3");
  EXPECT_EQ(set.matrices[fine_enough(set, 0.59716 - 1e-5)].identifier, "18");  // a rounded number
}

TEST(TileMatrix, quad_is_known_by_its_numbers) {
  EXPECT_EQ(quad_zoom(web_mercator_quad(17, 17).matrices[0]), 17);
  TileMatrix rounded{"17", 1.194328566955879, -20037508.34, 20037508.34, 256, 256, 131072, 131072};
  EXPECT_EQ(quad_zoom(rounded), 17);
  rounded.resolution = 1.2;
  EXPECT_FALSE(quad_zoom(rounded));
  EXPECT_FALSE(quad_zoom({"17", 1.194328566955879, 0.0, 20037508.34, 256, 256, 131072, 131072}));
  EXPECT_FALSE(quad_zoom({"16", 1.194328566955879, -20037508.34, 20037508.34, 512, 512, 65536, 65536}));
}

TEST(AreaIn, tells_what_cannot_be_fetched) {
  EXPECT_NE(message_of<InputError>([] {
              (void)area_in({utm33, {}}, utm33, 10.0, "a.mbtiles");
            }).find("a.mbtiles: the area of the site is empty"),
            std::string::npos);
  const SiteFrame wide{{"EPSG:32660"},
                       {{{833000, 5540000}, {836000, 5540000}, {836000, 5541000}, {833000, 5541000}}, {}}};
  const CoordinateTransform lonlat({"EPSG:32660"}, {"EPSG:4326"});
  ASSERT_LT(lonlat.target_from_source({836000, 5540000}).x * lonlat.target_from_source({700000, 5540000}).x, 0.0);
  const SiteFrame across{{"EPSG:32660"},
                         {{{700000, 5540000}, {836000, 5540000}, {836000, 5541000}, {700000, 5541000}}, {}}};
  EXPECT_NE(message_of<InputError>([&] { (void)lonlat_box(across, 0.0, "a"); }).find("antimeridian"),
            std::string::npos);
  const SiteFrame polar{{"EPSG:3995"}, {{{0, -400000}, {1000, -400000}, {1000, -399000}, {0, -399000}}, {}}};
  EXPECT_NE(
      message_of<InputError>([&] { (void)area_in(polar, {"EPSG:3857"}, 0.0, "a"); }).find("web mercator ends at 85.05"),
      std::string::npos);
  const Box2 box = lonlat_box(site_of(1000.0), 100.0, "a");
  const Box2 inner = lonlat_box(site_of(1000.0), 0.0, "a");
  EXPECT_NEAR((inner.min_y - box.min_y) * 111200.0, 100.0, 1.0);
}

}  // namespace
}  // namespace orthodrive::remote

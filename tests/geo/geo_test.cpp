// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/geo/simplify.hpp"

namespace orthodrive {
namespace {

TEST(Polygon, area_and_containment_far_from_the_origin) {
  const Vec2 o{500000.0, 6400000.0};  // UTM size: single products would lose centimetres
  const Polygon p{{o, o + Vec2{10, 0}, o + Vec2{10, 10}, o + Vec2{0, 10}},
                  {{o + Vec2{4, 4}, o + Vec2{4, 6}, o + Vec2{6, 6}, o + Vec2{6, 4}}}};
  EXPECT_DOUBLE_EQ(area_m2(p), 96.0);
  EXPECT_TRUE(contains(p, o + Vec2{1, 1}));
  EXPECT_FALSE(contains(p, o + Vec2{5, 5}));
  EXPECT_FALSE(contains(p, o + Vec2{11, 5}));
}

TEST(Polygon, rasterize_agrees_with_containment_of_pixel_centres) {
  const Polygon p{{{1.2, 0.7}, {17.3, 3.1}, {12.9, 18.8}, {8.0, 7.0}, {0.4, 15.5}}, {{{5, 4}, {9, 4.5}, {7, 6}}}};
  const GridFrame frame{0.0, 20.0, 0.5, 40, 40};
  Raster<int> filled(40, 40);
  fill_polygon(filled, frame, p, 1);
  int inside = 0;
  for (int row = 0; row < 40; ++row)
    for (int col = 0; col < 40; ++col) {
      ASSERT_EQ(filled.at(col, row) == 1, contains(p, frame.center_of(col, row))) << col << "," << row;
      inside += filled.at(col, row);
    }
  EXPECT_NEAR(inside * 0.25, area_m2(p), 3.0);
}

TEST(Polygon, two_polygons_with_a_common_edge_fill_every_pixel_once) {
  const GridFrame frame{0.0, 8.0, 1.0, 8, 8};
  Raster<int> count(8, 8);
  for (const Polygon& p :
       {Polygon{{{0.5, 0}, {4.5, 0}, {3.5, 8}, {0.5, 8}}, {}}, Polygon{{{4.5, 0}, {8, 0}, {8, 8}, {3.5, 8}}, {}}})
    rasterize(p, frame, [&](int row, int b, int e) {
      for (int c = b; c < e; ++c) ++count.at(c, row);
    });
  for (const int n : count.data) EXPECT_LE(n, 1);
}

TEST(Polyline, offset_is_positive_to_the_left) {
  const Polyline line{{0, 0}, {10, 0}, {20, 0}};
  const LineProjection hit = project_onto(line, {12, 3});
  EXPECT_DOUBLE_EQ(hit.s_m, 12.0);
  EXPECT_DOUBLE_EQ(hit.offset_m, 3.0);
  EXPECT_EQ(hit.segment, 1u);
}

TEST(Polyline, tangents_survive_repeated_points) {
  const Polyline line{{0, 0}, {0, 0}, {5, 0}, {5, 0}, {5, 5}};
  for (const Vec2 t : tangents(line)) EXPECT_NEAR(length(t), 1.0, 1e-12);
}

TEST(Polyline, a_mitre_is_as_far_out_as_both_lines) {
  const Vec2 north{0.0, 1.0}, east{1.0, 0.0};
  const Vec2 corner = mitre(north, east);
  EXPECT_NEAR(dot(corner, north), 1.0, 1e-12);
  EXPECT_NEAR(dot(corner, east), 1.0, 1e-12);
  EXPECT_NEAR(distance(mitre(north, north), north), 0.0, 1e-12);
}

TEST(Polyline, a_mitre_is_blunt_where_a_line_turns_back) {
  const Vec2 north{0.0, 1.0};
  for (const double degrees : {121.0, 150.0, 180.0}) {
    const double turn = degrees * std::numbers::pi / 180.0;
    EXPECT_EQ(mitre(north, {std::sin(turn), std::cos(turn)}), north) << degrees;
  }
}

TEST(Crs, utm_round_trip_and_axis_order) {
  const Crs utm = utm_crs(15.75, 50.03);
  EXPECT_EQ(utm.definition, "EPSG:32633");
  const CoordinateTransform t(Crs{"EPSG:4326"}, utm);
  const Vec2 p = t.target_from_source({15.0, 50.0});  // on the central meridian: easting is exactly 500 km
  EXPECT_NEAR(p.x, 500000.0, 1e-6);
  EXPECT_GT(p.y, 5.5e6);
  const Vec2 back = t.source_from_target(p);
  EXPECT_NEAR(back.x, 15.0, 1e-10);
  EXPECT_NEAR(back.y, 50.0, 1e-10);
}

TEST(Crs, places_come_back_from_ecef) {
  for (const double lat : {-90.0, -60.0, 0.0, 37.7, 89.999})
    for (const double lon : {-179.0, -122.4, 0.0, 15.0})
      for (const double height : {-400.0, 0.0, 30.0, 9000.0, 100'000.0}) {
        const Vec3 back = geographic_from_ecef(ecef_from_geographic(lon, lat, height));
        if (std::abs(lat) < 90.0) {
          EXPECT_NEAR(back.x, lon, 1e-9);
        }
        EXPECT_NEAR(back.y, lat, 1e-9);
        EXPECT_NEAR(back.z, height, 1e-4);
      }
}

TEST(Crs, ecef_of_known_places) {
  const Vec3 equator = ecef_from_geographic(0.0, 0.0, 0.0), pole = ecef_from_geographic(0.0, 90.0, 10.0);
  EXPECT_NEAR(equator.x, 6378137.0, 1e-6);
  EXPECT_NEAR(pole.z, 6356752.314245 + 10.0, 1e-4);  // WGS84 semi-minor axis
}

TEST(Polyline, simplify_keeps_corners_and_drops_what_the_tolerance_allows) {
  const Polyline line{{0, 0}, {5, 0.3}, {10, -0.3}, {20, 0}, {20, 10}, {20.4, 15}, {20, 20}};
  EXPECT_EQ(simplify(line, 0.5), (std::vector{true, false, false, true, false, false, true}));
  EXPECT_EQ(simplify(line, 0.1), (std::vector{true, true, true, true, true, true, true}));
  EXPECT_TRUE(simplify({}, 0.5).empty());
}

TEST(Polyline, no_dropped_point_is_farther_than_the_tolerance) {
  Random random(5);
  Polyline line;
  for (int i = 0; i < 200; ++i) line.push_back({static_cast<double>(i), 3.0 * random.uniform()});
  const auto stays = simplify(line, 1.0);
  Polyline kept;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (stays[i]) kept.push_back(line[i]);
  EXPECT_LT(kept.size(), line.size());
  for (const Vec2 p : line) EXPECT_LE(project_onto(kept, p).distance_m, 1.0 + 1e-9);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/pipeline/sources/map_labels.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "orthodrive/io/support/vector_io.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;

constexpr ClassSet ground = only(0), road = only(1), parking = only(2), building = only(3), grass = only(5),
                   water = only(6), no_road = 0xff & ~road;
const Vec2 map_origin{460000.0, 5270000.0};

RoadPath street(const std::string& highway, double y_m, double width_m) {
  RoadPath path{.osm_id = static_cast<std::int64_t>(y_m), .highway = highway};
  for (const double x : {-50.0, 150.0}) path.nodes.push_back({.p = map_origin + Vec2{x, y_m}, .width_m = width_m});
  return path;
}

io::Feature square(double x, double y, double size_m, std::map<std::string, std::string> tags) {
  const Vec2 a = map_origin + Vec2{x, y};
  return {.polygons = {{{a, a + Vec2{size_m, 0}, a + Vec2{size_m, size_m}, a + Vec2{0, size_m}}, {}}},
          .tags = std::move(tags)};
}

TEST(MapLabels, say_what_the_map_knows_and_nothing_where_it_is_vague) {
  const fs::path file = fs::temp_directory_path() / "orthodrive_map_labels.geojson";
  const Crs crs{"EPSG:32633"};
  io::write_geojson(file,
                    {square(10, 70, 20, {{"building", "yes"}}), square(50, 70, 20, {{"natural", "water"}}),
                     square(75, 70, 20, {{"building", "roof"}})},
                    crs);
  RoadNetwork roads{.crs = crs};
  roads.paths = {street("residential", 10, 6), street("service", 30, 4), street("track", 50, 3),
                 street("primary", 100, 8)};
  roads.paths.back().tunnel = true;
  const SiteFrame site{
      crs, {{map_origin, map_origin + Vec2{100, 0}, map_origin + Vec2{100, 120}, map_origin + Vec2{0, 120}}}};
  const WeakLabels labels = map_labels(roads, {file}, {file}, site, default_class_table());
  const GridFrame frame{map_origin.x, map_origin.y + 120.0, 0.5, 200, 240};
  const Raster<ClassSet> all = labels(frame, MapEdges::vague);
  const auto at = [&](double x, double y) {
    const Vec2 p = frame.pixel_from_world(map_origin + Vec2{x, y});
    return all.at(static_cast<int>(p.x), static_cast<int>(p.y));
  };
  EXPECT_EQ(at(40.2, 10.2), road);
  EXPECT_EQ(at(40.2, 10.7), road);
  EXPECT_EQ(at(40.2, 11.3), unknown_class) << "inside, near the edge";
  EXPECT_EQ(at(40.2, 14.7), unknown_class) << "outside, within the band";
  EXPECT_EQ(at(40.2, 15.3), no_road);
  EXPECT_EQ(at(40.2, 30.2), road | parking);
  EXPECT_EQ(at(40.2, 50.2), road | ground | grass);
  EXPECT_EQ(at(20.2, 80.2), building);
  EXPECT_EQ(at(9.2, 80.2), unknown_class);
  EXPECT_EQ(at(60.2, 80.2), water);
  EXPECT_EQ(at(85.2, 80.2), unknown_class) << "a roof on posts may stand over anything";
  EXPECT_EQ(at(40.2, 100.2), no_road) << "no photo shows a tunnel";

  const Raster<ClassSet> sharp = labels(frame, MapEdges::sharp);
  const auto row_of = [&](double y) { return static_cast<int>(frame.pixel_from_world(map_origin + Vec2{0.0, y}).y); };
  EXPECT_EQ(sharp.at(80, row_of(12.7)), road);
  EXPECT_EQ(sharp.at(80, row_of(13.3)), no_road);

  const GridFrame part{frame.west_m, frame.north_m, frame.gsd_m, 40, 50, 70, 190};
  const Raster<ClassSet> window = labels(part, MapEdges::vague);
  for (int row = 0; row < 50; ++row)
    for (int col = 0; col < 40; ++col) ASSERT_EQ(window.at(col, row), all.at(70 + col, 190 + row)) << col << " " << row;
  fs::remove(file);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// Trees out of OSM and GeoJSON.

#include "orthodrive/io/vector/tree_reader.hpp"

#include <gtest/gtest.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {

std::vector<Vec2> read_crowns(const std::vector<io::Feature>& features) {
  const Scratch scratch;
  io::write_geojson(scratch / "t.geojson", features, utm33);
  return io::read_trees({scratch / "t.geojson"}, site_of(1000.0));
}

TEST(TreeReader, takes_points_with_natural_tree_and_points_without_tags) {
  const auto trees =
      read_crowns({{.points = {origin + Vec2{10, 20}}, .tags = {{"natural", "tree"}, {"name", "Lípa 木"}}},
                   {.points = {origin + Vec2{30, 20}}},
                   {.points = {origin + Vec2{50, 20}}, .tags = {{"natural", "peak"}}},
                   {.points = {origin + Vec2{-10, 20}}, .tags = {{"natural", "tree"}}},
                   {.polygons = {rectangle(origin.x, origin.y, origin.x + 9, origin.y + 9)}}});
  ASSERT_EQ(trees.size(), 2U);
  EXPECT_LT(distance(trees[0], origin + Vec2{10, 20}), 0.02);
  EXPECT_LT(distance(trees[1], origin + Vec2{30, 20}), 0.02);
}

TEST(TreeReader, rows_have_a_tree_every_8_m_also_round_corners) {
  const auto trees = read_crowns(
      {{.lines = {{origin + Vec2{10, 10}, origin + Vec2{30, 10}, origin + Vec2{30, 10}, origin + Vec2{30, 40}}},
        .tags = {{"natural", "tree_row"}}},
       {.lines = {{origin, origin + Vec2{90, 0}}}, .tags = {{"natural", "cliff"}}}});
  ASSERT_EQ(trees.size(), 7U);  // 0, 8 ... 48 of 50 m
  EXPECT_LT(distance(trees[2], origin + Vec2{26, 10}), 0.05);
  EXPECT_LT(distance(trees[3], origin + Vec2{30, 14}), 0.05);
}

TEST(TreeReader, takes_nodes_and_ways_of_osm) {
  const Scratch scratch;
  write_bytes(scratch / "a.osm", R"(<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6">
  <node id="1" lat="50.0000" lon="15.0000"/><node id="2" lat="50.0010" lon="15.0000"/>
  <node id="3" lat="50.0005" lon="15.0005"><tag k="natural" v="tree"/></node>
  <node id="4" lat="50.0005" lon="15.0006"><tag k="highway" v="crossing"/></node>
  <way id="10"><nd ref="1"/><nd ref="2"/><tag k="natural" v="tree_row"/></way>
</osm>
)");
  EXPECT_EQ(io::read_trees({scratch / "a.osm"}, lonlat_site(14.99, 49.99, 15.01, 50.01)).size(), 1U + 14U);
}

TEST(TreeReader, files_that_cannot_be_read_are_errors) {
  const Scratch scratch;
  EXPECT_THROW((void)io::read_trees({scratch / "none.osm"}, site_of(100.0)), InputError);
  write_bytes(scratch / "text.geojson", "trees");
  EXPECT_THROW((void)io::read_trees({scratch / "text.geojson"}, site_of(100.0)), InputError);
  EXPECT_TRUE(io::read_trees({}, site_of(100.0)).empty());
}

}  // namespace
}  // namespace orthodrive

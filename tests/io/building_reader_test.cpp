// SPDX-License-Identifier: Apache-2.0
// Buildings out of OSM and GeoJSON.

#include "orthodrive/io/vector/building_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {

io::Feature box(double east_m, std::map<std::string, std::string> tags) {
  return {.polygons = {rectangle(origin.x + east_m, origin.y, origin.x + east_m + 10, origin.y + 10)},
          .tags = std::move(tags)};
}

std::vector<Building> read_houses(const std::vector<io::Feature>& features, Findings* findings = nullptr) {
  const Scratch scratch;
  io::write_geojson(scratch / "b.geojson", features, utm33);
  return io::read_buildings({scratch / "b.geojson"}, site_of(1000.0), findings);
}

TEST(BuildingReader, takes_tags_of_osm_and_short_keys) {
  const auto buildings =
      read_houses({box(0, {{"building", "house"}, {"height", "7.5 m"}, {"roof:shape", "hipped"}}),
                   box(20, {{"building", "škola"}, {"name", "Základní škola 学校"}, {"building:levels", "3"}}),
                   box(40, {{"t", "commercial"}, {"h", "7"}, {"lv", "2"}, {"n", "Forum"}})});
  ASSERT_EQ(buildings.size(), 3U);
  EXPECT_EQ(buildings[0].use, "house");
  EXPECT_EQ(buildings[0].height_m, 7.5);
  EXPECT_EQ(buildings[0].levels, 0.0);
  EXPECT_EQ(buildings[0].roof_shape, "hipped");
  EXPECT_NEAR(area_m2(buildings[0].footprint), 100.0, 0.1);
  EXPECT_NEAR(buildings[0].footprint.outer.front().x, origin.x, 10.1);
  EXPECT_EQ(buildings[1].use, "škola");
  EXPECT_EQ(buildings[1].levels, 3.0);
  EXPECT_EQ(buildings[2].use, "commercial");
  EXPECT_EQ(buildings[2].height_m, 7.0);
  EXPECT_EQ(buildings[2].levels, 2.0);
}

TEST(BuildingReader, takes_colours_by_hex_name_and_material) {
  const auto buildings =
      read_houses({box(0, {{"building", "yes"}, {"building:colour", "#Ff0000"}, {"roof:colour", "#fff"}}),
                   box(20, {{"building", "yes"}, {"building:colour", "Light_Grey"}}),
                   box(40, {{"building", "yes"}, {"building:colour", "reddish"}, {"roof:colour", "#12345"}}),
                   box(60, {{"building", "yes"}, {"building:material", "brick"}}),
                   box(80, {{"building", "yes"}, {"building:material", "plaster"}})});
  ASSERT_EQ(buildings.size(), 5U);
  using Color = std::array<float, 3>;
  EXPECT_EQ(buildings[0].wall_color, (Color{1.0F, 0.0F, 0.0F}));
  EXPECT_EQ(buildings[0].roof_color, (Color{1.0F, 1.0F, 1.0F}));
  ASSERT_TRUE(buildings[1].wall_color);
  EXPECT_NEAR((*buildings[1].wall_color)[0], 0.6514F, 1e-3F) << "211 / 255 in sRGB";
  EXPECT_FALSE(buildings[2].wall_color || buildings[2].roof_color) << "no colour is better than a wrong one";
  ASSERT_TRUE(buildings[3].wall_color);
  EXPECT_GT((*buildings[3].wall_color)[0], (*buildings[3].wall_color)[2]);
  EXPECT_FALSE(buildings[4].wall_color);
}

TEST(BuildingReader, passes_over_what_is_no_building_here) {
  const auto buildings = read_houses({box(0, {{"building", "no"}}),
                                      box(40, {{"landuse", "grass"}}),
                                      box(60, {{"building", ""}}),
                                      box(-500, {{"building", "yes"}}),
                                      box(-5, {{"building", "yes"}}),
                                      {.lines = {{origin, origin + Vec2{10, 3}}}, .tags = {{"building", "yes"}}},
                                      {.points = {origin}, .tags = {{"building", "yes"}}}});
  ASSERT_EQ(buildings.size(), 1U) << "the one that reaches into the area";
}

TEST(BuildingReader, takes_parts_roofs_and_what_has_no_walls) {
  const auto buildings =
      read_houses({box(0, {{"building:part", "yes"}, {"height", "20"}, {"min_height", "8"}}),
                   box(20, {{"building:part", "tower"}, {"building:levels", "6"}, {"building:min_level", "2"}}),
                   box(40, {{"building", "roof"}}),
                   box(60, {{"building", "church"},
                            {"roof:shape", "skillion"},
                            {"roof:height", "4"},
                            {"roof:direction", "SE"},
                            {"roof:angle", "30"},
                            {"roof:levels", "1"},
                            {"roof:orientation", "across"},
                            {"roof:material", "copper"}}),
                   box(80, {{"building:part", "no"}}),
                   box(100, {{"building", "yes"}, {"building:part", "yes"}, {"roof:direction", "270"}})});
  ASSERT_EQ(buildings.size(), 5U);
  EXPECT_TRUE(buildings[0].is_part && buildings[1].is_part);
  EXPECT_EQ(buildings[0].min_height_m, 8.0);
  EXPECT_EQ(buildings[1].min_height_m, 6.0);
  EXPECT_EQ(buildings[1].use, "tower");
  EXPECT_FALSE(buildings[2].has_walls);
  const Building& church = buildings[3];
  EXPECT_EQ(church.roof_height_m, 4.0);
  EXPECT_EQ(church.roof_levels, 1.0);
  EXPECT_NEAR(church.roof_angle_rad, 0.5236, 1e-4);
  EXPECT_NEAR(church.roof_direction_rad.value(), -0.7854, 1e-4) << "south-east";
  EXPECT_TRUE(church.ridge_across);
  EXPECT_TRUE(church.roof_color) << "copper is green";
  EXPECT_FALSE(buildings[4].is_part) << "a building that is its own part";
  EXPECT_NEAR(std::cos(buildings[4].roof_direction_rad.value()), -1.0, 1e-9) << "west";
}

TEST(BuildingReader, heights_that_contradict_each_other_are_told) {
  Findings findings;
  const auto buildings = read_houses({box(0, {{"building:part", "yes"}, {"height", "9"}, {"min_height", "12"}}),
                                      box(20, {{"building", "yes"}, {"height", "6"}, {"roof:height", "8"}}),
                                      box(40, {{"building", "yes"}, {"roof:angle", "120"}}),
                                      box(60, {{"building:part", "yes"}, {"min_height", "0"}, {"height", "9"}}),
                                      box(80, {{"building", "yes"}, {"roof:direction", "down"}})},
                                     &findings);
  ASSERT_EQ(buildings.size(), 5U);
  EXPECT_EQ(buildings[0].min_height_m, 0.0);
  EXPECT_EQ(buildings[1].roof_height_m, 0.0);
  EXPECT_EQ(buildings[2].roof_angle_rad, 0.0);
  EXPECT_FALSE(buildings[4].roof_direction_rad);
  ASSERT_EQ(findings.size(), 3U);
  for (const Finding& finding : findings) EXPECT_EQ(finding.code, "buildings.odd_height");
  EXPECT_EQ(findings[0].message, "a building that begins at 12.0 m and ends at 9.0 m begins at the ground");
  EXPECT_EQ(findings[1].message, "a roof of 8.0 m on a building of 6.0 m does not count");
}

TEST(BuildingReader, odd_heights_do_not_count_and_are_told) {
  Findings findings;
  const auto buildings = read_houses(
      {box(0, {{"building", "yes"}, {"height", "-5"}}), box(20, {{"building", "yes"}, {"building:levels", "900"}}),
       box(40, {{"building", "yes"}, {"height", "high"}, {"building:levels", "2"}}),
       box(60, {{"building", "yes"}, {"height", "1e300"}}), box(80, {{"building", "yes"}, {"height", "nan"}})},
      &findings);
  ASSERT_EQ(buildings.size(), 5U);
  for (const Building& building : buildings) EXPECT_EQ(building.height_m, 0.0);
  EXPECT_EQ(buildings[1].levels, 0.0);
  EXPECT_EQ(buildings[2].levels, 2.0);
  ASSERT_EQ(findings.size(), 5U);
  for (const Finding& finding : findings) EXPECT_EQ(finding.code, "buildings.odd_height");
  EXPECT_EQ(findings[1].message, "a building's levels '900' is no number up to 150 and does not count");
  EXPECT_NEAR(findings[1].x_m, origin.x + 20, 11.0);
}

TEST(BuildingReader, takes_ways_and_multipolygons_of_osm) {
  const Scratch scratch;
  write_bytes(scratch / "a.osm", R"(<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6">
  <node id="1" lat="50.0000" lon="15.0000"/><node id="2" lat="50.0000" lon="15.0010"/>
  <node id="3" lat="50.0010" lon="15.0010"/><node id="4" lat="50.0010" lon="15.0000"/>
  <node id="5" lat="50.0003" lon="15.0003"/><node id="6" lat="50.0003" lon="15.0007"/>
  <node id="7" lat="50.0007" lon="15.0007"/><node id="8" lat="50.0007" lon="15.0003"/>
  <node id="9" lat="50.0000" lon="15.0020"/>
  <way id="10"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/></way>
  <way id="11"><nd ref="5"/><nd ref="6"/><nd ref="7"/><nd ref="8"/><nd ref="5"/></way>
  <way id="12"><nd ref="2"/><nd ref="9"/><nd ref="3"/><nd ref="2"/><tag k="building" v="yes"/></way>
  <way id="13"><nd ref="2"/><nd ref="9"/><tag k="highway" v="service"/></way>
  <relation id="20">
    <member type="way" ref="10" role="outer"/><member type="way" ref="11" role="inner"/>
    <tag k="type" v="multipolygon"/><tag k="building" v="apartments"/><tag k="building:levels" v="5"/>
  </relation>
</osm>
)");
  const auto buildings = io::read_buildings({scratch / "a.osm"}, lonlat_site(14.99, 49.99, 15.01, 50.01));
  ASSERT_EQ(buildings.size(), 2U);
  const Building& block = buildings[buildings[0].use == "apartments" ? 0 : 1];
  EXPECT_EQ(block.levels, 5.0);
  EXPECT_EQ(block.footprint.holes.size(), 1U);
}

TEST(BuildingReader, files_that_cannot_be_read_are_errors) {
  const Scratch scratch;
  EXPECT_THROW((void)io::read_buildings({scratch / "none.osm"}, site_of(100.0)), InputError);
  EXPECT_THROW((void)io::read_buildings({scratch / "none.geojson"}, site_of(100.0)), InputError);
  write_bytes(scratch / "text.geojson", "buildings");
  EXPECT_THROW((void)io::read_buildings({scratch / "text.geojson"}, site_of(100.0)), InputError);
  EXPECT_TRUE(io::read_buildings({}, site_of(100.0)).empty());
}

}  // namespace
}  // namespace orthodrive

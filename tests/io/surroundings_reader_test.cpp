// SPDX-License-Identifier: Apache-2.0
// Barriers, water, railways and lamps out of OSM and GeoJSON.

#include "orthodrive/io/vector/surroundings_reader.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {

MapSurroundings read(const std::vector<io::Feature>& features, Findings* findings = nullptr) {
  const Scratch scratch;
  io::write_geojson(scratch / "s.geojson", features, utm33);
  return io::read_surroundings({scratch / "s.geojson"}, site_of(1000.0), findings);
}

io::Feature line(std::map<std::string, std::string> tags, Vec2 from = {10, 10}) {
  return {.lines = {{origin + from, origin + from + Vec2{30, 0}}}, .tags = std::move(tags)};
}

io::Feature area(std::map<std::string, std::string> tags, double west = 100.0) {
  return {.polygons = {rectangle(origin.x + west, origin.y, origin.x + west + 50, origin.y + 50)},
          .tags = std::move(tags)};
}

TEST(SurroundingsReader, takes_barriers_with_their_heights) {
  Findings findings;
  const MapSurroundings got =
      read({line({{"barrier", "hedge"}, {"height", "2.5"}}), line({{"barrier", "retaining_wall"}}),
            line({{"barrier", "fence"}, {"height", "-3"}}),
            line({{"barrier", "wall"}, {"height", "high"}, {"name", "Mauer 墙"}}), line({{"barrier", "guard_rail"}}),
            line({{"barrier", "kerb"}}), line({{"barrier", "wall"}}, {-5000, 0})},
           &findings);
  ASSERT_EQ(got.barriers.size(), 5U);
  EXPECT_EQ(got.barriers[0].kind, BarrierKind::hedge);
  EXPECT_EQ(got.barriers[0].height_m, 2.5);
  EXPECT_EQ(got.barriers[1].kind, BarrierKind::wall);
  EXPECT_EQ(got.barriers[2].kind, BarrierKind::fence);
  EXPECT_EQ(got.barriers[2].height_m, 0.0);
  EXPECT_EQ(got.barriers[3].height_m, 0.0);
  EXPECT_EQ(got.barriers[4].kind, BarrierKind::guard_rail);
  ASSERT_EQ(findings.size(), 2U);
  EXPECT_EQ(findings[0].code, "surroundings.odd_height");
}

TEST(SurroundingsReader, takes_water_and_polygons_without_tags) {
  const MapSurroundings got =
      read({area({{"natural", "water"}}), area({}), area({{"t", "water"}}), area({{"landuse", "basin"}}),
            area({{"landuse", "forest"}}), area({{"natural", "water"}}, 5000.0),
            area({{"natural", "water"}, {"tunnel", "yes"}})});
  EXPECT_EQ(got.water.size(), 4U);
}

TEST(SurroundingsReader, takes_paths_with_widths_and_surfaces) {
  const MapSurroundings got =
      read({line({{"highway", "footway"}}), line({{"highway", "cycleway"}, {"width", "3.5"}}),
            line({{"highway", "path"}}), line({{"highway", "path"}, {"surface", "setts"}}),
            line({{"highway", "footway"}, {"footway", "crossing"}}), line({{"highway", "footway"}, {"bridge", "yes"}}),
            line({{"highway", "footway"}, {"layer", "-1"}}), line({{"highway", "residential"}}),
            line({{"highway", "steps"}, {"width", "wide"}}), line({{"highway", "footway"}}, {-5000, 0})});
  ASSERT_EQ(got.paths.size(), 5U);
  EXPECT_EQ(got.paths[0].width_m, 2.0);
  EXPECT_EQ(got.paths[0].surface, roadquery::SurfaceClass::asphalt);
  EXPECT_EQ(got.paths[1].width_m, 3.5);
  EXPECT_EQ(got.paths[2].surface, roadquery::SurfaceClass::ground);
  EXPECT_EQ(got.paths[3].surface, roadquery::SurfaceClass::setts);
  EXPECT_EQ(got.paths[4].width_m, 1.5);
}

TEST(SurroundingsReader, takes_car_parks_on_the_ground) {
  const MapSurroundings got =
      read({area({{"amenity", "parking"}}), area({{"amenity", "parking"}, {"parking", "surface"}}),
            area({{"amenity", "parking"}, {"parking", "underground"}}),
            area({{"amenity", "parking"}, {"building", "parking"}}), area({{"t", "parking"}}), area({{"t", "plaza"}}),
            area({{"amenity", "parking"}}, 5000.0)});
  EXPECT_EQ(got.parking.size(), 3U);
  EXPECT_TRUE(got.water.empty());
}

TEST(SurroundingsReader, takes_railways_on_the_ground) {
  const MapSurroundings got = read({line({{"railway", "rail"}}), line({{"railway", "tram"}}), line({{"t", "rail"}}),
                                    line({{"railway", "rail"}, {"bridge", "yes"}}),
                                    line({{"railway", "rail"}, {"tunnel", "yes"}}), line({{"t", "rail"}, {"br", "1"}}),
                                    line({{"railway", "abandoned"}}), line({{"railway", "rail"}, {"bridge", "no"}})});
  EXPECT_EQ(got.tracks.size(), 4U);
}

io::Feature point(std::map<std::string, std::string> tags, Vec2 at = {20, 20}) {
  return {.points = {origin + at}, .tags = std::move(tags)};
}

TEST(SurroundingsReader, takes_objects_by_their_tags) {
  Findings findings;
  const MapSurroundings got =
      read({point({{"highway", "traffic_signals"}}), point({{"highway", "bus_stop"}, {"shelter", "yes"}}),
            point({{"highway", "bus_stop"}}), point({{"traffic_sign", "DE:274-30"}}),
            point({{"traffic_sign", "city_limit"}}), point({{"traffic_sign", "XX:1"}}), point({{"amenity", "bench"}}),
            point({{"amenity", "pub"}}), point({{"man_made", "chimney"}, {"height", "80"}, {"diameter", "4"}}),
            point({{"man_made", "mast"}, {"height", "4000"}}), point({{"emergency", "fire_hydrant"}}, {-900, 0}),
            area({{"man_made", "storage_tank"}})},
           &findings);
  const std::vector<ObjectKind> kinds = {ObjectKind::traffic_signals, ObjectKind::bus_shelter, ObjectKind::bus_stop,
                                         ObjectKind::speed_sign,      ObjectKind::city_sign,   ObjectKind::other_sign,
                                         ObjectKind::bench,           ObjectKind::chimney,     ObjectKind::mast,
                                         ObjectKind::storage_tank};
  ASSERT_EQ(got.objects.size(), kinds.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) EXPECT_EQ(got.objects[i].kind, kinds[i]) << i;
  EXPECT_EQ(got.objects[7].height_m, 80.0);
  EXPECT_EQ(got.objects[7].radius_m, 2.0);
  EXPECT_EQ(got.objects[8].height_m, 0.0);
  EXPECT_NEAR(got.objects[9].radius_m, std::sqrt(2500.0 / 3.14159265), 1e-3);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].code, "surroundings.odd_height");
}

TEST(SurroundingsReader, takes_power_lines) {
  const MapSurroundings got = read({line({{"power", "line"}}), line({{"power", "minor_line"}}),
                                    line({{"power", "cable"}}), line({{"power", "line"}}, {-5000, 0})});
  ASSERT_EQ(got.power_lines.size(), 2U);
  EXPECT_FALSE(got.power_lines[0].is_minor);
  EXPECT_TRUE(got.power_lines[1].is_minor);
}

TEST(SurroundingsReader, takes_nodes_and_ways_of_osm) {
  const Scratch scratch;
  write_bytes(scratch / "a.osm", R"(<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6">
  <node id="1" lat="50.0000" lon="15.0000"/><node id="2" lat="50.0010" lon="15.0000"/>
  <node id="5" lat="50.0010" lon="15.0010"/>
  <node id="3" lat="50.0005" lon="15.0005"><tag k="highway" v="street_lamp"/></node>
  <node id="6" lat="50.0004" lon="15.0005"><tag k="amenity" v="post_box"/></node>
  <node id="7" lat="50.0004" lon="15.0006"><tag k="shop" v="kiosk"/></node>
  <node id="4" lat="50.0005" lon="15.0006"><tag k="natural" v="tree"/></node>
  <way id="10"><nd ref="1"/><nd ref="2"/><nd ref="5"/><nd ref="1"/><tag k="barrier" v="fence"/></way>
  <way id="11"><nd ref="1"/><nd ref="2"/><nd ref="5"/><nd ref="1"/><tag k="natural" v="water"/></way>
</osm>
)");
  const auto got = io::read_surroundings({scratch / "a.osm"}, lonlat_site(14.99, 49.99, 15.01, 50.01));
  EXPECT_EQ(got.lamps.size(), 1U);
  ASSERT_EQ(got.objects.size(), 1U);
  EXPECT_EQ(got.objects[0].kind, ObjectKind::post_box);
  ASSERT_EQ(got.barriers.size(), 1U);
  EXPECT_EQ(got.barriers[0].line.size(), 4U) << "closed";
  EXPECT_EQ(got.water.size(), 1U);
}

TEST(SurroundingsReader, files_that_cannot_be_read_are_errors) {
  const Scratch scratch;
  EXPECT_THROW((void)io::read_surroundings({scratch / "none.osm"}, site_of(100.0)), InputError);
  write_bytes(scratch / "text.geojson", "walls");
  EXPECT_THROW((void)io::read_surroundings({scratch / "text.geojson"}, site_of(100.0)), InputError);
  EXPECT_TRUE(io::read_surroundings({}, site_of(100.0)).barriers.empty());
}

}  // namespace
}  // namespace orthodrive

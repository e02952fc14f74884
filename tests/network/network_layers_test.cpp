// SPDX-License-Identifier: Apache-2.0
// The network as GeoPackage and GeoJSON, read back by OGR.

#include "orthodrive/io/vector/network_layers.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "app/run_tool.hpp"
#include "io/scratch.hpp"
#include "network_support.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "roadquery/make_road.hpp"
#include "roadquery/map/lane_type_name.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;
using roadquery::RoadMap;

RoadMap plain_crossing() {
  const auto height = [](Vec2 p) { return 40.0 + 0.02 * p.x; };
  return build_network(network_of({make_path({{-150, 0}, {0, 0}, {150, 0}}, {1, 2, 3},
                                             {.osm_id = 11, .highway = "primary", .width_m = 8.0, .height = height}),
                                   make_path({{0, -120}, {0, 0}, {0, 120}}, {4, 2, 5},
                                             {.osm_id = 12, .width_m = 6.0, .height = height})}))
      .map;
}

struct Counts {
  int lines = 0, lanes = 0, junctions = 0;
  double lines_m = 0.0, lanes_m2 = 0.0, junctions_m2 = 0.0;
};

/// What the map itself says.
Counts of_map(const RoadMap& map) {
  Counts counts;
  counts.junctions = static_cast<int>(map.junctions.size());
  for (const Road& road : map.roads) {
    ++counts.lines;
    counts.lines_m += road.length;
    for (const auto* side : {&road.sections.at(0).left, &road.sections.at(0).right})
      for (const roadquery::Lane& lane : *side) {
        ++counts.lanes;
        const double t0 = roadquery::lane_width(lane, 0.5 * road.length);
        EXPECT_GT(t0, 0.0);
      }
  }
  return counts;
}

Counts of_features(const std::vector<io::Feature>& features) {
  Counts counts;
  for (const io::Feature& feature : features) {
    if (!feature.lines.empty()) {
      ++counts.lines;
      for (std::size_t i = 1; i < feature.lines[0].size(); ++i)
        counts.lines_m += distance(feature.lines[0][i - 1], feature.lines[0][i]);
    } else if (feature.tags.count("lane")) {
      ++counts.lanes;
      for (const Polygon& polygon : feature.polygons) counts.lanes_m2 += area_m2(polygon);
    } else if (feature.tags.count("connections")) {
      ++counts.junctions;
      counts.junctions_m2 += area_m2(feature.polygons.at(0));
    }
  }
  return counts;
}

TEST(NetworkLayers, both_files_hold_the_network) {
  const Scratch scratch;
  const RoadMap map = plain_crossing();
  const Counts want = of_map(map);
  io::write_network_layers(scratch / "a.gpkg", map);
  io::write_network_geojson(scratch / "a.geojson", map);
  for (const char* name : {"a.gpkg", "a.geojson"}) {
    const std::vector<io::Feature> features = io::read_features(scratch / name, {"EPSG:32633"});
    const Counts got = of_features(features);
    EXPECT_EQ(got.lines, want.lines) << name;
    EXPECT_EQ(got.lanes, want.lanes) << name;
    EXPECT_EQ(got.junctions, 1) << name;
    EXPECT_NEAR(got.lines_m, want.lines_m, 0.002 * want.lines_m) << name;
    for (const io::Feature& feature : features) {
      if (feature.tags.count("lane") && feature.tags.at("junction") == "-1") {
        // Straight lanes of constant width; those of a way make up its area.
        const Road* road = road_by_id(map, std::stoi(feature.tags.at("road")));
        ASSERT_TRUE(road);
        const int id = std::stoi(feature.tags.at("lane"));
        const roadquery::LaneSection& section = road->sections[0];
        double surface_m = 0.0;
        for (const auto* side : {&section.left, &section.right})
          for (const roadquery::Lane& lane : *side) {
            const double width_m = roadquery::lane_width(lane, 0.0);
            surface_m += width_m;
            if (lane.id != id) continue;
            EXPECT_NEAR(area_m2(feature.polygons.at(0)), road->length * width_m, 0.03 * road->length) << name;
            EXPECT_EQ(feature.tags.at("type"), roadquery::lane_type_name(lane.type));
          }
        EXPECT_NEAR(surface_m, feature.tags.at("osm_id") == "11" ? 8.0 : 6.0, 0.01);
      }
      if (feature.tags.count("highway")) {
        EXPECT_NEAR(std::stod(feature.tags.at("length_m")), road_by_id(map, std::stoi(feature.tags.at("road")))->length,
                    1e-3);
      }
    }
  }
}

TEST(NetworkLayers, chords_stay_near_the_curves) {
  const Scratch scratch;
  RoadMap map;
  map.geo_reference = "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs";
  map.roads = {
      roadquery::test::make_road(5, {0.0, 500000.0, 5500000.0, 0.0, 120.0, roadquery::Arc{1.0 / 30.0}}, 7.0, 3.0)};
  io::write_network_layers(scratch / "a.gpkg", map);
  const auto features = io::read_features(scratch / "a.gpkg", {"EPSG:32633"});
  ASSERT_EQ(features.size(), 3u);
  const Vec2 center{500000.0, 5500030.0};
  for (std::size_t i = 1; i < features[0].lines.at(0).size(); ++i) {
    const Vec2 middle = (features[0].lines[0][i - 1] + features[0].lines[0][i]) * 0.5;
    EXPECT_NEAR(distance(middle, center), 30.0, 0.02);
  }
  EXPECT_LT(features[0].lines[0].size(), 80u);
  // Ring sectors: (R^2 - r^2) / 2 * angle.
  EXPECT_NEAR(area_m2(features[1].polygons.at(0)), 0.5 * (30.0 * 30.0 - 27.0 * 27.0) * 4.0, 1.0);
  EXPECT_NEAR(area_m2(features[2].polygons.at(0)), 0.5 * (33.0 * 33.0 - 30.0 * 30.0) * 4.0, 1.0);
}

TEST(NetworkLayers, lanes_that_tight_turns_fold_are_valid_in_both_files) {
  // Turning roads as junctions have them, tighter than they are wide: the union of their cells has slivers of square
  // millimetres.
  const Scratch scratch;
  RoadMap map;
  map.geo_reference = "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs";
  for (int i = 0; i < 60; ++i) {
    const double tightest = 0.25 + 0.01 * i, width = 3.0 + 0.03 * i;
    Road road = roadquery::test::make_road(
        i + 1, {0.0, 500000.0 + 30.0 * i, 5500000.0, 0.1 * i, 4.0, roadquery::Spiral{0.0, tightest}}, 7.0, width);
    roadquery::test::append(road, 4.0, roadquery::Spiral{tightest, 0.0});
    road.superelevation = {{.s = 0.0, .a = 0.03, .b = -0.01}};
    map.roads.push_back(road);
  }
  io::write_network_layers(scratch / "a.gpkg", map);
  io::write_network_geojson(scratch / "a.geojson", map);
  for (const char* name : {"a.gpkg", "a.geojson"}) {
    const std::string geometry = name == std::string("a.gpkg") ? "geom" : "geometry",
                      layer = name == std::string("a.gpkg") ? "lanes" : "a";
    const ToolRun run =
        run_program({"/usr/bin/ogrinfo", "-q", (scratch / name).string(), "-dialect", "sqlite", "-sql",
                     "SELECT COUNT(*) AS n, SUM(NOT ST_IsValid(" + geometry + ")) AS bad FROM " + layer});
    EXPECT_THAT(run.out, ::testing::HasSubstr("bad (Integer) = 0")) << name << run.out;
  }
}

TEST(NetworkLayers, geojson_is_in_degrees_with_rings_counter_clockwise) {
  const Scratch scratch;
  io::write_network_geojson(scratch / "a.geojson", plain_crossing());
  const std::string text = bytes_of(scratch / "a.geojson");
  EXPECT_EQ(text.find("\"crs\""), std::string::npos) << "RFC 7946 has no other CRS";
  EXPECT_NE(text.find("\"layer_name\":\"junctions\""), std::string::npos);
  EXPECT_NE(text.find("\"road\":1"), std::string::npos) << "numbers are numbers";
  for (const io::Feature& feature : io::read_features(scratch / "a.geojson", {"EPSG:4326"})) {
    for (const Polygon& polygon : feature.polygons) {
      EXPECT_GT(signed_area_m2(polygon.outer), 0.0);
      for (const Vec2 p : polygon.outer) {
        EXPECT_NEAR(p.x, 17.5, 1.0);
        EXPECT_NEAR(p.y, 57.7, 0.5);
      }
    }
  }
}

TEST(NetworkLayers, same_network_gives_the_same_bytes_and_none_is_refused_without_a_place) {
  const Scratch scratch;
  RoadMap map = plain_crossing();
  io::write_network_layers(scratch / "a.gpkg", map);
  io::write_network_layers(scratch / "b.gpkg", map);
  EXPECT_EQ(bytes_of(scratch / "a.gpkg"), bytes_of(scratch / "b.gpkg"));
  map.geo_reference.clear();
  EXPECT_THROW(io::write_network_layers(scratch / "c.gpkg", map), InputError);
  EXPECT_THROW(io::write_network_geojson(scratch / "c.geojson", map), InputError);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// What lanes are made of, from the paths to the file and back.

#include <gmock/gmock.h>

#include "io/scratch.hpp"
#include "network/network_support.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "orthodrive/io/opendrive/opendrive_io.hpp"
#include "orthodrive/network/crg/sample_friction.hpp"
#include "orthodrive/network/lanes/lanes.hpp"
#include "roadquery/roads/lane_material.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;

/// A gravel track that ends on a secondary road of asphalt; a street of setts crosses that further on.
RoadNetwork three_surfaces() {
  RoadNetwork roads = network_of({
      make_path({{-120, 0}, {0, 0}, {120, 0}, {240, 0}}, {1, 2, 3, 4}, {.osm_id = 11, .highway = "secondary"}),
      make_path({{0, -100}, {0, 0}}, {5, 2}, {.osm_id = 12, .highway = "track", .width_m = 4.0}),
      make_path({{120, -100}, {120, 0}, {120, 100}}, {6, 3, 7}, {.osm_id = 13}),
  });
  roads.paths[0].sidewalk = Sides::left;
  roads.paths[1].known_surface = {SurfaceClass::gravel, SurfaceSource::highway};
  roads.paths[2].known_surface = {SurfaceClass::setts, SurfaceSource::tag};
  return roads;
}

const roadquery::LaneMaterial& first_material(const roadquery::Lane& lane) { return lane.materials.at(0); }

TEST(Material, lanes_have_the_surface_of_their_way_and_the_friction_of_the_weather) {
  for (const Weather weather : {Weather::dry, Weather::wet}) {
    const roadquery::RoadMap map = build_network(three_surfaces(), {.weather = weather}).map;
    int turning = 0;
    for (const roadquery::Road& road : map.roads)
      for (const roadquery::LaneSection& section : road.sections)
        for (const auto* side : {&section.left, &section.right})
          for (const roadquery::Lane& lane : *side) {
            ASSERT_EQ(lane.materials.size(), 1u) << "every lane says what it is made of";
            const roadquery::LaneMaterial& material = first_material(lane);
            SurfaceClass expected = road.osm_id == "12"   ? SurfaceClass::gravel
                                    : road.osm_id == "13" ? SurfaceClass::setts
                                                          : SurfaceClass::asphalt;
            if (lane.type == roadquery::LaneType::sidewalk) expected = SurfaceClass::concrete;
            EXPECT_EQ(material.surface, expected) << road.id << " of way " << road.osm_id;
            EXPECT_EQ(material.friction, material_of(expected, weather).friction);
            EXPECT_EQ(material.roughness, material_of(expected, weather).roughness_m);
            turning += road.junction >= 0 && road.osm_id.empty() ? 1 : 0;
          }
    EXPECT_GT(turning, 0) << "turning roads have the surface of the larger road";
  }
}

TEST(Material, is_the_same_after_writing_and_reading) {
  const Scratch scratch;
  const roadquery::RoadMap map = build_network(three_surfaces(), {.weather = Weather::wet}).map;
  io::write_opendrive(scratch / "a.xodr", map);
  const roadquery::RoadMap read = roadquery::read_opendrive((scratch / "a.xodr").string());
  ASSERT_EQ(read.roads.size(), map.roads.size());
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const roadquery::LaneSection &a = map.roads[i].sections.at(0), &b = read.roads[i].sections.at(0);
    ASSERT_EQ(a.right.size(), b.right.size());
    for (std::size_t k = 0; k < a.right.size(); ++k) {
      ASSERT_EQ(b.right[k].materials.size(), 1u);
      EXPECT_EQ(first_material(a.right[k]).surface, first_material(b.right[k]).surface);
      EXPECT_EQ(first_material(a.right[k]).friction, first_material(b.right[k]).friction);
      EXPECT_NEAR(first_material(a.right[k]).roughness, first_material(b.right[k]).roughness, 5e-6);
    }
  }
}

TEST(FrictionGrid, two_by_two_values_where_all_lanes_are_alike) {
  roadquery::RoadMap map = build_network(three_surfaces(), {.weather = Weather::wet}).map;
  for (const roadquery::Road& road : map.roads) {
    if (road.osm_id != "13") continue;
    const CrgSurface grid = sample_friction(road);
    EXPECT_EQ(grid.rows(), 2u);
    EXPECT_EQ(grid.columns(), 2u);
    EXPECT_NEAR(grid.u_end_m(), road.length, 1e-9);
    for (const double value : grid.grid_m) EXPECT_EQ(value, 0.5);
    const roadquery::SurfaceCrg reference = friction_reference(road, "a.crg");
    EXPECT_EQ(reference.purpose, "friction");
    EXPECT_EQ(reference.mode, "attached");
    EXPECT_EQ(reference.s_end, road.length);
  }
}

TEST(FrictionGrid, follows_the_lanes_and_the_entries_along_them) {
  const Scratch scratch;
  roadquery::Road road = build_network(three_surfaces()).map.roads.at(0);
  roadquery::Lane& right = road.sections.at(0).right.at(0);
  right.materials = {{.friction = 0.9}, {.s_offset = 20.0, .friction = 0.3}};
  road.sections[0].left.at(0).materials = {{.friction = 0.8}};
  const CrgSurface made = sample_friction(road);
  io::write_crg(scratch / "f.crg", made, CrgFormat::kdbi);
  const CrgSurface grid = io::read_crg(scratch / "f.crg").surface;
  const double half = roadquery::lane_width(right, 0.0);
  int seen = 0;
  for (std::size_t row = 0; row < grid.rows(); ++row)
    for (std::size_t column = 0; column < grid.columns(); ++column) {
      const double s = grid.u_start_m + grid.u_increment_m * static_cast<double>(row), t = grid.v_m[column];
      if (std::abs(t) < 0.01 || std::abs(t) > half - 0.1 || std::abs(s - 20.0) < 0.6) continue;
      EXPECT_NEAR(grid.grid(row, column), t > 0.0 ? 0.8 : s < 20.0 ? 0.9 : 0.3, 1e-9) << s << " " << t;
      ++seen;
    }
  EXPECT_GT(seen, 500);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// What a road is made of, from the OSM tag to the lane under a tyre.

#include <gmock/gmock.h>

#include <map>

#include "app/run_tool.hpp"
#include "io/scratch.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/roads/lane_material.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;
using roadquery::SurfaceClass;

/// The material of the lane under the middle of every node's right half; by the name of the way.
std::map<std::string, std::map<SurfaceClass, double>> frictions_under(const RoadNetwork& roads, const fs::path& xodr) {
  const roadquery::RoadQuery query(roadquery::read_opendrive(xodr.string()));
  std::map<std::string, std::map<SurfaceClass, double>> found;
  for (const RoadPath& path : roads.paths)
    for (std::size_t i = 15; i + 15 < path.nodes.size(); ++i) {  // junctions belong to the larger road
      const RoadNode& node = path.nodes[i];
      const Vec2 right = left_normal(normalized(path.nodes[i + 1].p - node.p)) * (-0.25 * node.width_m);
      roadquery::Cursor cursor;
      const auto hit = query.find(node.p.x + right.x, node.p.y + right.y, 0.0, cursor);
      if (!hit) continue;
      const roadquery::Road& road = query.map().roads[static_cast<std::size_t>(hit->road)];
      if (road.osm_id != std::to_string(path.osm_id)) continue;
      const roadquery::LaneSection& section = roadquery::section_at(road, hit->s);
      for (const auto* side : {&section.left, &section.right})
        for (const roadquery::Lane& lane : *side)
          if (lane.id == hit->lane_id && lane.type == roadquery::LaneType::driving) {
            const roadquery::LaneMaterial material = roadquery::material_at(lane, hit->s - section.s);
            found[path.name][material.surface] = material.friction;
            EXPECT_EQ(hit->surface, material.surface);
            EXPECT_NEAR(hit->friction, material.friction, 1e-6) << "what the tyre gets";
          }
    }
  return found;
}

TEST(SurfaceChain, setts_and_gravel_of_osm_reach_the_lane_under_the_tyre) {
  const Scratch scratch;
  const std::string site = (scratch / "site").string(), roads = (scratch / "roads.gpkg").string();
  ToolRun run = run_tool({"synth", "--size", "500", "--gsd", "0.5", "--seed", "3", "-o", site});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(bytes_of(site + "/roads.osm"), HasSubstr("k=\"surface\" v=\"sett\""));
  run = run_tool({"refine", "--method", "none", "--osm", site + "/roads.osm", "--labels", site + "/truth/labels.tif",
                  "-o", roads});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::map<std::string, SurfaceClass> classes;
  const RoadNetwork network = io::read_roads(roads);
  for (const RoadPath& path : network.paths) classes[path.name] = path.known_surface.surface;
  EXPECT_EQ(classes.at("Kirchgasse"), SurfaceClass::setts);
  EXPECT_EQ(classes.at("Feldweg"), SurfaceClass::gravel);
  EXPECT_EQ(classes.at("Hauptstrasse"), SurfaceClass::asphalt);

  for (const auto& [weather, setts, gravel, asphalt] :
       {std::tuple{"dry", 0.8, 0.7, 1.0}, std::tuple{"wet", 0.5, 0.7, 0.7}}) {
    const fs::path xodr = scratch / (std::string(weather) + ".xodr");
    run = run_tool({"network", "--roads", roads, "-o", xodr.string(), "--weather", weather});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto found = frictions_under(network, xodr);
    using One = std::map<SurfaceClass, double>;
    EXPECT_EQ(found.at("Kirchgasse"), (One{{SurfaceClass::setts, setts}})) << weather;
    EXPECT_EQ(found.at("Feldweg"), (One{{SurfaceClass::gravel, gravel}})) << weather;
    EXPECT_EQ(found.at("Hauptstrasse"), (One{{SurfaceClass::asphalt, asphalt}})) << weather;
  }
}

TEST(SurfaceChain, friction_grids_are_written_beside_the_heights_on_request) {
  const Scratch scratch;
  RoadNetwork roads{.crs = {"EPSG:32633"}};
  RoadPath& path = roads.paths.emplace_back(RoadPath{.osm_id = 5, .highway = "residential"});
  path.known_surface = {SurfaceClass::setts, SurfaceSource::tag};
  for (int i = 0; i <= 50; ++i)
    path.nodes.push_back({.p = Vec2{500000.0 + 2.0 * i, 5500000.0}, .s_m = 2.0 * i, .width_m = 6.0, .z_m = 200.0});
  io::write_roads(scratch / "roads.gpkg", roads);
  const ToolRun run = run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o",
                                (scratch / "a.xodr").string(), "--crg", "all", "--crg-friction", "--weather", "wet"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const roadquery::Road road = roadquery::read_opendrive((scratch / "a.xodr").string()).roads.at(0);
  ASSERT_EQ(road.surface.size(), 2u);
  EXPECT_EQ(road.surface[0].purpose, "elevation");
  EXPECT_EQ(road.surface[1].purpose, "friction");
  EXPECT_EQ(road.surface[1].mode, "attached");
  const CrgSurface grid = io::read_crg(scratch.folder() / road.surface[1].file).surface;
  EXPECT_NEAR(crg_height(grid, {50.0, 1.3}), 0.5, 1e-6);
  EXPECT_NEAR(crg_height(grid, {0.0, -2.9}), 0.5, 1e-6);
}

TEST(SurfaceChain, a_weather_that_is_none_is_told) {
  const ToolRun run = run_tool({"network", "--roads", "roads.gpkg", "-o", "a.xodr", "--weather", "foggy"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("--weather"));
}

}  // namespace
}  // namespace orthodrive

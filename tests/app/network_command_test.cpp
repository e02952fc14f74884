// SPDX-License-Identifier: Apache-2.0
// `orthodrive network` with all the files it can write.

#include <gmock/gmock.h>

#include "app/run_tool.hpp"
#include "network/network_support.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

/// A closed way, a road to it and a side road, with heights and a crown.
void write_town(const fs::path& file) {
  const auto height = [](Vec2 p) { return 40.0 + 0.03 * p.x; };
  std::vector<Vec2> ring = circle_points({160, 0}, 60.0, M_PI, 2.0 * M_PI);
  ring.back() = ring.front();
  std::vector<std::int64_t> ids(ring.size(), 0);
  ids.front() = ids.back() = 3;
  RoadNetwork roads = network_of(
      {make_path({{-100, 0}, {0, 0}, {100, 0}}, {1, 2, 3}, {.osm_id = 71, .highway = "tertiary", .height = height}),
       make_path({{0, -90}, {0, 0}}, {4, 2}, {.osm_id = 72, .height = height}),
       make_path(ring, ids, {.osm_id = 73, .highway = "raceway", .oneway = Oneway::forward, .height = height})});
  io::write_roads(file, roads);
}

TEST(NetworkCommand, crg_surfaces_of_an_osm_way_are_those_of_its_roads) {
  const Scratch scratch;
  write_town(scratch / "roads.gpkg");
  const ToolRun run =
      run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "town.xodr").string(),
                "--crg", "way/71,way/72", "--opendrive", "1.8", "--layers", (scratch / "town.gpkg").string(),
                "--geojson", (scratch / "town.geojson").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const roadquery::RoadMap map = roadquery::read_opendrive((scratch / "town.xodr").string());
  EXPECT_THAT(bytes_of(scratch / "town.xodr"), HasSubstr("revMinor=\"8\""));
  int with_surface = 0;
  for (const roadquery::Road& road : map.roads) {
    const bool wanted = road.osm_id == "71" || road.osm_id == "72";
    EXPECT_EQ(road.surface.size(), wanted ? 1u : 0u) << road.id << " " << road.osm_id;
    if (road.surface.empty()) continue;
    ++with_surface;
    const roadquery::SurfaceCrg& reference = road.surface[0];
    EXPECT_EQ(reference.file, "town_crg/road_" + std::to_string(road.id) + ".crg");
    EXPECT_EQ(reference.mode, "genuine");
    const CrgSurface surface = io::read_crg(scratch.folder() / reference.file).surface;
    // Mode genuine: the file's line begins where the road does, turned by h_offset.
    const roadquery::PlanPoint start = roadquery::reference_point(road, 0.0);
    EXPECT_NEAR(std::hypot(surface.x_m[0] - start.x, surface.y_m[0] - start.y), 0.0, 1e-6);
    EXPECT_NEAR(std::remainder(surface.phi_rad[1] - start.hdg - reference.h_offset, 2.0 * M_PI), 0.0, 1e-6);
    roadquery::RoadMap alone;
    alone.roads = {road};
    const roadquery::RoadQuery query(alone);
    roadquery::Cursor cursor;
    for (double u = 0.2; u < surface.u_end_m() - 0.2; u += 0.77)
      for (const double share : {0.1, 0.5, 0.8}) {
        const roadquery::Edges edges = roadquery::road_edges(road, u);
        const CrgUv uv{u, edges.right_t + share * (edges.left_t - edges.right_t)};
        const Vec2 p = crg_xy(surface, uv);
        const auto hit = query.find(p.x, p.y, 40.0, cursor);
        ASSERT_TRUE(hit);
        EXPECT_NEAR(crg_height(surface, uv), hit->z, 1e-3);
      }
  }
  EXPECT_GE(with_surface, 3);
  EXPECT_FALSE(io::read_features(scratch / "town.gpkg", {"EPSG:32633"}).empty());
  EXPECT_FALSE(io::read_features(scratch / "town.geojson", {"EPSG:32633"}).empty());
}

TEST(NetworkCommand, surfaces_of_a_route_do_not_depend_on_the_number_of_threads) {
  const Scratch scratch;
  write_town(scratch / "roads.gpkg");
  std::map<std::string, std::string> first;
  for (const char* threads : {"1", "3"}) {
    const ToolRun run = run_tool({"--threads", threads, "network", "--roads", (scratch / "roads.gpkg").string(), "-o",
                                  (scratch / "a.xodr").string(), "--crg", "all-of-route", "--crg-format", "lrfi"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto files = snapshot(scratch / "a_crg");
    EXPECT_GT(files.size(), 1u);
    if (first.empty()) first = files;
    EXPECT_EQ(files, first);
  }
}

TEST(NetworkCommand, check_reads_the_file_back_and_tells_how_near_it_is) {
  const Scratch scratch;
  write_town(scratch / "roads.gpkg");
  const ToolRun run = run_tool(
      {"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "a.xodr").string(), "--check"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("points of the surface lie within"));
}

TEST(NetworkCommand, roads_that_are_not_there_are_refused) {
  const Scratch scratch;
  write_town(scratch / "roads.gpkg");
  const struct {
    const char *roads, *what;
  } cases[] = {{"4711", "way/4711"}, {"way/99", "way/99"}, {"everything", "all-of-route"}};
  for (const auto& c : cases) {
    const ToolRun run = run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o",
                                  (scratch / "a.xodr").string(), "--crg", c.roads});
    EXPECT_EQ(run.exit_code, 2) << c.roads;
    EXPECT_THAT(run.err, HasSubstr(c.what));
    EXPECT_FALSE(fs::exists(scratch / "a.xodr"));
    EXPECT_FALSE(fs::exists(scratch / "a_crg"));
  }
  EXPECT_EQ(run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "a.xodr").string(),
                      "--opendrive", "1.6"})
                .exit_code,
            2);
}

}  // namespace
}  // namespace orthodrive

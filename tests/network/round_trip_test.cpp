// SPDX-License-Identifier: Apache-2.0
// What we write is what we read: the surface of every road at random places, and everything that hangs on a road.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>

#include "io/scratch.hpp"
#include "network_support.hpp"
#include "opendrive_peers.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/opendrive/opendrive_io.hpp"
#include "orthodrive/io/opendrive/opendrive_junction.hpp"
#include "roadquery/make_road.hpp"
#include "roadquery/surface/junction_surface.hpp"

namespace orthodrive {
namespace {

using namespace orthodrive::network_test;
using roadquery::Road;
using roadquery::RoadMap;

void expect_same_surface(const RoadMap& a, const RoadMap& b) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  ASSERT_EQ(a.roads.size(), b.roads.size());
  for (std::size_t i = 0; i < a.roads.size(); ++i) {
    const Road &p = a.roads[i], &q = b.roads[i];
    ASSERT_EQ(p.id, q.id);
    ASSERT_NEAR(p.length, q.length, 1e-8);
    for (int k = 0; k < 200; ++k) {
      const double s = p.length * share(random);
      const roadquery::Edges ep = roadquery::road_edges(p, s), eq = roadquery::road_edges(q, s);
      EXPECT_NEAR(ep.left_t, eq.left_t, 1e-7);
      EXPECT_NEAR(ep.right_t, eq.right_t, 1e-7);
      const double t = ep.right_t + (ep.left_t - ep.right_t) * share(random);
      const roadquery::SurfacePoint u = roadquery::surface_point(p, s, t), v = roadquery::surface_point(q, s, t);
      ASSERT_LT(std::hypot(u.x - v.x, u.y - v.y, u.z - v.z), 1e-6) << "road " << p.id << " at " << s << ", " << t;
      const double turned = std::hypot(u.normal[0] - v.normal[0], u.normal[1] - v.normal[1], u.normal[2] - v.normal[2]);
      ASSERT_LT(turned, 1e-7);
    }
  }
}

/// Every kind of element of the plan, in UTM, with all profiles.
Road road_of_all_kinds(int id) {
  using namespace roadquery;
  Road road = roadquery::test::make_road(id, {0.0, 345678.123456789, 6391234.987654321, 2.6789, 31.7, Line{}}, 0.0);
  roadquery::test::append(road, 41.23456789, Spiral{0.0, 0.0333333333333});
  roadquery::test::append(road, 17.7, Arc{0.0333333333333});
  roadquery::test::append(road, 63.1, Spiral{0.0333333333333, -0.0111111111});
  roadquery::test::append(road, 40.0, ParamPoly3{.b_u = 1.0, .c_v = -0.0055555555, .d_v = 6.1e-5, .normalized = false});
  roadquery::test::append(
      road, 35.0, ParamPoly3{.b_u = 35.0, .c_u = -0.31, .d_u = 0.07, .c_v = 2.21, .d_v = -1.13, .normalized = true});
  road.elevation = {{.s = 0.0, .a = 141.123456789, .b = 0.0612345, .c = -1.2345e-3, .d = 5.678e-6},
                    {.s = 80.3456789, .a = 141.9, .b = -0.0123, .c = 2.3e-4, .d = -1.1e-6}};
  road.superelevation = {{.s = 0.0, .a = 0.0123456789, .b = 1.1e-4, .c = -1e-5, .d = 1e-7},
                         {.s = 60.0, .a = 0.0576, .c = -2e-6}};
  road.shape = {{0.0, -6.0, -0.15, 0.025, 0.0, 0.0},        {0.0, 0.0, 0.0, -0.0251234567, 1e-4, -1e-5},
                {77.7654321, -6.0, -0.1, 0.01, 2e-4, 1e-5}, {77.7654321, -1.5, -0.02, 0.0133, 0.0, 0.0},
                {77.7654321, 2.0, 0.01, -0.03, 0.0, 0.0},   {200.0, -6.0, 0.0, 0.0, 0.0, 0.0}};
  road.lane_offset = {{.s = 0.0, .a = 0.5, .b = 0.001, .c = 5e-5, .d = -1e-7}, {.s = 100.0, .a = 1.0}};
  road.sections[0].left[0].width = {{.s = 0.0, .a = 3.0}, {.s = 50.0, .a = 3.0, .c = 4e-4, .d = -2e-6}};
  road.surface = {{.file = "a_crg/road_1.crg", .s_start = 1.5, .s_end = 99.25, .h_offset = 0.0123456789},
                  {.file = "b.crg",
                   .s_end = 9.0,
                   .orientation = "opposite",
                   .mode = "attached",
                   .purpose = "friction",
                   .s_offset = 1.0,
                   .t_offset = -2.0,
                   .z_offset = 0.125,
                   .z_scale = 0.5}};
  return road;
}

RoadMap map_of(std::vector<Road> roads) {
  RoadMap map;
  map.geo_reference = "+proj=utm +zone=33 +datum=WGS84";
  map.roads = std::move(roads);
  return map;
}

TEST(RoundTrip, all_kinds_of_elements_and_profiles) {
  const Scratch scratch;
  const RoadMap map = map_of({road_of_all_kinds(1)});
  for (const int version : {7, 8}) {
    io::write_opendrive(scratch / "a.xodr", map, {.minor_version = version});
    const RoadMap read = roadquery::read_opendrive((scratch / "a.xodr").string());
    expect_same_surface(map, read);
    const Road &a = map.roads[0], &b = read.roads[0];
    EXPECT_EQ(a.shape.size(), b.shape.size());
    EXPECT_EQ(a.lane_offset.size(), b.lane_offset.size());
    ASSERT_EQ(b.surface.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(a.surface[i].file, b.surface[i].file);
      EXPECT_EQ(a.surface[i].mode, b.surface[i].mode);
      EXPECT_EQ(a.surface[i].orientation, b.surface[i].orientation);
      EXPECT_EQ(a.surface[i].purpose, b.surface[i].purpose);
      EXPECT_EQ(a.surface[i].s_start, b.surface[i].s_start);
      EXPECT_EQ(a.surface[i].s_end, b.surface[i].s_end);
      EXPECT_EQ(a.surface[i].s_offset, b.surface[i].s_offset);
      EXPECT_EQ(a.surface[i].t_offset, b.surface[i].t_offset);
      EXPECT_EQ(a.surface[i].z_offset, b.surface[i].z_offset);
      EXPECT_EQ(a.surface[i].z_scale, b.surface[i].z_scale);
      EXPECT_EQ(a.surface[i].h_offset, b.surface[i].h_offset);
    }
    // Once more: what was rounded stays.
    io::write_opendrive(scratch / "b.xodr", read, {.minor_version = version});
    EXPECT_EQ(bytes_of(scratch / "a.xodr"), bytes_of(scratch / "b.xodr"));
  }
}

/// A closed circuit and a crossing, a bridge, ways in both directions, with heights, banking and crowns.
RoadNetwork small_town() {
  const auto height = [](Vec2 p) { return 40.0 + 2.0 * std::sin(p.x / 50.0) + 0.02 * p.y; };
  std::vector<Vec2> ring = circle_points({400, 0}, 60.0, M_PI, 2.0 * M_PI);
  ring.back() = ring.front();
  std::vector<std::int64_t> ring_ids(ring.size(), 0);
  ring_ids.front() = ring_ids.back() = 7;
  std::vector<RoadPath> paths{
      make_path({{-100, 0}, {0, 0}, {100, 20}}, {1, 2, 3},
                {.osm_id = 1,
                 .highway = "primary",
                 .width_m = 8.0,
                 .height = height,
                 .banking = [](double s) { return 0.02 * std::sin(s / 40.0); }}),
      make_path({{0, -80}, {0, 0}, {-10, 90}}, {4, 2, 5}, {.osm_id = 2, .width_m = 5.5, .height = height}),
      make_path(ring, ring_ids,
                {.osm_id = 4,
                 .highway = "raceway",
                 .width_m = 9.0,
                 .oneway = Oneway::forward,
                 .height = height,
                 .banking = [](double s) { return 0.05 + 0.01 * std::sin(s / 60.0); }}),
      make_path({{-50, -90}, {-50, 90}}, {8, 9},
                {.osm_id = 5,
                 .highway = "secondary",
                 .width_m = 7.0,
                 .oneway = Oneway::forward,
                 .lanes = 2,
                 .height = [&](Vec2 p) { return height(p) + 6.0; }})};
  paths[3].bridge = true, paths[3].layer = 1;
  for (RoadNode& node : paths[0].nodes) node.crown = 0.025;
  for (RoadNode& node : paths[1].nodes) node.crown = 0.02 + 0.01 * std::sin(node.s_m / 20.0);
  return network_of(std::move(paths));
}

TEST(RoundTrip, built_network_with_a_closed_road_and_crowns) {
  const Scratch scratch;
  const RoadMap map = build_network(small_town()).map;
  bool shaped = false, closed = false;
  for (const Road& road : map.roads) {
    shaped = shaped || road.shape.size() > 4;
    closed = closed || (road.successor.kind == roadquery::LinkKind::road && road.successor.id == road.id);
  }
  EXPECT_TRUE(shaped);
  EXPECT_TRUE(closed);
  io::write_opendrive(scratch / "a.xodr", map);
  const RoadMap read = roadquery::read_opendrive((scratch / "a.xodr").string());
  expect_sound(read);
  expect_same_surface(map, read);
}

/// The 1.8.1 schema without what is new in XSD 1.1, which xmllint does not know: assertions, and types by attribute
/// (all junctions of ours are common ones).
std::filesystem::path schema_1_8(const Scratch& scratch) {
  namespace fs = std::filesystem;
  const fs::path source = opendrive_schema.parent_path().parent_path() / "1.8.1";
  for (const auto& entry : fs::directory_iterator(source)) {
    std::istringstream in(bytes_of(entry.path()));
    std::string text;
    for (std::string line; std::getline(in, line);) {
      if (line.find("<xs:assert") != std::string::npos || line.find("<xs:alternative") != std::string::npos) continue;
      if (const std::size_t at = line.find("name=\"junction\" type=\"t_junction\""); at != std::string::npos)
        line.replace(line.find("t_junction\""), 11, "t_junction_common\"");
      text += line + "\n";
    }
    write_bytes(scratch / entry.path().filename().string(), text);
  }
  return scratch / "OpenDRIVE_Core.xsd";
}

TEST(RoundTrip, both_versions_are_valid_against_their_schemas) {
  if (!std::filesystem::exists(opendrive_schema))
    GTEST_SKIP() << "NOT TESTED: no OpenDRIVE schema at " << opendrive_schema;
  const Scratch scratch;
  RoadMap map = build_network(small_town()).map;
  Road all = road_of_all_kinds(static_cast<int>(map.roads.size()) + 1);
  map.roads.push_back(all);
  io::write_opendrive(scratch / "7.xodr", map);
  expect_valid_opendrive(scratch / "7.xodr");
  io::write_opendrive(scratch / "8.xodr", map, {.minor_version = 8});
  EXPECT_NE(bytes_of(scratch / "8.xodr").find("revMinor=\"8\""), std::string::npos);
  const std::string schema = schema_1_8(scratch).string();
  const auto validate = [&](const char* name) {
    return run_program({"/usr/bin/xmllint", "--noout", "--schema", schema, (scratch / name).string()});
  };
  const ToolRun good = validate("8.xodr");
  EXPECT_EQ(good.exit_code, 0) << good.err.substr(0, 2000);
  // Of the assertions two concern us: connections of a junction have different ids, and lane offsets need widths.
  for (const roadquery::Junction& junction : map.junctions) {
    std::set<int> ids;
    for (const roadquery::Connection& connection : junction.connections) EXPECT_TRUE(ids.insert(connection.id).second);
  }
  EXPECT_EQ(bytes_of(scratch / "8.xodr").find("<border"), std::string::npos);
  // The test can fail: a shape without its t.
  std::string broken = bytes_of(scratch / "8.xodr");
  broken.erase(broken.find(" t=\"", broken.find("<shape")), 7);
  write_bytes(scratch / "bad.xodr", broken);
  EXPECT_NE(validate("bad.xodr").exit_code, 0);
}

TEST(JunctionGrids, are_read_as_if_they_were_not_there) {
  const Scratch scratch;
  const RoadMap map = build_network(small_town()).map;
  io::write_opendrive(scratch / "plain.xodr", map, {.minor_version = 8});
  io::write_opendrive(scratch / "grids.xodr", map, {.minor_version = 8, .junction_grids = true});
  const std::string text = bytes_of(scratch / "grids.xodr");
  EXPECT_NE(text.find("<boundary>"), std::string::npos);
  EXPECT_NE(text.find("<elevationGrid"), std::string::npos);
  const RoadMap read = roadquery::read_opendrive((scratch / "grids.xodr").string());
  EXPECT_EQ(read.roads.size(), map.roads.size());
  io::write_opendrive(scratch / "again.xodr", read, {.minor_version = 8});
  EXPECT_EQ(bytes_of(scratch / "again.xodr"), bytes_of(scratch / "plain.xodr"));
  EXPECT_THROW(io::write_opendrive(scratch / "a.xodr", map, {.minor_version = 7, .junction_grids = true}), OptionError);
}

/// Ends of a segment: the kerb's line, or the edges of the arm, left one first, seen into the junction.
std::array<Vec2, 2> ends_of(const io::BoundarySegment& segment, const io::JunctionBoundary& boundary,
                            const RoadMap& map) {
  if (segment.joint) {
    const Road& arm =
        *std::find_if(map.roads.begin(), map.roads.end(), [&](const Road& r) { return r.id == segment.road; });
    const bool at_end = segment.contact == roadquery::ContactPoint::end;
    const double s = at_end ? arm.length : 0.0;
    const roadquery::Edges edges = roadquery::road_edges(arm, s);
    const auto left = roadquery::surface_point(arm, s, at_end ? edges.left_t : edges.right_t);
    const auto right = roadquery::surface_point(arm, s, at_end ? edges.right_t : edges.left_t);
    return {Vec2{left.x, left.y}, Vec2{right.x, right.y}};
  }
  const Road& kerb =
      *std::find_if(boundary.kerbs.begin(), boundary.kerbs.end(), [&](const Road& r) { return r.id == segment.road; });
  const roadquery::PlanPoint from = roadquery::reference_point(kerb, 0.0),
                             to = roadquery::reference_point(kerb, kerb.length);
  return {Vec2{from.x, from.y}, Vec2{to.x, to.y}};
}

TEST(JunctionGrids, boundary_is_closed_and_has_a_joint_for_each_arm) {
  const RoadMap map = build_network(small_town()).map;
  const std::vector<io::JunctionBoundary> boundaries = io::junction_boundaries(map);
  ASSERT_EQ(boundaries.size(), map.junctions.size());
  int joints = 0, arms = 0;
  std::set<int> ids;
  for (const Road& road : map.roads) {
    ids.insert(road.id);
    if (road.junction < 0)
      arms += (road.predecessor.kind == roadquery::LinkKind::junction) +
              (road.successor.kind == roadquery::LinkKind::junction);
  }
  for (const roadquery::Junction& junction : map.junctions) ids.insert(junction.id);
  for (const io::JunctionBoundary& boundary : boundaries) {
    ASSERT_FALSE(boundary.segments.empty());
    for (const Road& kerb : boundary.kerbs) EXPECT_TRUE(ids.insert(kerb.id).second);
    for (std::size_t i = 0; i < boundary.segments.size(); ++i) {
      const auto here = ends_of(boundary.segments[i], boundary, map);
      const auto next = ends_of(boundary.segments[(i + 1) % boundary.segments.size()], boundary, map);
      EXPECT_LT(distance(next[0], here[1]), 0.05) << "segment " << i;  // the ring overlaps the arms by 1.5 cm
      joints += boundary.segments[i].joint;
    }
  }
  EXPECT_EQ(joints, arms);
  EXPECT_GT(joints, 3);
}

TEST(JunctionGrids, kerbs_have_the_heights_of_the_surface) {
  const RoadMap map = build_network(small_town()).map;
  const std::vector<io::JunctionBoundary> boundaries = io::junction_boundaries(map);
  for (std::size_t i = 0; i < boundaries.size(); ++i) {
    const auto& surface = map.junctions[i].surface;
    ASSERT_TRUE(surface.has_value());
    for (const Road& kerb : boundaries[i].kerbs)
      for (const roadquery::PlanElement& piece : kerb.plan) {
        const roadquery::SurfacePoint p = roadquery::surface_point(kerb, piece.s, 0.0);
        EXPECT_NEAR(p.z, roadquery::evaluate(*surface, p.x, p.y).z, 1e-6);
      }
  }
}

TEST(RoundTrip, other_versions_are_refused) {
  const Scratch scratch;
  EXPECT_THROW(io::write_opendrive(scratch / "a.xodr", map_of({road_of_all_kinds(1)}), {.minor_version = 6}),
               OptionError);
}

}  // namespace
}  // namespace orthodrive

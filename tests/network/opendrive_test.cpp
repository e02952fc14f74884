// SPDX-License-Identifier: Apache-2.0
// Our files before real readers: our own, the ASAM schema (xmllint) and SUMO (netconvert); and real towns from OSM.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "cpu_seconds.hpp"
#include "network_support.hpp"
#include "opendrive_peers.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/io/opendrive/opendrive_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using namespace orthodrive::network_test;
using roadquery::Road;
using ::testing::HasSubstr;
using ::testing::Not;

const fs::path data_folder = paths::in_source("..") / "shared" / "data";

class OpenDrive : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("orthodrive_network_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

  [[nodiscard]] const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

/// Marks of type none are the same as none.
std::vector<std::tuple<double, std::string, double>> marks_of(const roadquery::Lane& lane) {
  std::vector<std::tuple<double, std::string, double>> marks;
  for (const roadquery::RoadMark& mark : lane.marks)
    if (mark.type != "none") marks.emplace_back(mark.s_offset, mark.type, mark.width);
  return marks;
}

/// Everything at once: a circuit with an access road, a crossing, a bridge, one-way lanes, ways in both directions.
RoadNetwork mixed_network() {
  const auto height = [](Vec2 p) { return 40.0 + 2.0 * std::sin(p.x / 50.0) + 0.02 * p.y; };
  std::vector<Vec2> ring = circle_points({200, 0}, 60.0, M_PI, 2.0 * M_PI);
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
      make_path({{140, 0}, {100, 20}}, {7, 3}, {.osm_id = 3, .width_m = 6.0, .height = height}),
      make_path(ring, ring_ids,
                {.osm_id = 4, .highway = "raceway", .width_m = 9.0, .oneway = Oneway::forward, .height = height}),
      make_path({{-50, -90}, {-50, 90}}, {8, 9},
                {.osm_id = 5,
                 .highway = "secondary",
                 .width_m = 7.0,
                 .oneway = Oneway::forward,
                 .lanes = 2,
                 .height = [&](Vec2 p) { return height(p) + 6.0; }})};
  paths[4].bridge = true, paths[4].layer = 1;
  paths[0].name = "Straße <1> & \"2\"";
  return network_of(std::move(paths));
}

TEST_F(OpenDrive, reading_back_gives_the_same_map) {
  const roadquery::RoadMap map = build_network(mixed_network()).map;
  io::write_opendrive(file("a.xodr"), map);
  const roadquery::RoadMap read = roadquery::read_opendrive(file("a.xodr").string());
  expect_sound(read);
  EXPECT_EQ(read.name, map.name);
  EXPECT_EQ(read.geo_reference, map.geo_reference);
  EXPECT_EQ(read.north, map.north);
  ASSERT_EQ(read.roads.size(), map.roads.size());
  ASSERT_EQ(read.junctions.size(), map.junctions.size());
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road &a = map.roads[i], &b = read.roads[i];
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.junction, b.junction);
    EXPECT_EQ(a.osm_id, b.osm_id);
    EXPECT_EQ(a.highway, b.highway);
    EXPECT_NEAR(a.speed_limit_mps, b.speed_limit_mps, 1e-3);
    EXPECT_EQ(a.layer, b.layer);
    EXPECT_EQ(a.bridge, b.bridge);
    EXPECT_EQ(a.driving_side, b.driving_side);
    EXPECT_NEAR(a.length, b.length, 1e-7);
    EXPECT_EQ(a.plan.size(), b.plan.size());
    EXPECT_EQ(a.elevation.size(), b.elevation.size());
    EXPECT_EQ(a.superelevation.size(), b.superelevation.size());
    for (const auto& [la, lb] : {std::pair{a.predecessor, b.predecessor}, std::pair{a.successor, b.successor}}) {
      EXPECT_EQ(la.kind, lb.kind);
      EXPECT_EQ(la.id, lb.id);
      EXPECT_EQ(la.contact, lb.contact);
    }
    ASSERT_EQ(b.sections.size(), 1u);
    const auto expect_lanes = [](const std::vector<roadquery::Lane>& u, const std::vector<roadquery::Lane>& v) {
      ASSERT_EQ(u.size(), v.size());
      for (std::size_t k = 0; k < u.size(); ++k) {
        EXPECT_EQ(u[k].id, v[k].id);
        EXPECT_EQ(u[k].type, v[k].type);
        EXPECT_EQ(u[k].predecessor, v[k].predecessor);
        EXPECT_EQ(u[k].successor, v[k].successor);
        EXPECT_EQ(marks_of(u[k]), marks_of(v[k]));
      }
    };
    expect_lanes(a.sections[0].left, b.sections[0].left);
    expect_lanes(a.sections[0].right, b.sections[0].right);
    for (double s = 0.0; s <= a.length; s += 2.5)
      for (const double t : {-2.0, 0.0, 2.0}) {
        const roadquery::SurfacePoint p = roadquery::surface_point(a, s, t), q = roadquery::surface_point(b, s, t);
        EXPECT_NEAR(std::hypot(p.x - q.x, p.y - q.y, p.z - q.z), 0.0, 1e-6);
        // Where a taper begins is written to 1e-8 m.
        const double left_t = roadquery::road_edges(a, s).left_t;
        const double taper = (roadquery::road_edges(a, s + 1e-4).left_t - left_t) / 1e-4;
        EXPECT_NEAR(left_t, roadquery::road_edges(b, s).left_t, 1e-9 + 5e-9 * std::abs(taper));
      }
  }
  for (std::size_t j = 0; j < map.junctions.size(); ++j)
    EXPECT_EQ(read.junctions[j].connections.size(), map.junctions[j].connections.size());
}

TEST_F(OpenDrive, connecting_roads_repeat_nothing_of_the_roads_they_connect_but_say_what_differs) {
  roadquery::RoadMap map = build_network(mixed_network()).map;
  std::size_t connecting = 0;
  for (const Road& road : map.roads) connecting += road.junction >= 0;
  ASSERT_GT(connecting, 2u);
  const auto types = [&] {
    io::write_opendrive(file("a.xodr"), map);
    const std::string text = bytes_of(file("a.xodr"));
    std::size_t count = 0;
    for (std::size_t at = text.find("<type "); at != std::string::npos; at = text.find("<type ", at + 1)) ++count;
    return count;
  };
  EXPECT_EQ(types(), map.roads.size() - connecting);
  Road& slow = *std::find_if(map.roads.begin(), map.roads.end(), [](const Road& road) { return road.junction >= 0; });
  slow.speed_limit_mps = 10.0 / 3.6, slow.highway = "path", slow.osm_id = "77";
  EXPECT_EQ(types(), map.roads.size() - connecting + 1);
  const roadquery::RoadMap read = roadquery::read_opendrive(file("a.xodr").string());
  const Road& again = *road_by_id(read, slow.id);
  EXPECT_NEAR(again.speed_limit_mps, slow.speed_limit_mps, 1e-9);
  EXPECT_EQ(again.highway, "path");
  EXPECT_EQ(again.osm_id, "77");
}

TEST_F(OpenDrive, connecting_roads_have_the_material_of_the_road_before_unless_they_say_otherwise) {
  roadquery::RoadMap map = build_network(mixed_network()).map;
  const auto lanes_of = [](Road& road) {
    std::vector<roadquery::Lane*> lanes;
    for (auto* side : {&road.sections.front().left, &road.sections.front().right})
      for (roadquery::Lane& lane : *side) lanes.push_back(&lane);
    return lanes;
  };
  const auto written = [&](const roadquery::RoadMap& of) {
    io::write_opendrive(file("a.xodr"), of);
    const std::string text = bytes_of(file("a.xodr"));
    std::size_t count = 0;
    for (std::size_t at = text.find("<material "); at != std::string::npos; at = text.find("<material ", at + 1))
      ++count;
    return count;
  };
  std::size_t outside = 0;
  std::vector<roadquery::Lane*> connecting;
  for (Road& road : map.roads)
    for (roadquery::Lane* lane : lanes_of(road)) {
      ASSERT_EQ(lane->materials.size(), 1u);
      if (road.junction < 0 || lane->type != roadquery::LaneType::driving)  // strips say what they are of
        ++outside;
      else
        connecting.push_back(lane);
    }
  ASSERT_GT(connecting.size(), 2u);
  EXPECT_EQ(written(map), outside) << "all of asphalt";
  roadquery::LaneMaterial& wet = connecting[1]->materials.front();
  wet.friction = 0.5;
  EXPECT_EQ(written(map), outside + 1);
  const roadquery::RoadMap read = roadquery::read_opendrive(file("a.xodr").string());
  for (Road& road : map.roads) {
    Road again = *road_by_id(read, road.id);
    const std::vector<roadquery::Lane*> a = lanes_of(road), b = lanes_of(again);
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(b[i]->materials.size(), 1u) << road.id;
      EXPECT_EQ(b[i]->materials[0].surface, a[i]->materials[0].surface);
      EXPECT_NEAR(b[i]->materials[0].friction, a[i]->materials[0].friction, 1e-4);
      EXPECT_NEAR(b[i]->materials[0].roughness, a[i]->materials[0].roughness, 1e-5);
    }
  }
  for (Road& road : map.roads)
    for (roadquery::Lane* lane : lanes_of(road)) lane->materials.front().friction = 0.5;
  EXPECT_EQ(written(map), outside + connecting.size()) << "other readers assume 1 where nothing is said";
}

TEST_F(OpenDrive, same_roads_give_the_same_bytes_for_any_thread_count) {
  io::write_opendrive(file("a.xodr"), build_network(mixed_network(), {.threads = 1}).map);
  io::write_opendrive(file("b.xodr"), build_network(mixed_network(), {.threads = 4}).map);
  EXPECT_EQ(bytes_of(file("a.xodr")), bytes_of(file("b.xodr")));
  EXPECT_GT(bytes_of(file("a.xodr")).size(), 10000u);
}

TEST_F(OpenDrive, map_without_roads_is_refused_and_the_old_file_stays) {
  std::ofstream(file("a.xodr")) << "old";
  EXPECT_THROW(io::write_opendrive(file("a.xodr"), {}), Error);
  EXPECT_EQ(bytes_of(file("a.xodr")), "old");
}

TEST_F(OpenDrive, road_marks_are_written_with_their_colours_and_lines) {
  roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {30, 0}}, {1, 2})})).map;
  roadquery::Lane& center = map.roads[0].sections[0].center;
  center.marks = {{0.0, "solid broken", 0.12, "yellow"},
                  {9.0, "custom", 0.1, "white", {{3, 9, 0.1, 1, 0.2, "blue", false}, {2, 0, -0.1, 4, 0.3, "", true}}}};
  io::write_opendrive(file("a.xodr"), map);
  const roadquery::RoadMap read = roadquery::read_opendrive(file("a.xodr").string());
  const std::vector<roadquery::RoadMark>& marks = read.roads[0].sections[0].center.marks;
  ASSERT_EQ(marks.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(marks[i].type, center.marks[i].type);
    EXPECT_EQ(marks[i].color, center.marks[i].color);
    ASSERT_EQ(marks[i].lines.size(), center.marks[i].lines.size());
  }
  const auto told = [](const roadquery::RoadMarkLine& l) {
    return fmt::format("{} {} {} {} {} {} {}", l.length, l.space, l.t_offset, l.s_offset, l.width, l.color,
                       l.is_single_stroke);
  };
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(told(marks[1].lines[k]), told(center.marks[1].lines[k]));
  if (fs::exists(opendrive_schema)) expect_valid_opendrive(file("a.xodr"));
}

TEST_F(OpenDrive, all_shapes_are_written) {
  roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {30, 0}}, {1, 2})})).map;
  map.roads[0].plan = {{0, 0, 0, 0, 10, roadquery::Spiral{0.0, 0.02}},
                       {10, 10, 0, 0, 20, roadquery::ParamPoly3{0, 1, 0.25, 0, 0, 0, 0.5, -0.125, false}}};
  io::write_opendrive(file("a.xodr"), map);
  const roadquery::RoadMap read = roadquery::read_opendrive(file("a.xodr").string());
  EXPECT_EQ(std::get<roadquery::Spiral>(read.roads[0].plan[0].shape).curvature_end, 0.02);
  EXPECT_EQ(std::get<roadquery::ParamPoly3>(read.roads[0].plan[1].shape).d_v, -0.125);
  EXPECT_FALSE(std::get<roadquery::ParamPoly3>(read.roads[0].plan[1].shape).normalized);
}

TEST_F(OpenDrive, coordinates_are_local_and_the_offset_gives_those_of_the_crs_back) {
  const Vec2 here{456.25, 321.5};  // from the place of make_path
  const roadquery::RoadMap map = build_network(network_of({make_path({here, here + Vec2{300, 40}}, {1, 2})})).map;
  io::write_opendrive(file("local.xodr"), map);
  io::write_opendrive(file("absolute.xodr"), map, {.absolute = true});
  const std::string local = bytes_of(file("local.xodr")), absolute = bytes_of(file("absolute.xodr"));
  EXPECT_THAT(local, HasSubstr("<offset x=\"651000\" y=\"6400000\" z=\"0\" hdg=\"0\"/>"));
  EXPECT_THAT(local, Not(HasSubstr("64003")));
  EXPECT_THAT(absolute, Not(HasSubstr("<offset")));
  for (const char* name : {"local.xodr", "absolute.xodr"}) {
    const roadquery::RoadMap read = roadquery::read_opendrive(file(name).string());
    EXPECT_NEAR(read.roads[0].plan[0].x, map.roads[0].plan[0].x, 2e-9) << name;
    EXPECT_NEAR(read.roads[0].plan[0].y, map.roads[0].plan[0].y, 2e-9) << name;
    EXPECT_EQ(read.north, map.north) << name;
    EXPECT_EQ(read.west, map.west) << name;
    if (fs::exists(opendrive_schema)) expect_valid_opendrive(file(name));
  }
}

TEST_F(OpenDrive, geo_reference_is_of_keys_with_values_and_names_the_same_crs) {
  for (const char* epsg : {"EPSG:32633", "EPSG:25832", "EPSG:32760"}) {
    roadquery::RoadMap map = build_network(network_of({make_path({{0, 0}, {30, 0}}, {1, 2})})).map;
    map.geo_reference = proj_string({epsg});
    io::write_opendrive(file("a.xodr"), map);
    EXPECT_THAT(bytes_of(file("a.xodr")), HasSubstr("<geoReference><![CDATA[" + map.geo_reference + "]]>"));
    const std::string read = roadquery::read_opendrive(file("a.xodr").string()).geo_reference;
    const CoordinateTransform transform(Crs{read}, Crs{epsg});
    for (const Vec2 p : {Vec2{322576.25, 6394665.5}, Vec2{553594.0, 5542662.0}, Vec2{700000.0, 4800000.0}})
      EXPECT_LT(distance(transform.target_from_source(p), p), 1e-6) << read;
    // esmini takes each word for "+key=value", with these keys among others (RoadManager, ParseGeoLocalization).
    std::istringstream words(read);
    const std::set<std::string> known{"+proj", "+zone", "+datum", "+units", "+ellps", "+towgs84"};
    for (std::string word; words >> word;)
      EXPECT_TRUE(known.count(word.substr(0, word.find('='))) || word == "+south") << word << " of " << read;
  }
}

TEST_F(OpenDrive, file_is_valid_against_the_asam_schema) {
  if (!fs::exists(opendrive_schema)) GTEST_SKIP() << "NOT TESTED: no OpenDRIVE schema at " << opendrive_schema;
  io::write_opendrive(file("a.xodr"), build_network(mixed_network()).map);
  expect_valid_opendrive(file("a.xodr"));
  // The test can fail: a road without its id.
  std::string broken = bytes_of(file("a.xodr"));
  broken.erase(broken.find(" junction=\"-1\""), 14);
  std::ofstream(file("b.xodr")) << broken;
  EXPECT_NE(run_program(validate_opendrive(file("b.xodr"))).exit_code, 0);
}

TEST_F(OpenDrive, sumo_reads_every_road) {
  const roadquery::RoadMap map = build_network(mixed_network()).map;
  io::write_opendrive(file("a.xodr"), map);
  expect_sumo_finds_all_roads(file("a.xodr"), folder());
}

TEST_F(OpenDrive, kvarnbyn_from_osm_alone) {
  const fs::path osm = data_folder / "kvarnbyn" / "roads.osm";
  if (!fs::exists(osm)) GTEST_SKIP() << "NOT TESTED: no real data at " << osm;
  SiteFrame site{{"EPSG:32633"}, {}};
  const CoordinateTransform from_lonlat({"EPSG:4326"}, site.crs);
  for (const Vec2 p : {Vec2{12.0, 57.6}, {12.1, 57.6}, {12.1, 57.7}, {12.0, 57.7}})
    site.area.outer.push_back(from_lonlat.target_from_source(p));
  const RoadNetwork roads = io::read_osm_roads(osm, site);
  NetworkResult result;
#ifdef __SANITIZE_ADDRESS__  // several times slower
  result = build_network(roads);
#else
  EXPECT_LT(test::least_cpu_seconds(3, [&] { result = build_network(roads); }), 10.0) << "5 s of two cores";
#endif
  expect_sound(result.map);
  EXPECT_LE(result.max_plan_deviation_m, 0.1);
  EXPECT_GT(plain_roads(result.map).size(), roads.paths.size());
  io::write_opendrive(file("a.xodr"), result.map);
  if (fs::exists(opendrive_schema)) expect_valid_opendrive(file("a.xodr"));
  expect_sound(roadquery::read_opendrive(file("a.xodr").string()));
  expect_sumo_finds_all_roads(file("a.xodr"), folder());
}

TEST_F(OpenDrive, refined_towns_take_one_element_every_twenty_metres) {
  const fs::path folder = paths::in_source("out") / "refinement" / "roads";
  if (!fs::exists(folder)) GTEST_SKIP() << "NOT TESTED: no refined roads at " << folder;
  for (const char* town : {"kvarnbyn", "pardubice"}) {
    const fs::path path = folder / (std::string(town) + " drawn.default.gpkg");
    if (!fs::exists(path)) GTEST_SKIP() << "NOT TESTED: no refined roads at " << path;
    const NetworkResult result = build_network(io::read_roads(path));
    EXPECT_LE(result.max_plan_deviation_m, 0.1) << town;
    double length = 0.0, elements = 0.0;
    for (const Road* road : plain_roads(result.map)) {
      length += road->length, elements += static_cast<double>(road->plan.size());
      for (const roadquery::PlanElement& e : road->plan)
        EXPECT_FALSE(std::holds_alternative<roadquery::ParamPoly3>(e.shape)) << town << ", road " << road->id;
    }
    EXPECT_GE(length / elements, 20.0) << town;
    io::write_opendrive(file("a.xodr"), result.map);
    expect_sound(roadquery::read_opendrive(file("a.xodr").string()));
  }
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// OpenCRG files laid on roads: every mode against its formula in OpenDRIVE (1.9, 10.6.1), and what is refused.

#include "roadquery/crg/road_crgs.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "roadquery/crg/read_crg.hpp"
#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"

namespace roadquery {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A folder that is gone after the test.
struct Folder {
  fs::path path =
      fs::temp_directory_path() / ("road_crgs_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
                                   "_" + ::testing::UnitTest::GetInstance()->current_test_info()->name());
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

/// Text files with columns at -2, -1, ... 2, rows every 0.5 m of u from 0 on, 41 rows; heights of seven decimals.
void write_grid(const fs::path& path, const std::function<double(double u, double v)>& height,
                const std::string& lines = "", double phi = 0.0) {
  std::ostringstream out;
  out << "$CT\nfor a test\n$\n$ROAD_CRG\nREFERENCE_LINE_START_U = 0\nREFERENCE_LINE_END_U = 20\n"
         "REFERENCE_LINE_INCREMENT = 0.5\nLONG_SECTION_V_RIGHT = -2\nLONG_SECTION_V_INCREMENT = 1\n"
      << lines << "REFERENCE_LINE_START_PHI = " << phi << "\n$KD_DEFINITION\n#:LRFI\n";
  for (int j = 0; j < 5; ++j) out << "D:long section " << j + 1 << ",m\n";
  out << "$\n$$$$$$$$\n";
  out.setf(std::ios::fixed);
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j < 5; ++j) {
      out.width(10), out.precision(6);
      out << height(0.5 * i, j - 2.0);
    }
    out << '\n';
  }
  std::ofstream(path) << out.str();
}

double waves(double u, double v) { return 0.03 * std::sin(0.7 * u) + 0.01 * v * v; }

/// 30 m of road that turns left, climbs and leans, with one reference.
RoadMap map_with(SurfaceCrg reference) {
  Road road = test::make_road(7, {0.0, 100.0, 200.0, 0.3, 30.0, Arc{0.01}}, 50.0);
  road.elevation = {{.s = 0.0, .a = 50.0, .b = 0.02}};
  road.superelevation = {{.s = 0.0, .a = 0.05}};
  reference.file = "a.crg";
  if (reference.s_end == 0.0) reference.s_end = 30.0;
  road.surface = {std::move(reference)};
  RoadMap map;
  map.roads = {std::move(road)};
  return map;
}

RoadPlace place_at(const Road& road, double s, double t) {
  const PlanPoint p = reference_point(road, s);
  const SurfacePoint point = surface_point(road, s, t, p);
  const double left = t * std::cos(superelevation(road, s));
  return {s,
          t,
          point.x,
          point.y,
          std::cos(p.hdg),
          std::sin(p.hdg),
          1.0 / (1.0 - p.curvature * left),
          1.0 / std::cos(superelevation(road, s))};
}

LaidSurface laid(const RoadCrgs& crgs, const RoadMap& map, double s, double t) {
  LaidSurface surface{surface_height(map.roads[0], s, t), 0.0, 0.0, 0.8};
  if (crgs.on(0)) crgs.lay(0, place_at(map.roads[0], s, t), surface);
  return surface;
}

double own_z(const RoadMap& map, double s, double t) { return surface_height(map.roads[0], s, t); }
/// Heights of the files have six decimals; halfway between rows bilinear misses the wave by 0.25 / 8 x 0.03 x 0.49.
constexpr double digits = 1e-6;

TEST(RoadCrgs, attached_adds_the_grid_to_the_road) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves);
  for (const double sign : {1.0, -1.0}) {
    SurfaceCrg reference;
    reference.mode = "attached", reference.orientation = sign > 0.0 ? "same" : "opposite";
    reference.s_start = 5.0, reference.s_end = 24.0, reference.s_offset = sign > 0.0 ? 4.0 : 24.0;
    reference.t_offset = 0.5, reference.z_offset = 0.2, reference.z_scale = 3.0;
    const RoadMap map = map_with(reference);
    const RoadCrgs crgs(map, folder.path.string());
    EXPECT_THAT(crgs.notes(), IsEmpty());
    for (const double s : {5.0, 8.5, 17.5, 23.5})
      for (const double t : {-1.5, -0.5, 1.5}) {  // whole columns of v
        const double u = sign * (s - reference.s_offset), v = sign * (t - 0.5);
        EXPECT_NEAR(laid(crgs, map, s, t).z, own_z(map, s, t) + 0.2 + 3.0 * waves(u, v), 3.0 * digits) << s << " " << t;
        EXPECT_EQ(laid(crgs, map, s, t).friction, 0.8);
      }
    for (const double s : {4.9, 24.1}) EXPECT_EQ(laid(crgs, map, s, 0.3).z, own_z(map, s, 0.3)) << "outside";
    EXPECT_NEAR(laid(crgs, map, 10.0, 3.3).z,
                own_z(map, 10.0, 3.3) + 0.2 + 3.0 * waves(sign * (10.0 - reference.s_offset), 2.0), 3.0 * digits)
        << "a grid narrower than the road goes on as it ends";
  }
}

TEST(RoadCrgs, attached_leaves_slope_banking_and_heading_of_the_file_out) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves,
             "REFERENCE_LINE_START_S = 0.1\nREFERENCE_LINE_START_B = 0.2\nREFERENCE_LINE_START_Z = 500\n", 1.0);
  SurfaceCrg reference;
  reference.mode = "attached";
  RoadMap map = map_with(reference);
  const RoadCrgs attached(map, folder.path.string());
  EXPECT_NEAR(laid(attached, map, 10.0, 1.0).z, own_z(map, 10.0, 1.0) + waves(10.0, 1.0), digits);
  map.roads[0].surface[0].mode = "attached0";
  const RoadCrgs absolute(map, folder.path.string());
  EXPECT_NEAR(laid(absolute, map, 10.0, 1.0).z, 500.0 + 0.1 * 10.0 + 0.2 * 1.0 + waves(10.0, 1.0), digits);
}

TEST(RoadCrgs, genuine_puts_the_start_of_the_file_on_the_road) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves, "REFERENCE_LINE_START_X = 1000\nREFERENCE_LINE_START_Y = -300\n", 2.0);
  SurfaceCrg reference;
  reference.mode = "genuine", reference.s_start = 2.0, reference.s_end = 28.0;
  reference.s_offset = 3.0, reference.t_offset = -0.5, reference.h_offset = 0.04;
  reference.z_offset = 60.0, reference.z_scale = 2.0;
  const RoadMap map = map_with(reference);
  const RoadCrgs crgs(map, folder.path.string());
  const PlanPoint p = reference_point(map.roads[0], 3.0);
  const SurfacePoint start = surface_point(map.roads[0], 3.0, -0.5, p);
  const double heading = p.hdg + 0.04;  // of the file's straight line
  for (const double s : {3.5, 9.0, 13.0, 16.0})
    for (const double t : {-0.7, 0.1, 0.9}) {
      const RoadPlace place = place_at(map.roads[0], s, t);
      const double dx = place.x - start.x, dy = place.y - start.y;
      const double u = dx * std::cos(heading) + dy * std::sin(heading);
      const double v = dy * std::cos(heading) - dx * std::sin(heading);
      ASSERT_LT(std::abs(v), 2.0);
      // Bilinear between the corners of the cell.
      const double u0 = std::floor(2.0 * u) / 2.0, v0 = std::floor(v), a = 2.0 * (u - u0), b = v - v0;
      const double want = (1 - a) * (1 - b) * waves(u0, v0) + (1 - a) * b * waves(u0, v0 + 1) +
                          a * (1 - b) * waves(u0 + 0.5, v0) + a * b * waves(u0 + 0.5, v0 + 1);
      EXPECT_NEAR(laid(crgs, map, s, t).z, 60.0 + 2.0 * want, 2.0 * digits) << s << " " << t;
    }
}

TEST(RoadCrgs, global_takes_the_file_where_it_lies) {
  const Folder folder;
  // The plane z = u + 10 v about the map's (100, 200), heading 0.3 + pi / 6.
  write_grid(
      folder.path / "a.crg", [](double u, double v) { return 0.1 * u + 0.2 * v; },
      "REFERENCE_LINE_START_X = 98\nREFERENCE_LINE_START_Y = 199\n", 0.3);
  SurfaceCrg reference;
  reference.mode = "global", reference.z_offset = 7.0;
  const RoadMap map = map_with(reference);
  const RoadCrgs crgs(map, folder.path.string());
  const RoadPlace place = place_at(map.roads[0], 12.0, 0.4);
  const double dx = place.x - 98.0, dy = place.y - 199.0;
  const double u = dx * std::cos(0.3) + dy * std::sin(0.3), v = dy * std::cos(0.3) - dx * std::sin(0.3);
  ASSERT_LT(std::abs(v), 2.0);
  EXPECT_NEAR(laid(crgs, map, 12.0, 0.4).z, 7.0 + 0.1 * u + 0.2 * v, 2.0 * digits);
}

TEST(RoadCrgs, rise_is_the_derivative_along_and_across_in_every_mode) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves);
  for (const char* mode : {"attached", "attached0", "genuine"})
    for (const char* orientation : {"same", "opposite"}) {
      SurfaceCrg reference;
      reference.mode = mode, reference.orientation = orientation, reference.z_scale = 1.5;
      if (std::string(orientation) == "opposite" && std::string(mode) != "genuine") reference.s_offset = 20.0;
      RoadMap map = map_with(reference);
      map.roads[0].elevation.clear(), map.roads[0].superelevation.clear();
      const RoadCrgs crgs(map, folder.path.string());
      const Road& road = map.roads[0];
      const double h = 1e-5, s = 11.3, t = 0.6;
      const LaidSurface at = laid(crgs, map, s, t);
      // A metre along the heading at t is less of s than a metre on the reference line.
      const double along = (laid(crgs, map, s + h, t).z - laid(crgs, map, s - h, t).z) / (2.0 * h) / (1.0 - 0.01 * t);
      const double left = (laid(crgs, map, s, t + h).z - laid(crgs, map, s, t - h).z) / (2.0 * h);
      EXPECT_NEAR(at.rise_along, along, 1e-5) << mode << " " << orientation;
      EXPECT_NEAR(at.rise_left, left, 1e-5) << mode << " " << orientation;
      EXPECT_GT(std::abs(left), 1e-3) << road.id;
    }
}

TEST(RoadCrgs, friction_replaces_friction_and_nothing_else) {
  const Folder folder;
  write_grid(folder.path / "a.crg", [](double u, double) { return 0.3 + 0.01 * u; });
  for (const char* mode : {"attached", "attached0"}) {
    SurfaceCrg reference;
    reference.mode = mode, reference.purpose = "friction", reference.z_scale = 5.0, reference.z_offset = 1.0;
    const RoadMap map = map_with(reference);
    const RoadCrgs crgs(map, folder.path.string());
    EXPECT_NEAR(laid(crgs, map, 10.0, 0.0).friction, 0.4, digits) << "zScale and zOffset do not count";
    EXPECT_EQ(laid(crgs, map, 10.0, 0.0).z, own_z(map, 10.0, 0.0));
    EXPECT_EQ(crgs.notes().size(), std::string(mode) == "attached" ? 1U : 0U);
  }
}

TEST(RoadCrgs, what_replaces_comes_before_what_adds) {
  const Folder folder;
  write_grid(folder.path / "a.crg", [](double, double) { return 1.0; });
  write_grid(folder.path / "b.crg", [](double, double) { return 40.0; });
  SurfaceCrg reference;
  reference.mode = "attached";
  RoadMap map = map_with(reference);
  map.roads[0].surface.push_back(map.roads[0].surface[0]);
  map.roads[0].surface[1].file = "b.crg", map.roads[0].surface[1].mode = "attached0";
  EXPECT_NEAR(laid(RoadCrgs(map, folder.path.string()), map, 10.0, 0.0).z, 41.0, digits);
}

TEST(RoadCrgs, where_the_file_has_no_height_the_road_stays) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves, "$ROAD_CRG_OPTS\nBORDER_MODE_U = 0\nBORDER_MODE_V = 0\n$ROAD_CRG\n");
  SurfaceCrg reference;
  reference.mode = "attached0";
  const RoadMap map = map_with(reference);
  const RoadCrgs crgs(map, folder.path.string());
  EXPECT_EQ(laid(crgs, map, 25.0, 0.0).z, own_z(map, 25.0, 0.0)) << "behind the last row";
  EXPECT_EQ(laid(crgs, map, 10.0, 2.5).z, own_z(map, 10.0, 2.5)) << "beside the grid";
  EXPECT_NEAR(laid(crgs, map, 10.0, 1.0).z, waves(10.0, 1.0), digits);
}

/// Heights, normals and friction of find() and at(); the normal against differences of the height.
TEST(RoadCrgs, query_answers_with_what_is_laid_on_its_roads) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves);
  write_grid(folder.path / "f.crg", [](double u, double) { return 0.3 + 0.01 * u; });
  for (const char* mode : {"attached", "genuine"}) {
    SurfaceCrg reference;
    reference.mode = mode, reference.z_offset = std::string(mode) == "genuine" ? 50.0 : 0.0, reference.s_end = 20.0;
    RoadMap map = map_with(reference);
    SurfaceCrg friction = map.roads[0].surface[0];
    friction.file = "f.crg", friction.mode = "attached0", friction.purpose = "friction";
    map.roads[0].surface.push_back(friction);
    load_crgs(map, (folder.path / "roads.xodr").string());
    const RoadQuery query(map);
    for (const double s : {3.3, 7.9, 12.1})
      for (const double t : {-0.85, 0.6, 1.15}) {
        const RoadPlace place = place_at(map.roads[0], s, t);
        const double own = own_z(map, s, t);
        Cursor cursor;
        const auto z_at = [&](double dx, double dy) { return query.find(place.x + dx, place.y + dy, own, cursor)->z; };
        const auto hit = query.find(place.x, place.y, own, cursor);
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->z, laid(*map.crgs, map, s, t).z, 2e-5) << mode << " " << s << " " << t;
        EXPECT_NEAR(*query.find_height(place.x, place.y, own, cursor), hit->z, 1e-12);
        EXPECT_NEAR(query.at(0, s, t)->z, hit->z, 1e-6);
        EXPECT_NEAR(hit->friction, 0.3 + 0.01 * s, 1e-5);
        const double h = 1e-4, zx = (z_at(h, 0.0) - z_at(-h, 0.0)) / (2.0 * h),
                     zy = (z_at(0.0, h) - z_at(0.0, -h)) / (2.0 * h);
        EXPECT_NEAR(-hit->normal[0] / hit->normal[2], zx, 2e-4) << mode << " " << s << " " << t;
        EXPECT_NEAR(-hit->normal[1] / hit->normal[2], zy, 2e-4) << mode << " " << s << " " << t;
        EXPECT_NEAR(std::hypot(hit->normal[0], hit->normal[1], hit->normal[2]), 1.0, 1e-12);
      }
    const RoadPlace beyond = place_at(map.roads[0], 25.0, 0.5);
    Cursor cursor;
    EXPECT_NEAR(query.find(beyond.x, beyond.y, 50.0, cursor)->z, own_z(map, 25.0, 0.5), 1e-4) << "behind sEnd";
    EXPECT_EQ(query.find(beyond.x, beyond.y, 50.0, cursor)->friction, 1.0);
  }
}

TEST(RoadCrgs, step_where_a_file_ends_within_a_road_is_found) {
  const Folder folder;
  write_grid(folder.path / "a.crg", [](double u, double v) { return u > 12.0 ? 0.03 + 0.005 * v : 0.0; });
  SurfaceCrg reference;
  reference.mode = "attached", reference.s_start = 4.0, reference.s_end = 20.0;
  const RoadMap map = map_with(reference);
  const RoadCrgs crgs(map, folder.path.string());
  const std::vector<CrgStep> steps = find_crg_steps(map, crgs, 0.001);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].s, 20.0);
  EXPECT_NEAR(steps[0].step_m, 0.04, 1e-4) << "at the left border of the grid";
  EXPECT_TRUE(find_crg_steps(map, crgs, 0.05).empty());
}

TEST(RoadCrgs, files_lie_beside_the_xodr) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves);
  SurfaceCrg reference;
  reference.mode = "attached";
  RoadMap map = map_with(reference);
  load_crgs(map, (folder.path / "roads.xodr").string());
  ASSERT_TRUE(map.crgs);
  EXPECT_TRUE(map.crgs->on(0));
  map.roads[0].surface.clear();
  load_crgs(map, "roads.xodr");
  EXPECT_TRUE(map.crgs->empty());
}

TEST(RoadCrgs, what_says_nothing_known_is_refused) {
  const Folder folder;
  write_grid(folder.path / "a.crg", waves);
  const auto expect_refused = [&](const RoadMap& map, const char* what) {
    try {
      const RoadCrgs crgs(map, folder.path.string());
      ADD_FAILURE() << what << " is taken";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
      EXPECT_THAT(error.what(), HasSubstr("road 7: "));
    }
  };
  SurfaceCrg reference;
  reference.mode = "laid";
  expect_refused(map_with(reference), "mode 'laid'");
  reference.mode = "attached", reference.orientation = "left";
  expect_refused(map_with(reference), "orientation 'left'");
  RoadMap missing_file = map_with({});
  missing_file.roads[0].surface[0].file = "none.crg";
  expect_refused(missing_file, "none.crg: cannot be opened");
  missing_file.roads[0].surface[0].file = "/dev/zero";  // has no end
  expect_refused(missing_file, "/dev/zero: is no file");
  missing_file.roads[0].surface[0].file = "none.crg";
  std::ofstream(folder.path / "none.crg") << "$CT\n$ROAD_CRG\nREFERENCE_LINE_INCREMENT = x\n";
  expect_refused(missing_file, "none.crg: line 3: 'x'");
  write_grid(folder.path / "none.crg", waves, "$ROAD_CRG_OPTS\nBORDER_MODE_U = 9\n$ROAD_CRG\n");
  expect_refused(missing_file, "none.crg: option border_mode_u");
  reference = {};
  reference.purpose = "colour";
  const RoadCrgs odd(map_with(reference), folder.path.string());
  EXPECT_FALSE(odd.on(0));
  EXPECT_THAT(odd.notes().at(0), HasSubstr("'colour'"));
}

}  // namespace
}  // namespace roadquery

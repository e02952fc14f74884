// SPDX-License-Identifier: Apache-2.0
// OpenCRG surfaces of roads against the roads' own surface.

#include "orthodrive/network/crg/sample_crg.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "roadquery/make_road.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

using roadquery::Road;

/// In UTM: line, clothoid, arc of 25 m radius, paramPoly3; hill, banking into the bend, crown that fades out, lanes
/// that widen and lie off the middle.
Road winding_road() {
  using namespace roadquery;
  Road road = roadquery::test::make_road(4, {0.0, 345678.25, 6391234.5, 1.1, 30.0, Line{}}, 0.0, 3.0);
  roadquery::test::append(road, 25.0, Spiral{0.0, 0.04});
  roadquery::test::append(road, 20.0, Arc{0.04});
  roadquery::test::append(road, 25.0, Spiral{0.04, -0.01});
  roadquery::test::append(road, 40.0, ParamPoly3{.b_u = 1.0, .c_v = -0.005, .d_v = 6e-5, .normalized = false});
  const double length = road.length;
  road.elevation = {{.s = 0.0, .a = 41.5, .b = 0.06, .c = -1e-3, .d = 5e-6},
                    {.s = 80.0, .a = 42.46, .b = -0.004, .c = 2e-4}};
  road.superelevation = {{.s = 0.0, .a = 0.0, .b = 0.0, .c = 1e-5, .d = 1e-7},
                         {.s = 60.0, .a = 0.0576, .b = 2.28e-3, .c = -4e-5}};
  for (const double s : {0.0, 40.0, 70.0, length}) {
    const double fall = s < 60.0 ? 0.025 : 0.0;
    road.shape.push_back({s, -30.0, -30.0 * fall, fall, 0.0, 0.0});
    road.shape.push_back({s, 0.0, 0.0, -fall, 0.0, 0.0});
  }
  road.lane_offset = {{.s = 0.0, .a = 0.0, .b = 0.0, .c = 5e-5}};
  road.sections[0].left[0].width = {{.s = 0.0, .a = 3.0}, {.s = 50.0, .a = 3.0, .c = 4e-4}};
  return road;
}

/// Largest difference in height from the road's surface, over random places of the grid, at the places in the plane.
double worst_height_error(const Road& road, const CrgSurface& surface, int places = 4000) {
  roadquery::RoadMap map;
  map.roads = {road};
  const roadquery::RoadQuery query(map);
  roadquery::Cursor cursor;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(surface.u_start_m, surface.u_end_m()), share(0.0, 1.0);
  double worst = 0.0;
  int compared = 0;
  for (int i = 0; i < places; ++i) {
    const double at = u(random);
    const roadquery::Edges edges = roadquery::road_edges(road, at);
    const CrgUv uv{at, edges.right_t * 0.99 + (edges.left_t - edges.right_t) * 0.98 * share(random)};
    const double z = crg_height(surface, uv);
    const Vec2 p = crg_xy(surface, uv);
    const auto hit = query.find(p.x, p.y, z, cursor);
    if (!hit) continue;  // a few millimetres beyond an end of the road
    if (roadquery::position_over(road, p.x, p.y, at).beyond_m != 0.0) continue;  // there the query's goes on level
    EXPECT_FALSE(std::isnan(z)) << "hole at u " << uv.u_m << " v " << uv.v_m;
    worst = std::max(worst, std::abs(hit->z - z));
    ++compared;
  }
  EXPECT_GT(compared, places * 9 / 10);
  return worst;
}

TEST(SampleCrg, reproduces_the_surface_within_a_millimetre) {
  const Road road = winding_road();
  for (const CrgFormat format : {CrgFormat::krbi, CrgFormat::kdbi, CrgFormat::lrfi, CrgFormat::ldfi}) {
    const CrgSurface surface = sample_crg(road, {.format = format});
    const double worst = worst_height_error(road, surface);
    EXPECT_LT(worst, 1e-3) << name_of(format);
    RecordProperty(std::string("worst_") + name_of(format), std::to_string(worst));
  }
}

TEST(SampleCrg, error_falls_with_the_square_of_the_step) {
  Road road = winding_road();
  road.shape.clear();  // kinks of a crown lie on a column
  const auto worst = [&](double step) {
    return worst_height_error(road, sample_crg(road, {.u_step_m = step, .v_step_m = 0.25, .format = CrgFormat::kdbi}));
  };
  const double coarse = worst(4.0), fine = worst(1.0);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, coarse / 10.0);
}

TEST(SampleCrg, a_tight_turn_over_a_crest_takes_smaller_steps) {
  using namespace roadquery;
  Road road = roadquery::test::make_road(4, {0.0, 345678.25, 6391234.5, 1.1, 10.0, Arc{-0.2}}, 41.5, 3.0);
  road.elevation = {{.s = 0.0, .a = 41.5, .b = 0.1, .c = -0.02}};
  road.superelevation = {{.s = 0.0, .a = 0.05, .b = -0.004}};
  const CrgSurface as_asked = sample_crg(road), fine = sample_crg(road, {.tolerance_m = 0.0005});
  EXPECT_GT(worst_height_error(road, as_asked), 1e-3) << "else this is no test";
  EXPECT_LT(worst_height_error(road, fine), 1e-3);
  EXPECT_GT(fine.rows(), as_asked.rows());
  const Road gentle = winding_road();
  EXPECT_EQ(sample_crg(gentle, {.tolerance_m = 0.001}).rows(), sample_crg(gentle).rows());
}

TEST(SampleCrg, surface_read_from_its_file_is_that_of_the_road) {
  const Scratch scratch;
  const Road road = winding_road();
  for (const CrgFormat format : {CrgFormat::krbi, CrgFormat::kdbi, CrgFormat::lrfi, CrgFormat::ldfi}) {
    io::write_crg(scratch / "a.crg", sample_crg(road, {.format = format}), format);
    const io::CrgFile file = io::read_crg(scratch / "a.crg");
    EXPECT_TRUE(file.notes.empty());
    EXPECT_LT(worst_height_error(road, file.surface), 1e-3) << name_of(format);
  }
}

TEST(SampleCrg, reference_line_has_its_points_on_the_roads) {
  const Road road = winding_road();
  double arc_m = 0.0;  // more than road.length: the parameter of the paramPoly3 is not its arc length
  for (int i = 0; i < 14000; ++i) {
    const auto a = roadquery::reference_point(road, road.length * i / 14000.0);
    const auto b = roadquery::reference_point(road, road.length * (i + 1) / 14000.0);
    arc_m += std::hypot(b.x - a.x, b.y - a.y);
  }
  EXPECT_GT(arc_m, road.length + 0.1);
  for (const CrgFormat format : {CrgFormat::krbi, CrgFormat::kdbi, CrgFormat::lrfi}) {
    const CrgSurface s = sample_crg(road, {.format = format});
    EXPECT_LE(s.u_increment_m, 0.5);
    EXPECT_NEAR(s.u_end_m(), arc_m, 0.02);
    EXPECT_LT(s.u_end_m(), arc_m);
    const roadquery::PlanPoint end = roadquery::reference_point(road, road.length);
    EXPECT_NEAR(std::hypot(s.x_m.back() - end.x, s.y_m.back() - end.y), 0.0, 1e-6);
    EXPECT_NEAR(s.z_m.back(), roadquery::elevation(road, road.length), 1e-6);
    roadquery::RoadMap map;
    map.roads = {road};
    const roadquery::RoadQuery query(map);
    roadquery::Cursor cursor;
    for (std::size_t i = 0; i < s.rows(); ++i) {
      const auto hit = query.find(s.x_m[i], s.y_m[i], s.z_m[i], cursor);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->t, 0.0, 1e-6);
      EXPECT_NEAR(hit->z, s.z_m[i], 1e-6);
      EXPECT_NEAR(
          s.banking[i],
          std::tan(roadquery::superelevation(road, hit->s)) * std::hypot(1.0, roadquery::gradient(road, hit->s)), 1e-6);
    }
  }
}

TEST(SampleCrg, plane_road_has_nothing_in_its_grid) {
  Road road = roadquery::test::make_road(1, {0.0, 10.0, 20.0, 0.3, 33.3, roadquery::Line{}}, 5.0, 3.05);
  road.superelevation = {{.s = 0.0, .a = 0.03}};
  road.elevation = {{.s = 0.0, .a = 5.0, .b = 0.02}};
  const CrgSurface s = sample_crg(road, {.v_step_m = 0.25, .format = CrgFormat::kdbi});
  EXPECT_EQ(s.rows(), 68u);  // 33.3 m in steps of 0.5 m at most
  EXPECT_NEAR(s.u_increment_m, 33.3 / 67.0, 1e-9);
  EXPECT_EQ(s.v_m.front(), -3.25);
  EXPECT_EQ(s.v_m.back(), 3.25);
  for (const double z : s.grid_m) EXPECT_NEAR(z, 0.0, 1e-9);
  const roadquery::SurfaceCrg reference = crg_reference(road, s, "a.crg");
  EXPECT_EQ(reference.mode, "genuine");
  EXPECT_EQ(reference.s_end, road.length);
  EXPECT_NEAR(reference.h_offset, 0.0, 1e-12);
}

TEST(SampleCrg, reference_turns_by_half_the_bend_of_the_first_step) {
  const Road road = roadquery::test::make_road(1, {0.0, 10.0, 20.0, 3.1, 30.0, roadquery::Arc{0.05}}, 5.0);
  const CrgSurface s = sample_crg(road, {.format = CrgFormat::kdbi});
  EXPECT_NEAR(crg_reference(road, s, "a.crg").h_offset, 0.5 * 0.05 * 0.5, 1e-7);
}

TEST(SampleCrg, relief_is_added_where_the_road_has_it) {
  const Road road = winding_road();
  const auto bump = [](double s, double t) { return 0.01 * std::sin(s) * std::cos(2.0 * t); };
  const CrgSurface plain = sample_crg(road, {.format = CrgFormat::kdbi});
  const CrgSurface rough = sample_crg(road, {.format = CrgFormat::kdbi, .relief_m = bump});
  ASSERT_EQ(rough.grid_m.size(), plain.grid_m.size());
  EXPECT_EQ(rough.z_m, plain.z_m) << "the reference line is the road's";
  for (const double u : {5.0, 40.0, 100.0})
    for (const double v : {-2.0, 0.0, 1.5}) {
      const auto row = static_cast<std::size_t>(std::round(u / rough.u_increment_m));
      const auto column =
          static_cast<std::size_t>(std::lower_bound(rough.v_m.begin(), rough.v_m.end(), v - 1e-9) - rough.v_m.begin());
      const double s = static_cast<double>(row) * rough.u_increment_m;
      EXPECT_NEAR(rough.grid(row, column) - plain.grid(row, column), bump(s, v), 5e-4) << u << " " << v;
    }
}

TEST(SampleCrg, places_far_off_the_carriageway_are_missing) {
  Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 60.0, roadquery::Line{}});
  road.sections[0].left[0].width = {{.s = 0.0, .a = 3.0}, {.s = 30.0, .a = 3.0, .b = 0.1}};
  const CrgSurface s = sample_crg(road, {.v_step_m = 0.5});
  EXPECT_TRUE(std::isnan(crg_height(s, {10.0, 5.0})));
  EXPECT_EQ(crg_height(s, {10.0, 3.0}), 0.0);
  EXPECT_EQ(crg_height(s, {59.0, 5.8}), 0.0);
}

TEST(SampleCrg, road_of_one_step_and_road_without_length) {
  Road road = roadquery::test::make_road(1, {0.0, 0.0, 0.0, 0.0, 0.2, roadquery::Line{}}, 2.0);
  const CrgSurface s = sample_crg(road);
  EXPECT_EQ(s.rows(), 2u);
  EXPECT_NEAR(crg_height(s, {0.1, 1.0}), 2.0, 1e-6);
  road.length = 0.0;
  EXPECT_THROW((void)sample_crg(road), Error);
}

}  // namespace
}  // namespace orthodrive

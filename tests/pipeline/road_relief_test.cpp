// SPDX-License-Identifier: Apache-2.0
// Roughness that a drive measured, in the OpenCRG files of the network.

#include "orthodrive/pipeline/stages/road_relief.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>

#include "app/run_tool.hpp"
#include "io/scratch.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "roadquery/crg/road_crgs.hpp"
#include "roadquery/query/road_query.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive {
namespace {

/// Two ways end to end and one that leaves where they meet, level; the second is drawn against the first.
RoadNetwork crossroads() {
  const auto way = [](std::int64_t id, Vec2 a, Vec2 b, std::int64_t node_a, std::int64_t node_b) {
    RoadPath path{.osm_id = id, .highway = "tertiary"};
    const int steps = static_cast<int>(distance(a, b) / 2.0);
    for (int i = 0; i <= steps; ++i)
      path.nodes.push_back(
          {.p = a + (b - a) * (static_cast<double>(i) / steps), .s_m = 2.0 * i, .width_m = 7.0, .z_m = 20.0});
    path.nodes.front().osm_node = node_a, path.nodes.back().osm_node = node_b;
    return path;
  };
  const Vec2 o{500000.0, 5500000.0};
  return {Crs{"EPSG:32633"},
          {way(1, o, o + Vec2{400, 0}, 1, 2), way(2, o + Vec2{800, 0}, o + Vec2{400, 0}, 3, 2),
           way(3, o + Vec2{400, 0}, o + Vec2{400, 300}, 2, 4)}};
}

/// G_d(n0) of a line of heights `step_m` apart, by the power between 0.1 and 0.8 cycles/m (discrete Fourier transform
/// under Hann's window) of a spectrum gd (n / 0.1)^-w.
double gd_of(const std::vector<double>& z, double step_m, double w) {
  const auto n = z.size();
  constexpr double low = 0.1, high = 0.8;
  double power = 0.0;
  for (std::size_t k = 1; k < n / 2; ++k) {
    const double wave_number = static_cast<double>(k) / (static_cast<double>(n) * step_m);
    if (wave_number < low || wave_number >= high) continue;
    double re = 0.0, im = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double hann =
          0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(k * i % n) / static_cast<double>(n);
      re += hann * z[i] * std::cos(angle), im += hann * z[i] * std::sin(angle);
    }
    power += 2.0 * (re * re + im * im) / (0.375 * static_cast<double>(n)) / static_cast<double>(n);
  }
  return power / (std::pow(0.1, w) * (std::pow(low, 1.0 - w) - std::pow(high, 1.0 - w)) / (w - 1.0));
}

TEST(RoadRelief, spectrum_of_the_written_surface_has_the_measured_class) {
  for (const auto& [road_class, w] :
       {std::pair{'A', 2.0}, std::pair{'C', 2.0}, std::pair{'E', 1.6}, std::pair{'C', 2.5}}) {
    const Scratch scratch;
    const double gd = iso_8608_mean_m3(road_class);
    io::write_roads(
        scratch / "roads.gpkg", crossroads(),
        {{.osm_id = 1, .s_begin_m = 0.0, .s_end_m = 200.0, .iso_8608_class = road_class, .gd_n0_m3 = gd, .waviness = w},
         {.osm_id = 1,
          .s_begin_m = 200.0,
          .s_end_m = 400.0,
          .iso_8608_class = road_class,
          .gd_n0_m3 = gd,
          .waviness = w}});
    const ToolRun run =
        run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "x.xodr").string(), "--crg",
                  "way/1", "--crg-u-step", "0.25", "--crg-v-step", "0.5"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const roadquery::RoadMap map = roadquery::read_opendrive((scratch / "x.xodr").string());
    double sum = 0.0;
    int lines = 0;
    for (const roadquery::Road& road : map.roads) {
      if (road.surface.empty() || road.length < 300.0) continue;
      const CrgSurface surface = io::read_crg(scratch.folder() / road.surface[0].file).surface;
      for (const double v : {-2.5, -1.5, -0.5, 0.5, 1.5, 2.5}) {
        std::vector<double> z;
        for (double u = 20.0; u < 360.0; u += 0.25) z.push_back(crg_height(surface, {u, v}));
        sum += gd_of(z, 0.25, w), ++lines;
      }
    }
    ASSERT_EQ(lines, 6);
    EXPECT_EQ(iso_8608_class(sum / lines), road_class) << w << " " << sum / lines;
    EXPECT_NEAR(std::log(sum / lines / gd), 0.0, 0.25) << road_class << " " << w;
  }
}

TEST(RoadRelief, roads_of_one_way_and_turns_out_of_it_share_one_surface) {
  const RoadNetwork roads = crossroads();
  std::vector<RoughnessStretch> roughness;
  for (const std::int64_t id : {1, 2, 3})
    roughness.push_back({.osm_id = id, .s_end_m = id == 3 ? 300.0 : 400.0, .gd_n0_m3 = 256e-6});
  const Scratch scratch;
  io::write_roads(scratch / "roads.gpkg", roads);
  ASSERT_EQ(run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "x.xodr").string()})
                .exit_code,
            0);
  const roadquery::RoadMap map = roadquery::read_opendrive((scratch / "x.xodr").string());
  const RoadRelief relief(roads, roughness, 0.2);
  int joints = 0;
  for (const roadquery::Road& road : map.roads) {
    const auto height = relief.of(map, road);
    ASSERT_TRUE(height) << road.id;
    for (const bool at_end : {false, true}) {
      const roadquery::RoadLink& link = at_end ? road.successor : road.predecessor;
      if (link.kind != roadquery::LinkKind::road) continue;
      const roadquery::Road& other =
          *std::find_if(map.roads.begin(), map.roads.end(), [&](const auto& r) { return r.id == link.id; });
      const auto beyond = relief.of(map, other);
      const bool to_end = link.contact == roadquery::ContactPoint::end;
      for (const double t : {-2.0, -0.5, 1.0})
        EXPECT_NEAR(height(at_end ? road.length : 0.0, t),
                    beyond(to_end ? other.length : 0.0, at_end == to_end ? -t : t), 1e-6)
            << road.id << " " << other.id;
      ++joints;
    }
  }
  EXPECT_GE(joints, 12);
  double most = 0.0;
  for (const roadquery::Road& road : map.roads)
    if (road.junction < 0) most = std::max(most, std::abs(relief.of(map, road)(0.5 * road.length, 1.0)));
  EXPECT_GT(most, 0.002) << "there is something to agree on";
}

/// The height that the query gives is the file's: the road's own surface with the relief, within the file's digits.
TEST(RoadRelief, query_answers_with_the_relief_that_the_network_wrote) {
  const Scratch scratch;
  const std::vector<RoughnessStretch> roughness{{.osm_id = 1, .s_end_m = 400.0, .gd_n0_m3 = 256e-6}};
  const RoadNetwork roads = crossroads();
  io::write_roads(scratch / "roads.gpkg", roads, roughness);
  const ToolRun run =
      run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "x.xodr").string(), "--crg",
                "way/1", "--crg-u-step", "0.25", "--crg-v-step", "0.25"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  roadquery::RoadMap map = roadquery::read_opendrive((scratch / "x.xodr").string());
  const RoadRelief relief(roads, roughness, 0.5);
  const roadquery::RoadQuery smooth(map);
  roadquery::load_crgs(map, (scratch / "x.xodr").string());
  EXPECT_TRUE(map.crgs->notes().empty());
  const roadquery::RoadQuery rough(map);
  int places = 0;
  double most = 0.0;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const roadquery::Road& road = map.roads[i];
    if (road.surface.empty() || road.length < 100.0) continue;
    const auto height = relief.of(map, road);
    const CrgSurface surface = io::read_crg(scratch.folder() / road.surface[0].file).surface;
    for (double s = 20.0; s < road.length - 20.0; s += 1.37)
      for (const double t : {-2.6, -1.1, 0.4, 1.9}) {
        const roadquery::SurfacePoint p = roadquery::surface_point(road, s, t);
        roadquery::Cursor cursor;
        const auto hit = rough.find(p.x, p.y, p.z, cursor);
        ASSERT_TRUE(hit);
        // The road is straight: u is s.
        EXPECT_NEAR(hit->z, crg_height(surface, {s, t}), 2e-6) << road.id << " " << s << " " << t;
        EXPECT_NEAR(hit->z, *smooth.find_height(p.x, p.y, p.z, cursor) + height(s, t), 0.01) << "between the rows";
        most = std::max(most, std::abs(hit->z - p.z)), ++places;
      }
    const double s = 0.25 * std::round(0.5 * road.length / 0.25), t = 0.75;
    EXPECT_NEAR(rough.at(i, s, t)->z, roadquery::surface_point(road, s, t).z + height(s, t), 2e-3) << "near a row";
  }
  EXPECT_GT(places, 500);
  EXPECT_GT(most, 0.005) << "there is something to feel";
}

TEST(RoadRelief, ways_that_nobody_drove_stay_smooth_and_the_same_input_gives_the_same_surface) {
  const RoadNetwork roads = crossroads();
  const Scratch scratch;
  io::write_roads(scratch / "roads.gpkg", roads);
  ASSERT_EQ(run_tool({"network", "--roads", (scratch / "roads.gpkg").string(), "-o", (scratch / "x.xodr").string()})
                .exit_code,
            0);
  const roadquery::RoadMap map = roadquery::read_opendrive((scratch / "x.xodr").string());
  const std::vector<RoughnessStretch> one{{.osm_id = 1, .s_end_m = 400.0, .gd_n0_m3 = 64e-6}};
  const RoadRelief a(roads, one, 0.2), b(roads, one, 0.2);
  for (const roadquery::Road& road : map.roads) {
    if (road.osm_id == "2" || road.osm_id == "3") {
      EXPECT_FALSE(a.of(map, road)) << road.id;
    } else if (road.osm_id == "1") {
      EXPECT_EQ(a.of(map, road)(100.3, 0.7), b.of(map, road)(100.3, 0.7));
    }
  }
}

/// A slab of 5 cm that ends in the middle of a road.
TEST(RoadRelief, drive_reports_where_a_file_ends_with_a_step) {
  const Scratch scratch;
  std::string crg = "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 50\nLONG_SECTION_V_INCREMENT = 8\n$KD_DEFINITION\n#:LRFI\n";
  crg += "D:long section 1,m\nD:long section 2,m\n$$$$\n";
  for (int row = 0; row < 7; ++row) crg += "  0.050000  0.050000\n";
  std::ofstream(scratch / "slab.crg") << crg;
  std::ofstream(scratch / "x.xodr") << R"(<OpenDRIVE><header revMajor="1" revMinor="7"/>
<road id="4" length="300" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="300"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center><right><lane id="-1" type="driving">
<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
<surface><CRG file="slab.crg" sStart="0" sEnd="180" mode="attached" purpose="elevation"/></surface></road></OpenDRIVE>)";
  const ToolRun run = run_tool({"drive", "--network", (scratch / "x.xodr").string(), "-o", (scratch / "out").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE((run.out + run.err).find("drive.crg_step at 180.0, "), std::string::npos) << run.out << run.err;
  EXPECT_NE((run.out + run.err).find("a step of 0.050 m at s = 180.0 m"), std::string::npos);
}

}  // namespace
}  // namespace orthodrive

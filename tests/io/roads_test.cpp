// SPDX-License-Identifier: Apache-2.0
// roads.gpkg out and in.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <map>
#include <numbers>
#include <thread>
#include <tuple>

#include "cpu_seconds.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/ogr_support.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "paths.hpp"
#include "places.hpp"
#include "sanitized.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

RoadNetwork two_roads() {
  RoadNetwork roads{.crs = utm33};
  RoadPath& main = roads.paths.emplace_back(RoadPath{.osm_id = 123456789012345,
                                                     .part = 1,
                                                     .highway = "primary",
                                                     .name = "Štross \"A\"",
                                                     .layer = 1,
                                                     .bridge = true,
                                                     .oneway = Oneway::forward,
                                                     .lanes = 2});
  for (int i = 0; i < 12; ++i)
    main.nodes.push_back({.p = origin + Vec2{2.0 * i, std::sin(0.3 * i)},
                          .osm_node = i == 0 ? 77 : 0,
                          .s_m = 2.0 * i,
                          .offset_m = 0.1 * i,
                          .width_m = 6.0 + 0.01 * i,
                          .sigma_offset_m = 0.3,
                          .sigma_width_m = 0.4,
                          .z_m = 200.0 + i / 3.0,
                          .gradient = 0.01,
                          .banking = -0.02,
                          .crown = 0.001 * i,
                          .sigma_z_m = 0.1,
                          .sigma_banking = 0.004,
                          .banking_source = BankingSource::dtm,
                          .kerb_radius_m = i == 0 ? 7.25 : 0.0});
  RoadPath& raw = roads.paths.emplace_back(RoadPath{.osm_id = 5, .highway = "service", .roundabout = true});
  raw.lanes_forward = 2, raw.lanes_backward = 1;
  raw.turn_forward = "left|through;right", raw.turn_backward = "none";
  raw.speed_limit_kmh = 48.28032, raw.sidewalk = Sides::right, raw.shoulder = Sides::both, raw.surface = "asphalt";
  raw.known_surface = {SurfaceClass::setts, SurfaceSource::photo};  // not what the tag says: the columns count
  roads.restrictions = {{5, 77, 123456789012345, true}, {123456789012345, 77, 5, false, {-8, 123456789012346}}};
  roads.signs = {{77, NodeSignKind::stop, -1},
                 {78, NodeSignKind::zebra, 0},
                 {79, NodeSignKind::mini_roundabout, 0, "clockwise", 17.5},
                 {80, NodeSignKind::barrier, 0, "gate", 0.0, true}};
  raw.traffic_calming = "table";
  raw.lanes_both_ways = 1, raw.widths_forward = "3.5|", raw.widths_backward = "3.3528", raw.widths_both_ways = "2.75";
  raw.nodes = {{.p = origin, .osm_node = 77, .width_m = 4.0},
               {.p = origin + Vec2{0, 30}, .s_m = 30.0, .width_m = 4.0}};  // no heights yet
  return roads;
}

void expect_same(const RoadNetwork& a, const RoadNetwork& b) {
  EXPECT_EQ(a.crs, b.crs);
  ASSERT_EQ(a.restrictions.size(), b.restrictions.size());
  for (std::size_t i = 0; i < a.restrictions.size(); ++i) {
    const TurnRestriction &p = a.restrictions[i], &q = b.restrictions[i];
    EXPECT_EQ(std::tie(p.from_way, p.via_node, p.to_way, p.only, p.via_ways),
              std::tie(q.from_way, q.via_node, q.to_way, q.only, q.via_ways));
  }
  ASSERT_EQ(a.signs.size(), b.signs.size());
  for (std::size_t i = 0; i < a.signs.size(); ++i) {
    const NodeSign &p = a.signs[i], &q = b.signs[i];
    EXPECT_EQ(std::tie(p.osm_node, p.kind, p.direction, p.value, p.size_m, p.closed),
              std::tie(q.osm_node, q.kind, q.direction, q.value, q.size_m, q.closed));
  }
  ASSERT_EQ(a.paths.size(), b.paths.size());
  for (std::size_t i = 0; i < a.paths.size(); ++i) {
    const RoadPath &p = a.paths[i], &q = b.paths[i];
    EXPECT_EQ(
        std::tie(p.osm_id, p.part, p.highway, p.name, p.layer, p.bridge, p.tunnel, p.oneway, p.lanes, p.roundabout),
        std::tie(q.osm_id, q.part, q.highway, q.name, q.layer, q.bridge, q.tunnel, q.oneway, q.lanes, q.roundabout));
    EXPECT_EQ(std::tie(p.traffic_calming, p.lanes_both_ways, p.widths_forward, p.widths_backward, p.widths_both_ways),
              std::tie(q.traffic_calming, q.lanes_both_ways, q.widths_forward, q.widths_backward, q.widths_both_ways));
    EXPECT_EQ(std::tie(p.lanes_forward, p.lanes_backward, p.turn_forward, p.turn_backward, p.speed_limit_kmh,
                       p.sidewalk, p.shoulder, p.surface),
              std::tie(q.lanes_forward, q.lanes_backward, q.turn_forward, q.turn_backward, q.speed_limit_kmh,
                       q.sidewalk, q.shoulder, q.surface));
    EXPECT_EQ(p.known_surface.surface, q.known_surface.surface);
    EXPECT_EQ(p.known_surface.source, q.known_surface.source);
    ASSERT_EQ(p.nodes.size(), q.nodes.size());
    for (std::size_t k = 0; k < p.nodes.size(); ++k) {
      const RoadNode &m = p.nodes[k], &n = q.nodes[k];
      EXPECT_EQ(m.p, n.p);
      EXPECT_EQ(std::tie(m.osm_node, m.s_m, m.offset_m, m.width_m, m.sigma_offset_m, m.sigma_width_m, m.gradient,
                         m.banking, m.crown, m.sigma_z_m, m.sigma_banking, m.banking_source, m.kerb_radius_m),
                std::tie(n.osm_node, n.s_m, n.offset_m, n.width_m, n.sigma_offset_m, n.sigma_width_m, n.gradient,
                         n.banking, n.crown, n.sigma_z_m, n.sigma_banking, n.banking_source, n.kerb_radius_m));
      EXPECT_TRUE(m.z_m == n.z_m || (std::isnan(m.z_m) && std::isnan(n.z_m)));
    }
  }
}

TEST(Roads, come_back_as_written) {
  const Scratch scratch;
  io::write_roads(scratch / "roads.gpkg", two_roads());
  expect_same(two_roads(), io::read_roads(scratch / "roads.gpkg"));
  EXPECT_EQ(scratch.file_count(), 1) << "no journal left";
}

TEST(Roads, measured_roughness_comes_back_in_order) {
  const Scratch scratch;
  const RoadNetwork roads = two_roads();
  const RoughnessStretch late{.osm_id = 123456789012345,
                              .part = 1,
                              .s_begin_m = 11.0,
                              .s_end_m = 22.0,
                              .iso_8608_class = 'C',
                              .gd_n0_m3 = 2e-4,
                              .waviness = 1.7,
                              .sigma_ln_gd = 0.5};
  RoughnessStretch early = late;
  early.s_begin_m = 0.0, early.s_end_m = 11.0, early.gd_n0_m3 = 1e-5, early.iso_8608_class = 'A';
  io::write_roads(scratch / "roads.gpkg", roads, {late, early});
  expect_same(roads, io::read_roads(scratch / "roads.gpkg"));
  const auto back = io::read_roughness(scratch / "roads.gpkg");
  ASSERT_EQ(back.size(), 2u);
  const auto fields = [](const RoughnessStretch& r) {
    return std::tie(r.osm_id, r.part, r.s_begin_m, r.s_end_m, r.iso_8608_class, r.gd_n0_m3, r.waviness, r.sigma_ln_gd);
  };
  EXPECT_EQ(fields(back[0]), fields(early));
  EXPECT_EQ(fields(back[1]), fields(late));
  io::write_roads(scratch / "plain.gpkg", roads);
  EXPECT_TRUE(io::read_roughness(scratch / "plain.gpkg").empty());
  RoughnessStretch stray = late;
  stray.osm_id = 4;
  EXPECT_THROW(io::write_roads(scratch / "stray.gpkg", roads, {stray}), Error);
}

TEST(Layers, numbers_and_geometries_come_back) {
  const Scratch scratch;
  Polygon with_hole = rectangle(origin.x, origin.y, origin.x + 40, origin.y + 30);
  with_hole.holes.push_back({origin + Vec2{5, 5}, origin + Vec2{5, 10}, origin + Vec2{10, 10}, origin + Vec2{10, 5}});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  io::write_layers(
      scratch / "a.gpkg",
      {{.name = "areas", .fields = {"area_m2"}, .rows = {{with_hole, {1175.0}}}},
       {.name = "lines", .fields = {"a", "b"}, .rows = {{Polyline{origin, origin + Vec2{10, 3}}, {1.5, nan}}}},
       {.name = "points", .fields = {}, .rows = {{origin + Vec2{1, 2}, {}}}},
       {.name = "nothing", .fields = {"x"}}},
      utm33);
  const std::vector<io::Feature> back = io::read_features(scratch / "a.gpkg", utm33);
  ASSERT_EQ(back.size(), 3u);
  EXPECT_NEAR(area_m2(back[0].polygons.at(0)), 1175.0, 1e-6);
  EXPECT_EQ(std::stod(back[0].tags.at("area_m2")), 1175.0);
  EXPECT_EQ(back[1].lines.at(0), (Polyline{origin, origin + Vec2{10, 3}}));
  EXPECT_EQ(std::stod(back[1].tags.at("a")), 1.5);
  EXPECT_FALSE(back[1].tags.contains("b")) << "NaN is null";
  EXPECT_EQ(back[2].points.at(0), origin + (Vec2{1, 2}));
  EXPECT_EQ(scratch.file_count(), 1) << "no journal left";
  EXPECT_THROW(io::write_layers(scratch / "a.gpkg" / "folder.gpkg", {}, utm33), Error) << "a file is no folder";
  io::write_layers(scratch / "b.gpkg", {{.name = "areas", .fields = {"area_m2"}, .rows = {{with_hole, {1175.0}}}}},
                   utm33);
  io::write_layers(scratch / "c.gpkg", {{.name = "areas", .fields = {"area_m2"}, .rows = {{with_hole, {1175.0}}}}},
                   utm33);
  EXPECT_EQ(bytes_of(scratch / "b.gpkg"), bytes_of(scratch / "c.gpkg")) << "same input, same bytes";
}

TEST(Roads, files_without_the_surface_class_are_read_by_their_tags) {
  const Scratch scratch;
  RoadNetwork roads = two_roads();
  roads.paths[0].highway = "track";
  io::write_roads(scratch / "old.gpkg", roads);
  {
    const io::DatasetPtr dataset = io::open_dataset(scratch / "old.gpkg", GDAL_OF_VECTOR | GDAL_OF_UPDATE);
    OGRLayer& layer = *dataset->GetLayerByName("centrelines");
    for (const char* name : {"surface_class", "surface_source"})
      ASSERT_EQ(layer.DeleteField(layer.GetLayerDefn()->GetFieldIndex(name)), OGRERR_NONE);
  }
  const RoadNetwork read = io::read_roads(scratch / "old.gpkg");
  EXPECT_EQ(read.paths[0].known_surface.surface, SurfaceClass::gravel) << "usual for a track";
  EXPECT_EQ(read.paths[0].known_surface.source, SurfaceSource::highway);
  EXPECT_EQ(read.paths[1].known_surface.surface, SurfaceClass::asphalt) << "its tag";
  EXPECT_EQ(read.paths[1].known_surface.source, SurfaceSource::tag);
}

TEST(Roads, empty_network_is_a_file_too) {
  const Scratch scratch;
  io::write_roads(scratch / "roads.gpkg", {.crs = utm33});
  EXPECT_TRUE(io::read_roads(scratch / "roads.gpkg").paths.empty());
}

TEST(Roads, same_roads_same_bytes_a_second_later) {
  const Scratch scratch;
  io::write_roads(scratch / "a.gpkg", two_roads());
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // GeoPackage's dates have seconds
  io::write_roads(scratch / "b.gpkg", two_roads());
  EXPECT_EQ(bytes_of(scratch / "a.gpkg"), bytes_of(scratch / "b.gpkg"));
}

TEST(Roads, surface_has_the_area_of_the_carriageway) {
  const Scratch scratch;
  RoadNetwork roads{.crs = utm33};
  RoadPath& straight = roads.paths.emplace_back(RoadPath{.osm_id = 1, .highway = "service"});
  straight.nodes = {{.p = origin, .width_m = 4.0}, {.p = origin + Vec2{50, 0}, .s_m = 50.0, .width_m = 4.0}};
  // A hairpin of 3 m radius and 8 m width: the inner edge folds back over itself.
  RoadPath& hairpin = roads.paths.emplace_back(RoadPath{.osm_id = 2, .highway = "service"});
  for (int i = 0; i <= 12; ++i) {
    const double angle = std::numbers::pi * i / 12.0;
    hairpin.nodes.push_back(
        {.p = origin + Vec2{100.0 + 3.0 * std::cos(angle), 3.0 * std::sin(angle)}, .s_m = 3.0 * angle, .width_m = 8.0});
  }
  io::write_roads(scratch / "roads.gpkg", roads);
  std::map<std::string, double> area;
  for (const io::Feature& feature : io::read_features(scratch / "roads.gpkg", utm33))
    for (const Polygon& polygon : feature.polygons) area[feature.tags.at("osm_id")] += area_m2(polygon);
  EXPECT_NEAR(area["1"], 200.0, 1e-6);
  // Half disc of 7 m radius, and what the folded inner edge sweeps on the other side (at most half a disc of 1 m).
  EXPECT_NEAR(area["2"], 0.5 * std::numbers::pi * 49.0, 0.5 * std::numbers::pi + 1.5);
}

TEST(Roads, foreign_or_broken_geopackage_is_refused) {
  const Scratch scratch;
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_roads(scratch / "none.gpkg"); }), HasSubstr("no such file"));
  io::write_geojson(scratch / "a.geojson", {{.lines = {{origin, origin + Vec2{1, 1}}}}}, utm33);
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_roads(scratch / "a.geojson"); }),
              HasSubstr("no layer 'centrelines'"));
  io::write_roads(scratch / "cut.gpkg", two_roads());
  truncate_to(scratch / "cut.gpkg", 0.4);
  EXPECT_THROW((void)io::read_roads(scratch / "cut.gpkg"), InputError);
}

TEST(Roads, unwritable_target_leaves_nothing) {
  const Scratch scratch;
  write_bytes(scratch / "file", "x");
  EXPECT_THROW(io::write_roads(scratch / "file" / "roads.gpkg", two_roads()), Error);
  EXPECT_EQ(scratch.file_count(), 1);
}

TEST(Roads, full_disk_leaves_the_earlier_file_and_nothing_else) {
  const Scratch scratch;
  RoadNetwork many{.crs = utm33};
  for (int i = 0; i < 300; ++i) many.paths.push_back(two_roads().paths[0]), many.paths.back().osm_id = i;
  for (const rlim_t limit : {1000, 100000, 400000}) {
    write_bytes(scratch / "roads.gpkg", "earlier");
    {
      const FileSizeLimit full(limit);
      EXPECT_THAT(message_of<Error>([&] { io::write_roads(scratch / "roads.gpkg", many); }), HasSubstr("disk full"))
          << limit;
    }
    EXPECT_EQ(bytes_of(scratch / "roads.gpkg"), "earlier");
    EXPECT_EQ(scratch.file_count(), 1) << limit;
  }
}

TEST(RealOsm, pardubice_reads_in_two_seconds_and_writes_in_a_few) {
  const fs::path file = paths::in_source("../shared/data/pardubice/roads.osm");
  if (!fs::exists(file)) GTEST_SKIP() << "REAL DATA MISSING: " << file;
  RoadNetwork roads;
  const double seconds = test::least_cpu_seconds(
      3, [&] { roads = io::read_osm_roads(file, lonlat_site(15.72259, 50.01013, 15.78959, 50.05329)); });
  if (!sanitized) {
    EXPECT_LT(seconds, 2.0);
  }
  double total_m = 0.0;
  for (const RoadPath& path : roads.paths) total_m += path.nodes.back().s_m;
  EXPECT_NEAR(total_m, 245e3, 15e3);  // README: 123 km of streets, 122 km of service roads
  const Scratch scratch;
  const double written = test::least_cpu_seconds(1, [&] { io::write_roads(scratch / "roads.gpkg", roads); });
  const double read = test::least_cpu_seconds(1, [&] { expect_same(roads, io::read_roads(scratch / "roads.gpkg")); });
  fmt::print("Pardubice: {} paths, {:.1f} km, read in {:.2f} s, written in {:.2f} s, read again in {:.2f} s\n",
             roads.paths.size(), total_m / 1000.0, seconds, written, read);
}

}  // namespace
}  // namespace orthodrive

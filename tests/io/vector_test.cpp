// Vectors: OSM in, GeoPackage out and in, GeoJSON out and in.

#include "orthodrive/io/vector_io.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <osmium/io/any_input.hpp>
#include <osmium/io/pbf_output.hpp>
#include <thread>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/clip_line.hpp"
#include "orthodrive/io/osm_tags.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

const Crs utm33{"EPSG:32633"};
const Vec2 origin{500000.0, 5540000.0};  // on the central meridian of zone 33, near 50 degrees north

Polygon rectangle(double west, double south, double east, double north) {
  return {{{west, south}, {east, south}, {east, north}, {west, north}}, {}};
}
SiteFrame site_of(double size_m) { return {utm33, rectangle(origin.x, origin.y, origin.x + size_m, origin.y + size_m)}; }

/// An .osm text of nodes given in metres from the origin.
class OsmText {
 public:
  OsmText& node(int id, double x, double y) {
    const Vec2 p = lonlat_from_site_.target_from_source(origin + Vec2{x, y});
    nodes_ += fmt::format("<node id=\"{}\" lon=\"{:.9f}\" lat=\"{:.9f}\"/>\n", id, p.x, p.y);
    return *this;
  }
  OsmText& way(int id, const std::vector<int>& nodes, const io::OsmTags& tags) {
    ways_ += fmt::format("<way id=\"{}\">", id);
    for (const int node : nodes) ways_ += fmt::format("<nd ref=\"{}\"/>", node);
    for (const auto& [key, value] : tags) ways_ += fmt::format("<tag k=\"{}\" v=\"{}\"/>", key, value);
    ways_ += "</way>\n";
    return *this;
  }
  OsmText& raw(const std::string& text) {
    ways_ += text;
    return *this;
  }
  [[nodiscard]] std::string text() const {
    return "<?xml version='1.0' encoding='UTF-8'?>\n<osm version=\"0.6\" generator=\"test\">\n" + nodes_ + ways_ + "</osm>\n";
  }

 private:
  CoordinateTransform lonlat_from_site_{utm33, Crs{"EPSG:4326"}};
  std::string nodes_, ways_;
};

// ---- clipping --------------------------------------------------------------------------------------------------------

TEST(ClipLine, line_inside_stays_whole) {
  const auto pieces = io::clip_line({{1, 1}, {5, 5}, {9, 1}}, rectangle(0, 0, 10, 10));
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].size(), 3u);
  EXPECT_EQ(pieces[0][2].vertex, 2u);
}

TEST(ClipLine, line_that_leaves_and_returns_gives_two_pieces_cut_at_the_border) {
  const auto pieces = io::clip_line({{5, 5}, {15, 5}, {15, 8}, {5, 8}}, rectangle(0, 0, 10, 10));
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].back().p, (Vec2{10, 5}));
  EXPECT_FALSE(pieces[0].back().vertex);
  EXPECT_EQ(pieces[1].front().p, (Vec2{10, 8}));
  EXPECT_EQ(pieces[1].back().vertex, 3u);
}

TEST(ClipLine, segment_across_the_whole_area_without_a_vertex_inside) {
  const auto pieces = io::clip_line({{-5, 4}, {15, 4}}, rectangle(0, 0, 10, 10));
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].front().p, (Vec2{0, 4}));
  EXPECT_EQ(pieces[0].back().p, (Vec2{10, 4}));
}

TEST(ClipLine, segment_over_a_hole_and_over_a_notch) {
  Polygon area = rectangle(0, 0, 10, 10);
  area.holes.push_back({{4, 3}, {4, 6}, {6, 6}, {6, 3}});
  const auto pieces = io::clip_line({{1, 5}, {9, 5}}, area);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(pieces[0].back().p, (Vec2{4, 5}));
  EXPECT_EQ(pieces[1].front().p, (Vec2{6, 5}));
}

TEST(ClipLine, touching_a_corner_from_inside_does_not_cut) {
  const Polygon arrow{{{0, 0}, {10, 0}, {5, 4}, {10, 10}, {0, 10}}, {}};  // notch with its point at (5,4)
  const auto pieces = io::clip_line({{5, 1}, {5, 9}}, arrow);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].size(), 2u);
}

TEST(ClipLine, line_outside_or_without_length_gives_nothing) {
  EXPECT_TRUE(io::clip_line({{20, 20}, {30, 20}}, rectangle(0, 0, 10, 10)).empty());
  EXPECT_TRUE(io::clip_line({{1, 1}}, rectangle(0, 0, 10, 10)).empty());
  EXPECT_TRUE(io::clip_line({}, rectangle(0, 0, 10, 10)).empty());
}

// ---- tags ------------------------------------------------------------------------------------------------------------

TEST(OsmTags, widths) {
  EXPECT_DOUBLE_EQ(io::parse_width_m("3.5"), 3.5);
  EXPECT_DOUBLE_EQ(io::parse_width_m("3,5 m"), 3.5);
  EXPECT_DOUBLE_EQ(io::parse_width_m("10 ft"), 3.048);
  EXPECT_DOUBLE_EQ(io::parse_width_m("12'6\""), 12.5 * 0.3048);
  for (const char* bad : {"", "narrow", "-3", "0", "3.5 parsecs", "12'x\"", "nan", "3;4"}) EXPECT_EQ(io::parse_width_m(bad), 0.0) << bad;
}

TEST(OsmTags, what_oneway_means) {
  const auto oneway = [](const io::OsmTags& tags) { return io::way_attributes(tags).path.oneway == Oneway::forward; };
  EXPECT_FALSE(oneway({{"highway", "residential"}}));
  EXPECT_TRUE(oneway({{"highway", "residential"}, {"oneway", "yes"}}));
  EXPECT_TRUE(oneway({{"highway", "motorway"}})) << "implied";
  EXPECT_FALSE(oneway({{"highway", "motorway"}, {"oneway", "no"}})) << "implied, but denied";
  EXPECT_TRUE(oneway({{"highway", "primary"}, {"junction", "roundabout"}})) << "implied";
  EXPECT_TRUE(io::way_attributes({{"highway", "service"}, {"oneway", "-1"}}).reversed);
}

TEST(OsmTags, layers_of_bridges_and_tunnels) {
  EXPECT_EQ(io::way_attributes({{"highway", "primary"}}).path.layer, 0);
  EXPECT_EQ(io::way_attributes({{"highway", "primary"}, {"bridge", "yes"}}).path.layer, 1);
  EXPECT_EQ(io::way_attributes({{"highway", "primary"}, {"bridge", "viaduct"}, {"layer", "2"}}).path.layer, 2);
  EXPECT_EQ(io::way_attributes({{"highway", "primary"}, {"tunnel", "yes"}}).path.layer, -1);
  EXPECT_FALSE(io::way_attributes({{"highway", "primary"}, {"bridge", "no"}}).path.bridge);
}

// ---- OSM roads -------------------------------------------------------------------------------------------------------

TEST(OsmRoads, ways_become_paths_in_the_site_crs) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 10, 10).node(2, 60, 10).node(3, 60, 50).node(4, 20, 80);
  osm.way(9, {3, 4}, {{"highway", "service"}, {"oneway", "-1"}});
  osm.way(7, {1, 2, 3}, {{"highway", "residential"}, {"name", "High &amp; Low"}, {"width", "6.5"}, {"lanes", "2"}});
  osm.way(8, {1, 4}, {{"highway", "footway"}});
  osm.way(6, {1, 4}, {{"highway", "service"}, {"area", "yes"}});
  write_bytes(scratch / "a.osm", osm.text());
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100));
  ASSERT_EQ(roads.paths.size(), 2u) << "no footway, no area";
  const RoadPath& first = roads.paths[0];
  EXPECT_EQ(first.osm_id, 7);
  EXPECT_EQ(first.name, "High & Low");
  ASSERT_EQ(first.nodes.size(), 3u);
  EXPECT_NEAR(distance(first.nodes[1].p, origin + Vec2{60, 10}), 0.0, 0.01);
  EXPECT_NEAR(first.nodes[2].s_m, 90.0, 0.02);
  EXPECT_EQ(first.nodes[1].osm_node, 2);
  EXPECT_DOUBLE_EQ(first.nodes[0].width_m, 6.5);
  EXPECT_EQ(roads.paths[1].nodes.front().osm_node, 4) << "oneway=-1 is turned round";
  EXPECT_DOUBLE_EQ(roads.paths[1].nodes[0].width_m, default_width_m("service", 0, Oneway::forward));
}

TEST(OsmRoads, ways_are_cut_at_the_area_and_their_pieces_counted) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 50, 20).node(2, 150, 20).node(3, 150, 60).node(4, 50, 60);
  osm.way(5, {1, 2, 3, 4}, {{"highway", "primary"}});
  write_bytes(scratch / "a.osm", osm.text());
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100));
  ASSERT_EQ(roads.paths.size(), 2u);
  EXPECT_EQ(roads.paths[1].part, 1);
  EXPECT_EQ(roads.paths[0].nodes.back().osm_node, 0);
  EXPECT_NEAR(roads.paths[0].nodes.back().p.x, origin.x + 100.0, 1e-9);
  EXPECT_NEAR(roads.paths[1].nodes.back().s_m, 50.0, 0.02);
}

TEST(OsmRoads, missing_and_doubled_nodes) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 10, 10).node(2, 20, 10).node(3, 40, 10).node(4, 50, 10);
  osm.way(5, {1, 2, 2, 99, 3, 4}, {{"highway", "primary"}});  // 99 is not in the file
  write_bytes(scratch / "a.osm", osm.text());
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100));
  ASSERT_EQ(roads.paths.size(), 2u);
  EXPECT_EQ(roads.paths[0].nodes.size(), 2u);
  EXPECT_EQ(roads.paths[1].nodes[0].osm_node, 3);
}

TEST(OsmRoads, no_roads_in_the_area_says_where_they_lie) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 5000, 10).node(2, 6000, 10).way(5, {1, 2}, {{"highway", "primary"}});
  write_bytes(scratch / "a.osm", osm.text());
  const std::string message = message_of<InputError>([&] { (void)io::read_osm_roads(scratch / "a.osm", site_of(100)); });
  EXPECT_THAT(message, HasSubstr("no roads in the area: its roads lie in longitude 15.06"));
  EXPECT_THAT(message, HasSubstr("the area is longitude 15.00000..15.00140"));
}

TEST(OsmRoads, file_without_roads) {
  const Scratch scratch;
  write_bytes(scratch / "a.osm", OsmText().node(1, 0, 0).text());
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_osm_roads(scratch / "a.osm", site_of(100)); }), HasSubstr("no drivable ways"));
}

TEST(OsmRoads, missing_empty_truncated_or_foreign_file) {
  const Scratch scratch;
  const auto read = [&](const char* name) { (void)io::read_osm_roads(scratch / name, site_of(100)); };
  EXPECT_THAT(message_of<InputError>([&] { read("none.osm"); }), HasSubstr("no such file"));
  write_bytes(scratch / "empty.osm", "");
  EXPECT_THAT(message_of<InputError>([&] { read("empty.osm"); }), HasSubstr("is empty"));
  OsmText osm;
  for (int i = 0; i < 200; ++i) osm.node(i + 1, i, i);
  osm.way(5, {1, 200}, {{"highway", "primary"}});
  for (const double share : {0.5, 0.98}) {
    write_bytes(scratch / "cut.osm", osm.text());
    truncate_to(scratch / "cut.osm", share);
    EXPECT_THAT(message_of<InputError>([&] { read("cut.osm"); }), HasSubstr("truncated")) << share;
  }
  write_bytes(scratch / "text.osm.pbf", "this is no protocol buffer, but long enough to look at");
  EXPECT_THAT(message_of<InputError>([&] { read("text.osm.pbf"); }), HasSubstr("not an OSM file"));
  write_bytes(scratch / "text.xyz", "this is no protocol buffer, but long enough to look at");
  EXPECT_THAT(message_of<InputError>([&] { read("text.xyz"); }), HasSubstr("not an OSM file"));
}

TEST(OsmRoads, pbf_reads_as_the_xml_does_and_a_truncated_one_is_refused) {
  const Scratch scratch;
  OsmText osm;
  for (int i = 0; i < 3000; ++i) osm.node(i + 1, i % 90, i / 40.0);
  osm.way(5, {1, 50, 2999}, {{"highway", "primary"}});
  write_bytes(scratch / "a.osm", osm.text());
  {
    osmium::io::Reader reader((scratch / "a.osm").string());
    osmium::io::Writer writer((scratch / "a.osm.pbf").string(), reader.header());
    while (osmium::memory::Buffer buffer = reader.read()) writer(std::move(buffer));
    writer.close();
  }
  const RoadNetwork xml = io::read_osm_roads(scratch / "a.osm", site_of(100)), pbf = io::read_osm_roads(scratch / "a.osm.pbf", site_of(100));
  ASSERT_EQ(pbf.paths.size(), 1u);
  EXPECT_EQ(pbf.paths[0].nodes[1].p, xml.paths.at(0).nodes[1].p);
  const std::string whole = bytes_of(scratch / "a.osm.pbf");
  for (const double share : {0.999, 0.6, 0.1, 0.01}) {
    write_bytes(scratch / "cut.osm.pbf", whole);
    truncate_to(scratch / "cut.osm.pbf", share);
    EXPECT_THAT(message_of<InputError>([&] { (void)io::read_osm_roads(scratch / "cut.osm.pbf", site_of(100)); }), HasSubstr("truncated")) << share;
  }
}

TEST(OsmFeatures, polygons_lines_and_multipolygons_with_their_tags) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 0, 0).node(2, 40, 0).node(3, 40, 40).node(4, 0, 40);
  osm.node(5, 10, 10).node(6, 20, 10).node(7, 20, 20).node(8, 10, 20);
  osm.way(1, {1, 2, 3, 4, 1}, {{"building", "yes"}});
  osm.way(2, {1, 2, 3}, {{"waterway", "stream"}});
  osm.way(3, {5, 6, 7, 8, 5}, {{"highway", "service"}});
  osm.way(4, {1, 2, 3, 4, 1}, {}).way(5, {5, 6, 7, 8, 5}, {});
  osm.raw(R"(<relation id="9"><member type="way" ref="4" role="outer"/><member type="way" ref="5" role="inner"/>)"
          R"(<tag k="type" v="multipolygon"/><tag k="natural" v="water"/></relation>)");
  write_bytes(scratch / "a.osm", osm.text());
  double building_m2 = 0.0, water_m2 = 0.0;
  int lines = 0;
  for (const io::Feature& feature : io::read_features(scratch / "a.osm", utm33)) {
    for (const Polygon& polygon : feature.polygons) {
      if (feature.tags.contains("building")) building_m2 += area_m2(polygon);
      if (feature.tags.contains("natural")) water_m2 += area_m2(polygon);
    }
    lines += static_cast<int>(feature.lines.size());
  }
  EXPECT_NEAR(building_m2, 1600.0, 1.0);
  EXPECT_NEAR(water_m2, 1500.0, 1.0) << "the hole is out";
  EXPECT_EQ(lines, 2) << "stream and ring road";
}

// ---- GeoPackage ------------------------------------------------------------------------------------------------------

RoadNetwork two_roads() {
  RoadNetwork roads{.crs = utm33};
  RoadPath& main = roads.paths.emplace_back(RoadPath{.osm_id = 123456789012345, .part = 1, .highway = "primary", .name = "Štross \"A\"",
                                                     .layer = 1, .bridge = true, .oneway = Oneway::forward, .lanes = 2});
  for (int i = 0; i < 12; ++i)
    main.nodes.push_back({.p = origin + Vec2{2.0 * i, std::sin(0.3 * i)}, .osm_node = i == 0 ? 77 : 0, .s_m = 2.0 * i, .offset_m = 0.1 * i,
                          .width_m = 6.0 + 0.01 * i, .sigma_offset_m = 0.3, .sigma_width_m = 0.4, .z_m = 200.0 + i / 3.0,
                          .gradient = 0.01, .banking = -0.02, .sigma_z_m = 0.1, .banking_source = "dtm"});
  RoadPath& raw = roads.paths.emplace_back(RoadPath{.osm_id = 5, .highway = "service", .roundabout = true});
  raw.nodes = {{.p = origin, .osm_node = 77, .width_m = 4.0}, {.p = origin + Vec2{0, 30}, .s_m = 30.0, .width_m = 4.0}};  // no heights yet
  return roads;
}

void expect_same(const RoadNetwork& a, const RoadNetwork& b) {
  EXPECT_EQ(a.crs, b.crs);
  ASSERT_EQ(a.paths.size(), b.paths.size());
  for (std::size_t i = 0; i < a.paths.size(); ++i) {
    const RoadPath &p = a.paths[i], &q = b.paths[i];
    EXPECT_EQ(std::tie(p.osm_id, p.part, p.highway, p.name, p.layer, p.bridge, p.tunnel, p.oneway, p.lanes, p.roundabout),
              std::tie(q.osm_id, q.part, q.highway, q.name, q.layer, q.bridge, q.tunnel, q.oneway, q.lanes, q.roundabout));
    ASSERT_EQ(p.nodes.size(), q.nodes.size());
    for (std::size_t k = 0; k < p.nodes.size(); ++k) {
      const RoadNode &m = p.nodes[k], &n = q.nodes[k];
      EXPECT_EQ(m.p, n.p);
      EXPECT_EQ(std::tie(m.osm_node, m.s_m, m.offset_m, m.width_m, m.sigma_offset_m, m.sigma_width_m, m.gradient, m.banking, m.sigma_z_m,
                         m.banking_source),
                std::tie(n.osm_node, n.s_m, n.offset_m, n.width_m, n.sigma_offset_m, n.sigma_width_m, n.gradient, n.banking, n.sigma_z_m,
                         n.banking_source));
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
    hairpin.nodes.push_back({.p = origin + Vec2{100.0 + 3.0 * std::cos(angle), 3.0 * std::sin(angle)}, .s_m = 3.0 * angle, .width_m = 8.0});
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
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_roads(scratch / "a.geojson"); }), HasSubstr("no layer 'centrelines'"));
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

// ---- GeoJSON ---------------------------------------------------------------------------------------------------------

TEST(GeoJson, features_come_back_to_a_centimetre) {
  const Scratch scratch;
  Polygon with_hole = rectangle(origin.x, origin.y, origin.x + 40, origin.y + 30);
  with_hole.holes.push_back({origin + Vec2{5, 5}, origin + Vec2{5, 10}, origin + Vec2{10, 10}, origin + Vec2{10, 5}});
  const std::vector<io::Feature> features{
      {.polygons = {with_hole}, .tags = {{"id", "a"}, {"kind", "road"}}},
      {.polygons = {rectangle(origin.x + 50, origin.y, origin.x + 60, origin.y + 9), rectangle(origin.x + 70, origin.y, origin.x + 75, origin.y + 9)}},
      {.lines = {{origin, origin + Vec2{10, 3}, origin + Vec2{20, -3}}}, .tags = {{"of", "a"}, {"quote", "\"\\\n"}}},
      {.points = {origin + Vec2{1, 2}}}};
  io::write_geojson(scratch / "a.geojson", features, utm33);
  const std::vector<io::Feature> back = io::read_features(scratch / "a.geojson", utm33);
  ASSERT_EQ(back.size(), 4u);
  ASSERT_EQ(back[0].polygons.size(), 1u);
  EXPECT_NEAR(area_m2(back[0].polygons[0]), 1175.0, 0.5);
  EXPECT_GT(signed_area_m2(back[0].polygons[0].outer), 0.0) << "counter-clockwise (RFC 7946)";
  EXPECT_LT(signed_area_m2(back[0].polygons[0].holes.at(0)), 0.0);
  EXPECT_EQ(back[0].tags.at("kind"), "road");
  EXPECT_EQ(back[1].polygons.size(), 2u);
  EXPECT_EQ(back[2].tags.at("quote"), "\"\\\n");
  EXPECT_NEAR(distance(back[2].lines[0][2], origin + Vec2{20, -3}), 0.0, 0.01);
  EXPECT_EQ(back[3].points.size(), 1u);
}

TEST(GeoJson, findings_and_no_findings) {
  const Scratch scratch;
  io::write_findings(scratch / "f.geojson", {{Severity::error, "x.y", "Bad \"thing\"", origin.x, origin.y}}, utm33);
  EXPECT_THAT(bytes_of(scratch / "f.geojson"), HasSubstr(R"("code":"x.y","message":"Bad \"thing\"","severity":"error")"));
  EXPECT_THAT(bytes_of(scratch / "f.geojson"), HasSubstr("[15.0000000,50.01"));
  io::write_findings(scratch / "none.geojson", {}, utm33);
  EXPECT_TRUE(io::read_features(scratch / "none.geojson", utm33).empty());
}

TEST(GeoJson, truncated) {
  const Scratch scratch;
  io::write_geojson(scratch / "a.geojson", {{.lines = {{origin, origin + Vec2{10, 3}}}}}, utm33);
  truncate_to(scratch / "a.geojson", 0.7);
  EXPECT_THROW((void)io::read_features(scratch / "a.geojson", utm33), InputError);
}

// ---- real towns ------------------------------------------------------------------------------------------------------

SiteFrame lonlat_site(double west, double south, double east, double north) {
  const CoordinateTransform site_from_lonlat(Crs{"EPSG:4326"}, utm33);
  SiteFrame site{utm33, {}};
  for (const Vec2 p : {Vec2{west, south}, Vec2{east, south}, Vec2{east, north}, Vec2{west, north}})
    site.area.outer.push_back(site_from_lonlat.target_from_source(p));
  return site;
}

TEST(RealOsm, kvarnbyn) {
  const fs::path file = ORTHODRIVE_SOURCE_DIR "/../shared/data/kvarnbyn/roads.osm";
  if (!fs::exists(file)) GTEST_SKIP() << "REAL DATA MISSING: " << file;
  const SiteFrame site = lonlat_site(12.008, 57.6495, 12.044, 57.6625);
  const RoadNetwork roads = io::read_osm_roads(file, site);
  double total_m = 0.0;
  for (const RoadPath& path : roads.paths) {
    EXPECT_GE(path.nodes.size(), 2u);
    EXPECT_DOUBLE_EQ(path.nodes.back().s_m, length_m(centerline(path)));
    total_m += path.nodes.back().s_m;
    for (const RoadNode& node : path.nodes) EXPECT_GT(node.width_m, 2.0);
  }
  EXPECT_GT(total_m, 20e3);
  fmt::print("Kvarnbyn: {} paths, {:.1f} km\n", roads.paths.size(), total_m / 1000.0);
}

TEST(RealOsm, pardubice_reads_in_two_seconds_and_writes_in_a_few) {
  const fs::path file = ORTHODRIVE_SOURCE_DIR "/../shared/data/pardubice/roads.osm";
  if (!fs::exists(file)) GTEST_SKIP() << "REAL DATA MISSING: " << file;
  const auto start = std::chrono::steady_clock::now();
  const RoadNetwork roads = io::read_osm_roads(file, lonlat_site(15.72259, 50.01013, 15.78959, 50.05329));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LT(seconds, 2.0);
  double total_m = 0.0;
  for (const RoadPath& path : roads.paths) total_m += path.nodes.back().s_m;
  EXPECT_NEAR(total_m, 245e3, 15e3);  // README: 123 km of streets, 122 km of service roads
  const Scratch scratch;
  const auto middle = std::chrono::steady_clock::now();
  io::write_roads(scratch / "roads.gpkg", roads);
  const auto written = std::chrono::steady_clock::now();
  expect_same(roads, io::read_roads(scratch / "roads.gpkg"));
  fmt::print("Pardubice: {} paths, {:.1f} km, read in {:.2f} s, written in {:.2f} s, read again in {:.2f} s\n", roads.paths.size(), total_m / 1000.0,
             seconds, std::chrono::duration<double>(written - middle).count(),
             std::chrono::duration<double>(std::chrono::steady_clock::now() - written).count());
}

}  // namespace
}  // namespace orthodrive

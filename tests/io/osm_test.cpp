// SPDX-License-Identifier: Apache-2.0
// OSM in: tags, roads cut at the area, features, broken files.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <osmium/io/any_input.hpp>
#include <osmium/io/pbf_output.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/osm/osm_tags.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "paths.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

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
    return "<?xml version='1.0' encoding='UTF-8'?>\n<osm version=\"0.6\" generator=\"test\">\n" + nodes_ + ways_ +
           "</osm>\n";
  }

 private:
  CoordinateTransform lonlat_from_site_{utm33, Crs{"EPSG:4326"}};
  std::string nodes_, ways_;
};

TEST(OsmTags, widths) {
  EXPECT_DOUBLE_EQ(io::parse_width_m("3.5"), 3.5);
  EXPECT_DOUBLE_EQ(io::parse_width_m("3,5 m"), 3.5);
  EXPECT_DOUBLE_EQ(io::parse_width_m("10 ft"), 3.048);
  EXPECT_DOUBLE_EQ(io::parse_width_m("12'6\""), 12.5 * 0.3048);
  for (const char* bad : {"", "narrow", "-3", "0", "3.5 parsecs", "12'x\"", "nan", "3;4"})
    EXPECT_EQ(io::parse_width_m(bad), 0.0) << bad;
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

TEST(OsmTags, what_only_looks_like_a_bridge_or_tunnel_lies_on_the_ground) {
  const auto path = [](const char* key, const char* value, const char* layer = "") {
    io::OsmTags tags{{"highway", "service"}, {key, value}};
    if (*layer) tags["layer"] = layer;
    return io::way_attributes(tags).path;
  };
  for (const char* roof : {"building_passage", "avalanche_protector", "covered", "culvert", "no"}) {
    EXPECT_FALSE(path("tunnel", roof).tunnel) << roof;
    EXPECT_EQ(path("tunnel", roof).layer, 0) << roof;
  }
  EXPECT_EQ(path("tunnel", "building_passage", "-1").layer, 0);
  EXPECT_FALSE(path("covered", "yes").tunnel);
  for (const char* tunnel : {"yes", "underpass", "1"}) EXPECT_TRUE(path("tunnel", tunnel).tunnel) << tunnel;
  for (const char* flat : {"low_water_crossing", "boardwalk", "no"}) {
    EXPECT_FALSE(path("bridge", flat).bridge) << flat;
    EXPECT_EQ(path("bridge", flat).layer, 0) << flat;
  }
  for (const char* bridge : {"yes", "viaduct", "movable", "aqueduct", "covered", "cantilever", "trestle"})
    EXPECT_TRUE(path("bridge", bridge).bridge) << bridge;
}

TEST(OsmTags, speeds) {
  EXPECT_DOUBLE_EQ(io::parse_speed_kmh("50"), 50.0);
  EXPECT_NEAR(io::parse_speed_kmh("30 mph"), 48.28032, 1e-9);
  EXPECT_NEAR(io::parse_speed_kmh("30mph"), 48.28032, 1e-9);
  EXPECT_DOUBLE_EQ(io::parse_speed_kmh("none"), 130.0);
  for (const char* bad : {"", "fast", "-30", "0", "50 furlongs", "XX:nowhere", "1e9", "CZ:urban"})
    EXPECT_EQ(io::parse_speed_kmh(bad), 0.0) << bad;
}

TEST(OsmTags, lanes_of_both_directions) {
  const auto read = [](io::OsmTags tags) {
    tags.emplace("highway", "primary");
    return io::way_attributes(tags);
  };
  io::WayAttributes way = read({{"lanes", "3"},
                                {"lanes:forward", "2"},
                                {"turn:lanes:forward", "left|through;right"},
                                {"sidewalk", "left"},
                                {"shoulder:right", "yes"},
                                {"surface", "asphalt"},
                                {"maxspeed", "70"}});
  EXPECT_EQ(way.path.lanes, 3);
  EXPECT_EQ(way.path.lanes_forward, 2);
  EXPECT_EQ(way.path.lanes_backward, 1) << "the rest";
  EXPECT_EQ(way.path.turn_forward, "left|through;right");
  EXPECT_EQ(way.path.sidewalk, Sides::left);
  EXPECT_EQ(way.path.shoulder, Sides::right);
  EXPECT_EQ(way.path.surface, "asphalt");
  EXPECT_EQ(way.path.speed_limit_kmh, 70.0);
  EXPECT_TRUE(way.doubts.empty());

  way = read({{"oneway", "-1"}, {"turn:lanes", "left|through"}, {"sidewalk:left", "yes"}});
  EXPECT_EQ(way.path.lanes, 2) << "told by the arrows";
  EXPECT_EQ(way.path.turn_forward, "left|through");
  EXPECT_EQ(way.path.sidewalk, Sides::right) << "turned round with the way";

  way = read({{"oneway", "-1"}, {"lanes:backward", "2"}});
  EXPECT_EQ(way.path.lanes_forward, 2) << "turned round with the way";
  EXPECT_TRUE(way.doubts.empty());
}

TEST(OsmTags, surface_classes) {
  const auto read = [](const io::OsmTags& tags) { return io::way_attributes(tags); };
  io::WayAttributes way = read({{"highway", "residential"}, {"surface", "sett"}});
  EXPECT_EQ(way.path.known_surface.surface, SurfaceClass::setts);
  EXPECT_EQ(way.path.known_surface.source, SurfaceSource::tag);
  way = read({{"highway", "track"}, {"tracktype", "grade3"}});
  EXPECT_EQ(way.path.known_surface.surface, SurfaceClass::ground);
  EXPECT_EQ(way.path.known_surface.source, SurfaceSource::tracktype);
  way = read({{"highway", "service"}});
  EXPECT_EQ(way.path.known_surface.surface, SurfaceClass::asphalt);
  EXPECT_TRUE(way.doubts.empty());
  way = read({{"highway", "service"}, {"surface", "lava"}});
  EXPECT_EQ(way.path.known_surface.surface, SurfaceClass::asphalt);
  ASSERT_EQ(way.doubts.size(), 1u);
  EXPECT_THAT(way.doubts[0], testing::HasSubstr("surface=lava"));
}

TEST(OsmTags, contradictions_are_settled_and_told) {
  const auto read = [](io::OsmTags tags) {
    tags.emplace("highway", "primary");
    return io::way_attributes(tags);
  };
  io::WayAttributes way = read({{"lanes", "2"}, {"lanes:forward", "2"}, {"lanes:backward", "1"}});
  EXPECT_EQ(way.path.lanes, 3);
  EXPECT_EQ(way.doubts.size(), 1u);
  way = read({{"lanes", "2"}, {"lanes:forward", "2"}});
  EXPECT_EQ(way.path.lanes_backward, 1);
  EXPECT_EQ(way.path.lanes, 3);
  EXPECT_EQ(way.doubts.size(), 1u);
  way = read({{"lanes", "2"}, {"oneway", "yes"}, {"lanes:backward", "1"}});
  EXPECT_EQ(way.path.lanes_forward, 1);
  EXPECT_EQ(way.path.use_backward, "none") << "a lane against the traffic is none for cars";
  EXPECT_EQ(way.doubts.size(), 1u);
  way = read({{"lanes", "3"}, {"lanes:forward", "2"}, {"turn:lanes:forward", "left"}});
  EXPECT_TRUE(way.path.turn_forward.empty());
  EXPECT_EQ(way.doubts.size(), 1u);
  way = read({{"lanes", "200"}, {"maxspeed", "fast"}, {"lanes:forward", "x"}});
  EXPECT_EQ(way.path.lanes, 0);
  EXPECT_EQ(way.path.speed_limit_kmh, 0.0);
  EXPECT_EQ(way.doubts.size(), 3u);
}

TEST(OsmTags, signs_and_crossings_of_nodes) {
  const auto kinds = [](const io::OsmTags& tags) {
    std::string text;
    for (const NodeSign& sign : io::node_signs(5, tags))
      text +=
          fmt::format("{}{}{} ", to_string(sign.kind), sign.direction > 0 ? "+" : "", sign.direction < 0 ? "-" : "");
    return text;
  };
  EXPECT_EQ(kinds({{"highway", "stop"}, {"direction", "forward"}}), "stop+ ");
  EXPECT_EQ(kinds({{"highway", "give_way"}, {"direction", "backward"}}), "give_way- ");
  EXPECT_EQ(kinds({{"highway", "traffic_signals"}, {"crossing", "traffic_signals"}}),
            "traffic_signals signal_crossing ");
  EXPECT_EQ(kinds({{"highway", "crossing"}}), "plain_crossing ");
  EXPECT_EQ(kinds({{"highway", "crossing"}, {"crossing", "uncontrolled"}}), "zebra ");
  EXPECT_EQ(kinds({{"highway", "crossing"}, {"crossing", "marked"}}), "zebra ");
  EXPECT_EQ(kinds({{"highway", "crossing"}, {"crossing", "marked"}, {"crossing:markings", "no"}}), "plain_crossing ");
  EXPECT_EQ(kinds({{"highway", "crossing"}, {"crossing:markings", "zebra"}}), "zebra ");
  EXPECT_EQ(kinds({{"highway", "crossing"}, {"crossing", "unmarked"}, {"crossing_ref", "zebra"}}), "zebra ");
  EXPECT_EQ(kinds({{"highway", "street_lamp"}, {"crossing", "no"}}), "");
}

TEST(OsmTags, what_is_built_at_nodes) {
  const auto things = [](const io::OsmTags& tags) {
    std::string text;
    for (const NodeSign& s : io::node_signs(5, tags))
      text += fmt::format("{}={} {}{} ", to_string(s.kind), s.value, s.size_m, s.closed ? " closed" : "");
    return text;
  };
  EXPECT_EQ(things({{"highway", "mini_roundabout"}}), "mini_roundabout= 0 ");
  EXPECT_EQ(things({{"highway", "mini_roundabout"}, {"direction", "clockwise"}, {"diameter", "14 m"}}),
            "mini_roundabout=clockwise 14 ");
  EXPECT_EQ(things({{"highway", "mini_roundabout"}, {"direction", "anti_clockwise"}}),
            "mini_roundabout=anticlockwise 0 ");
  EXPECT_EQ(things({{"traffic_calming", "hump;choker"}}), "traffic_calming=hump 0 ");
  EXPECT_EQ(things({{"traffic_calming", "table"}, {"highway", "crossing"}}),
            "plain_crossing= 0 traffic_calming=table 0 ");
  EXPECT_EQ(things({{"barrier", "bollard"}}), "barrier=bollard 0 closed ");
  EXPECT_EQ(things({{"barrier", "bollard"}, {"motor_vehicle", "yes"}}), "barrier=bollard 0 ");
  EXPECT_EQ(things({{"barrier", "bollard"}, {"access", "yes"}, {"motorcar", "no"}}), "barrier=bollard 0 closed ");
  EXPECT_EQ(things({{"barrier", "gate"}}), "barrier=gate 0 ");
  EXPECT_EQ(things({{"barrier", "gate"}, {"locked", "yes"}}), "barrier=gate 0 closed ");
  EXPECT_EQ(things({{"barrier", "lift_gate"}, {"access", "private"}}), "barrier=lift_gate 0 ");
  EXPECT_EQ(things({{"barrier", "something"}, {"vehicle", "no"}}), "barrier=something 0 closed ");
  EXPECT_EQ(things({{"barrier", "kerb"}}), "");
}

TEST(OsmRoads, signs_of_their_nodes_come_along_in_the_direction_of_the_path) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 10, 10).node(2, 60, 10).node(3, 60, 50).node(4, 90, 90);
  osm.way(7, {1, 2}, {{"highway", "residential"}}).way(8, {2, 3}, {{"highway", "residential"}, {"oneway", "-1"}});
  std::string text = osm.text();
  const auto tag = [&](int id, const std::string& tags) {
    const std::size_t at = text.find("/>", text.find(fmt::format("id=\"{}\"", id)));
    ASSERT_NE(at, std::string::npos);
    text.replace(at, 2, ">" + tags + "</node>");
  };
  tag(1, "<tag k='highway' v='stop'/><tag k='direction' v='forward'/>");
  tag(3, "<tag k='highway' v='give_way'/><tag k='direction' v='forward'/>");
  tag(4, "<tag k='highway' v='crossing'/>");
  write_bytes(scratch / "a.osm", text);
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100));
  ASSERT_EQ(roads.signs.size(), 2u) << "node 4 is on no road";
  EXPECT_EQ(roads.signs[0].osm_node, 1);
  EXPECT_EQ(roads.signs[0].direction, 1);
  EXPECT_EQ(roads.signs[1].kind, NodeSignKind::give_way);
  EXPECT_EQ(roads.signs[1].direction, -1) << "the way is turned round";
}

TEST(OsmRoads, turn_restrictions_of_cars_over_one_node) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 10, 10).node(2, 60, 10).node(3, 60, 50).node(4, 90, 10);
  osm.way(7, {1, 2}, {{"highway", "residential"}}).way(8, {2, 3}, {{"highway", "residential"}});
  osm.way(9, {2, 4}, {{"highway", "residential"}, {"lanes", "2"}, {"lanes:forward", "2"}});
  std::string text = osm.text();
  const auto relation = [&](int id, const char* kind, const char* value, const char* more) {
    return fmt::format(
        "<relation id='{}'><member type='way' ref='7' role='from'/><member type='node' ref='2' role='via'/>"
        "<member type='way' ref='8' role='to'/><tag k='type' v='restriction'/><tag k='{}' v='{}'/>{}</relation>",
        id, kind, value, more);
  };
  text.insert(text.rfind("</osm>"), relation(1, "restriction", "no_left_turn", "") +
                                        relation(2, "restriction", "only_straight_on", "") +
                                        relation(3, "restriction:hgv", "no_left_turn", "") +
                                        relation(4, "restriction", "no_left_turn", "<tag k='except' v='motorcar'/>"));
  write_bytes(scratch / "a.osm", text);
  Findings findings;
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100), &findings);
  ASSERT_EQ(roads.restrictions.size(), 2u);
  EXPECT_EQ(roads.restrictions[0].from_way, 7);
  EXPECT_EQ(roads.restrictions[0].via_node, 2);
  EXPECT_EQ(roads.restrictions[0].to_way, 8);
  EXPECT_FALSE(roads.restrictions[0].only);
  EXPECT_TRUE(roads.restrictions[1].only);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, "osm.lane_tags");
  EXPECT_NEAR(findings[0].x_m, origin.x + 90.0, 30.1) << "on the way";
}

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
  Findings findings;
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100), &findings);
  std::vector<std::string> codes;
  for (const Finding& finding : findings) codes.push_back(finding.code);
  EXPECT_THAT(codes, testing::ElementsAre("osm.missing_node", "osm.doubled_nodes"));
  EXPECT_NEAR(findings[0].x_m, origin.x + 20.0, 0.01);
  ASSERT_EQ(roads.paths.size(), 2u);
  EXPECT_EQ(roads.paths[0].nodes.size(), 2u);
  EXPECT_EQ(roads.paths[1].nodes[0].osm_node, 3);
}

TEST(OsmRoads, tags_that_are_no_numbers_and_ways_without_length_are_told) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 10, 10).node(2, 90, 10).node(3, 10, 30).node(4, 90, 30).node(5, 50, 50);
  osm.way(5, {1, 2}, {{"highway", "primary"}, {"width", "wide"}});
  osm.way(6, {3, 4}, {{"highway", "residential"}, {"lanes", "0"}});
  osm.way(7, {5, 5}, {{"highway", "residential"}});
  write_bytes(scratch / "a.osm", osm.text());
  Findings findings;
  const RoadNetwork roads = io::read_osm_roads(scratch / "a.osm", site_of(100), &findings);
  ASSERT_EQ(roads.paths.size(), 2u);
  for (const RoadPath& path : roads.paths)
    EXPECT_EQ(path.nodes[0].width_m, default_width_m(path.highway, 0, Oneway::no));
  ASSERT_EQ(findings.size(), 4u);
  EXPECT_EQ(findings[0].code, "osm.odd_tag");
  EXPECT_THAT(findings[0].message, HasSubstr("way 5: width=wide"));
  EXPECT_THAT(findings[1].message, HasSubstr("way 6: lanes=0"));
  EXPECT_NEAR(findings[1].y_m, origin.y + 30.0, 0.01);
  EXPECT_EQ(findings[2].code, "osm.doubled_nodes");
  EXPECT_EQ(findings[3].code, "osm.no_length");
}

TEST(OsmRoads, no_roads_in_the_area_says_where_they_lie) {
  const Scratch scratch;
  OsmText osm;
  osm.node(1, 5000, 10).node(2, 6000, 10).way(5, {1, 2}, {{"highway", "primary"}});
  write_bytes(scratch / "a.osm", osm.text());
  const std::string message =
      message_of<InputError>([&] { (void)io::read_osm_roads(scratch / "a.osm", site_of(100)); });
  EXPECT_THAT(message, HasSubstr("no roads in the area: its roads lie in longitude 15.06"));
  EXPECT_THAT(message, HasSubstr("the area is longitude 15.00000..15.00140"));
}

TEST(OsmRoads, file_without_roads) {
  const Scratch scratch;
  write_bytes(scratch / "a.osm", OsmText().node(1, 0, 0).text());
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_osm_roads(scratch / "a.osm", site_of(100)); }),
              HasSubstr("no drivable ways"));
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
  const RoadNetwork xml = io::read_osm_roads(scratch / "a.osm", site_of(100)),
                    pbf = io::read_osm_roads(scratch / "a.osm.pbf", site_of(100));
  ASSERT_EQ(pbf.paths.size(), 1u);
  EXPECT_EQ(pbf.paths[0].nodes[1].p, xml.paths.at(0).nodes[1].p);
  const std::string whole = bytes_of(scratch / "a.osm.pbf");
  for (const double share : {0.999, 0.6, 0.1, 0.01}) {
    write_bytes(scratch / "cut.osm.pbf", whole);
    truncate_to(scratch / "cut.osm.pbf", share);
    EXPECT_THAT(message_of<InputError>([&] { (void)io::read_osm_roads(scratch / "cut.osm.pbf", site_of(100)); }),
                HasSubstr("truncated"))
        << share;
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

TEST(OsmFeatures, coordinates_beyond_all_numbers_are_refused_or_wrap_without_harm) {
  const Scratch scratch;
  for (const char* lon : {"1e30", "-1e99999", "15.0e17", "1000000000000000000000"}) {
    write_bytes(scratch / "a.osm", OsmText().raw(fmt::format(R"(<node id="7" lat="50" lon="{}"/>)", lon)).text());
    try {
      EXPECT_TRUE(io::read_osm_features(scratch / "a.osm", utm33).empty()) << lon;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("a.osm")) << lon;
    }
  }
}

TEST(OsmFeatures, ways_without_nodes_are_passed_over) {
  const Scratch scratch;
  const fs::path file = scratch / "a.osm";
  write_bytes(file, OsmText()
                        .node(1, 0, 0)
                        .node(2, 10, 0)
                        .way(1, {}, {{"highway", "residential"}})
                        .way(2, {}, {{"building", "yes"}})
                        .way(3, {1, 2}, {{"highway", "service"}})
                        .text());
  const std::vector<io::Feature> features = io::read_osm_features(file, utm33);
  ASSERT_EQ(features.size(), 1U);
  EXPECT_EQ(features[0].tags.at("highway"), "service");
}

TEST(RealOsm, kvarnbyn) {
  const fs::path file = paths::in_source("../shared/data/kvarnbyn/roads.osm");
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

TEST(OsmRoads, a_road_lies_in_a_town_where_most_of_it_lies_in_built_up_areas) {
  OsmText text;
  // A quarter of 200 m by 100 m, one of a multipolygon with a hole, and roads inside, beside, across, outside.
  text.node(1, 0, 0).node(2, 200, 0).node(3, 200, 100).node(4, 0, 100);
  text.way(1, {1, 2, 3, 4, 1}, {{"landuse", "residential"}});
  text.node(11, 300, 0).node(12, 600, 0).node(13, 600, 300).node(14, 300, 300);
  text.node(21, 350, 50).node(22, 550, 50).node(23, 550, 250).node(24, 350, 250);
  text.way(2, {11, 12, 13}, {}).way(3, {13, 14, 11}, {}).way(4, {21, 22, 23, 24, 21}, {});
  text.raw(
      "<relation id=\"9\"><member type=\"way\" ref=\"2\" role=\"outer\"/><member type=\"way\" ref=\"3\" "
      "role=\"outer\"/><member type=\"way\" ref=\"4\" role=\"inner\"/><tag k=\"type\" v=\"multipolygon\"/>"
      "<tag k=\"landuse\" v=\"industrial\"/></relation>\n");
  const auto road = [&](int id, double x0, double y0, double x1, double y1) {
    text.node(100 + 2 * id, x0, y0).node(101 + 2 * id, x1, y1);
    text.way(100 + id, {100 + 2 * id, 101 + 2 * id}, {{"highway", "tertiary"}});
  };
  road(0, 10, 50, 190, 50);     // inside
  road(1, 10, 115, 190, 115);   // along its edge
  road(2, 10, 50, -290, 50);    // mostly outside
  road(3, 400, 150, 500, 150);  // in the hole
  road(4, 310, 25, 590, 25);    // in the multipolygon
  road(5, 10, 400, 190, 400);   // far from all
  const SiteFrame site{
      utm33,
      {{origin + Vec2{-500, -500}, origin + Vec2{1000, -500}, origin + Vec2{1000, 1000}, origin + Vec2{-500, 1000}},
       {}}};
  const Scratch scratch;
  std::ofstream(scratch / "towns.osm") << text.text();
  const RoadNetwork roads = io::read_osm_roads(scratch / "towns.osm", site);
  ASSERT_EQ(roads.paths.size(), 6u);
  const char* expected[] = {"urban", "urban", "rural", "rural", "urban", "rural"};
  for (const RoadPath& path : roads.paths) EXPECT_EQ(path.speed_context, expected[path.osm_id - 100]) << path.osm_id;
}

}  // namespace
}  // namespace orthodrive

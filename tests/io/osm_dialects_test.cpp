// SPDX-License-Identifier: Apache-2.0
// One small map in the spellings that editors and servers give it: order, ids, dialects, several extracts.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"
#include "paths.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

/// Longitude and latitude of a place in metres from the origin, as text.
struct LonLat {
  std::string lon, lat;
};
LonLat lonlat(double x, double y) {
  const Vec2 q = CoordinateTransform(utm33, Crs{"EPSG:4326"}).target_from_source(origin + Vec2{x, y});
  return {fmt::format("{:.7f}", q.x), fmt::format("{:.7f}", q.y)};
}

struct MapNode {
  std::int64_t id = 0;
  double x = 0.0, y = 0.0;
};
struct MapWay {
  std::int64_t id = 0;
  std::vector<std::int64_t> nodes;
  std::string key, value;
};

// Two streets that cross at node 3, and a house.
const std::vector<MapNode> map_nodes = {{1, 10, 50},  {2, 50, 10},  {3, 50, 50},  {4, 90, 50}, {5, 50, 90},
                                        {11, 60, 60}, {12, 80, 60}, {13, 80, 80}, {14, 60, 80}};
const std::vector<MapWay> map_ways = {{101, {1, 3, 4}, "highway", "tertiary"},
                                      {102, {2, 3, 5}, "highway", "residential"},
                                      {103, {11, 12, 13, 14, 11}, "building", "yes"}};

std::string node_xml(const MapNode& node, const std::string& more = "") {
  const LonLat p = lonlat(node.x, node.y);
  return fmt::format("<node id=\"{}\" {} lon=\"{}\" lat=\"{}\"/>\n", node.id, more, p.lon, p.lat);
}
std::string way_xml(const MapWay& way, const std::string& more = "", bool with_places = false) {
  std::string text = fmt::format("<way id=\"{}\" {}>", way.id, more);
  for (const std::int64_t ref : way.nodes) {
    const auto node = std::ranges::find(map_nodes, std::abs(ref), &MapNode::id);
    const LonLat p = with_places ? lonlat(node->x, node->y) : LonLat{};
    text += with_places ? fmt::format("<nd ref=\"{}\" lat=\"{}\" lon=\"{}\"/>", ref, p.lat, p.lon)
                        : fmt::format("<nd ref=\"{}\"/>", ref);
  }
  return text + fmt::format("<tag k=\"{}\" v=\"{}\"/></way>\n", way.key, way.value);
}
std::string osm_xml(const std::string& objects, const std::string& attributes = "version=\"0.6\"") {
  return fmt::format("<?xml version='1.0' encoding='UTF-8'?>\n<osm {}>\n{}</osm>\n", attributes, objects);
}

/// Ways and their places as text: what must not depend on the spelling.
std::string told(const RoadNetwork& roads, double sign = 1.0) {
  std::vector<std::string> lines;
  for (const RoadPath& path : roads.paths) {
    std::string line = fmt::format("{} {}:", std::abs(path.osm_id), path.highway);
    for (const RoadNode& node : path.nodes)
      line += fmt::format(" {:.0f}@{:.1f},{:.1f}", sign * static_cast<double>(node.osm_node), node.p.x - origin.x,
                          node.p.y - origin.y);
    lines.push_back(line);
  }
  std::ranges::sort(lines);
  return fmt::format("{}", fmt::join(lines, "\n"));
}

constexpr const char* whole_map =
    "101 tertiary: 1@10.0,50.0 3@50.0,50.0 4@90.0,50.0\n"
    "102 residential: 2@50.0,10.0 3@50.0,50.0 5@50.0,90.0";

class OsmDialects : public testing::Test {
 protected:
  RoadNetwork read(const std::string& text, const char* name = "a.osm", Findings* findings = nullptr) {
    write_bytes(scratch_ / name, text);
    return io::read_osm_roads(scratch_ / name, site_of(100), findings);
  }
  std::string failure(const std::string& text, const char* name = "a.osm") {
    return message_of<InputError>([&] { (void)read(text, name); });
  }
  double house_m2(const std::string& text, const char* name = "a.osm") {
    write_bytes(scratch_ / name, text);
    double area = 0.0;
    for (const io::Feature& feature : io::read_features(std::vector<fs::path>{scratch_ / name}, utm33))
      for (const Polygon& polygon : feature.polygons) area += area_m2(polygon);
    return area;
  }
  Scratch scratch_;
};

TEST_F(OsmDialects, objects_in_any_order_and_twice) {
  std::vector<std::string> objects;
  objects.reserve(std::size(map_nodes) + 2 * std::size(map_ways));
  for (const MapNode& node : map_nodes) objects.push_back(node_xml(node));
  for (const MapWay& way : map_ways) objects.push_back(way_xml(way)), objects.push_back(way_xml(way));
  std::mt19937 random(7);
  for (int round = 0; round < 8; ++round) {
    const std::string text = osm_xml(fmt::format("{}", fmt::join(objects, "")));
    EXPECT_EQ(told(read(text)), whole_map) << round;
    EXPECT_NEAR(house_m2(text), 400.0, 1.0) << round;
    std::ranges::shuffle(objects, random);
  }
}

TEST_F(OsmDialects, negative_ids_meet_as_positive_ones_do) {
  std::string text;
  for (MapNode node : map_nodes) node.id = -node.id, text += node_xml(node);
  for (MapWay way : map_ways) {
    way.id = -way.id;
    for (std::int64_t& ref : way.nodes) ref = -ref;
    text += way_xml(way);
  }
  EXPECT_EQ(told(read(osm_xml(text)), -1.0), whole_map);
  EXPECT_NEAR(house_m2(osm_xml(text)), 400.0, 1.0);
}

TEST_F(OsmDialects, the_id_0_is_an_id) {
  std::string text;
  for (MapNode node : map_nodes) node.id = node.id == 3 ? 0 : node.id, text += node_xml(node);
  for (MapWay way : map_ways) {
    std::ranges::replace(way.nodes, 3, 0);
    text += way_xml(way);
  }
  const RoadNetwork roads = read(osm_xml(text));
  ASSERT_EQ(roads.paths.size(), 2U);
  EXPECT_TRUE(is_osm_node(roads.paths[0].nodes[1].osm_node));
  EXPECT_EQ(roads.paths[0].nodes[1].osm_node, roads.paths[1].nodes[1].osm_node);
}

TEST_F(OsmDialects, deleted_objects_are_not_there) {
  for (const char* gone : {"action='delete' visible='true'", "visible='false'"}) {
    std::string text;
    for (const MapNode& node : map_nodes) text += node_xml(node, "action='modify'");
    text += way_xml(map_ways[0]) + way_xml(map_ways[1], gone) + way_xml(map_ways[2], gone);
    const RoadNetwork roads = read(osm_xml(text, "version='0.6' upload='never' generator='JOSM'"));
    ASSERT_EQ(roads.paths.size(), 1U) << gone;
    EXPECT_EQ(roads.paths[0].osm_id, 101);
    EXPECT_NEAR(house_m2(osm_xml(text)), 0.0, 1e-9) << gone;
  }
}

TEST_F(OsmDialects, odd_users_numbers_and_elements_do_not_matter) {
  std::string text = "<note>made by hand</note><meta osm_base=\"2024-01-01T00:00:00Z\"/><bounds minlat='x'/>";
  for (const MapNode& node : map_nodes)
    text += node_xml(node, fmt::format("uid='-1' user='{}' version='v2' timestamp='yesterday' changeset=''",
                                       std::string(2000, 'x')));
  for (const MapWay& way : map_ways) {
    std::string xml = way_xml(way, "uid='many' user=''");
    text += xml.insert(xml.find('>') + 1, "<center lat='50' lon='15'/><bounds minlat='0'/>");
  }
  EXPECT_EQ(told(read(osm_xml(text))), whole_map);
  EXPECT_EQ(told(read(osm_xml(text, "generator='none'"))), whole_map) << "without a version";
}

TEST_F(OsmDialects, places_may_stand_in_the_ways) {
  std::string text;
  for (const MapWay& way : map_ways) text += way_xml(way, "", true);
  EXPECT_EQ(told(read(osm_xml(text))), whole_map);
  EXPECT_NEAR(house_m2(osm_xml(text)), 400.0, 1.0);
}

TEST_F(OsmDialects, nodes_of_ways_may_have_places_and_no_ids) {  // `out tags geom`
  std::string text;
  for (const MapWay& way : map_ways) {
    std::string xml = way_xml(way, "", true);
    for (std::size_t at = xml.find(" ref="); at != xml.npos; at = xml.find(" ref="))
      xml.erase(at, xml.find('"', at + 6) + 1 - at);
    text += xml;
  }
  const RoadNetwork roads = read(osm_xml(text));
  ASSERT_EQ(roads.paths.size(), 2U);
  EXPECT_EQ(roads.paths[0].nodes[1].osm_node, roads.paths[1].nodes[1].osm_node);
  EXPECT_NE(roads.paths[0].nodes[0].osm_node, roads.paths[1].nodes[0].osm_node);
  EXPECT_NEAR(house_m2(osm_xml(text)), 400.0, 1.0);
}

TEST_F(OsmDialects, ways_that_only_a_relation_draws_are_read) {
  std::string member = "<relation id=\"9\"><member type=\"way\" ref=\"103\" role=\"outer\">";
  for (const std::int64_t ref : map_ways[2].nodes) {
    const MapNode& node = *std::ranges::find(map_nodes, ref, &MapNode::id);
    const LonLat p = lonlat(node.x, node.y);
    member += fmt::format("<nd lat=\"{}\" lon=\"{}\"/>", p.lat, p.lon);
  }
  member += "</member><tag k=\"type\" v=\"multipolygon\"/><tag k=\"building\" v=\"yes\"/></relation>";
  EXPECT_NEAR(house_m2(osm_xml(member)), 400.0, 1.0);
}

TEST_F(OsmDialects, without_any_place_the_line_says_how_to_ask) {
  std::string text;
  for (const MapWay& way : map_ways) text += way_xml(way);
  EXPECT_THAT(failure(osm_xml(text)), HasSubstr("no nodes"));
  EXPECT_THAT(failure(osm_xml(text)), HasSubstr("out geom"));
}

TEST_F(OsmDialects, json_of_overpass_is_read_whatever_its_name) {
  std::string elements;
  for (const MapWay& way : map_ways)
    elements += fmt::format(R"({{"type":"way","id":{},"nodes":[{}],"tags":{{"{}":"{}"}}}},)", way.id,
                            fmt::join(way.nodes, ","), way.key, way.value);
  for (const MapNode& node : map_nodes) {
    const LonLat p = lonlat(node.x, node.y);
    elements += fmt::format(R"({{"type":"node","id":{},"lat":{},"lon":{}}},)", node.id, p.lat, p.lon);
  }
  elements.pop_back();
  const std::string text = R"({"version":0.6,"generator":"Overpass API","elements":[)" + elements + "]}";
  EXPECT_EQ(told(read(text, "a.json")), whole_map);
  EXPECT_EQ(told(read(text, "a.osm")), whole_map);
  EXPECT_NEAR(house_m2(text, "a.json"), 400.0, 1.0);
}

TEST_F(OsmDialects, what_is_no_map_is_said_by_name) {
  EXPECT_THAT(failure("<osmChange version='0.6'><modify/></osmChange>", "a.osc"), HasSubstr("OsmChange"));
  EXPECT_THAT(failure("<osmChange version='0.6'><modify/></osmChange>"), HasSubstr("osmium apply-changes"));
  EXPECT_THAT(failure("<gpx version='1.1'/>"), HasSubstr("GPX"));
  EXPECT_THAT(failure("<html><body>429</body></html>"), HasSubstr("web page"));
  EXPECT_THAT(failure("<kml/>"), HasSubstr("<kml>"));
  EXPECT_THAT(failure(R"({"type":"FeatureCollection","features":[]})", "a.geojson"), HasSubstr("GeoJSON"));
  EXPECT_THAT(failure(R"({"a":1})", "a.json"), HasSubstr("not of Overpass"));
  EXPECT_THAT(failure("{\"elements\":[", "a.json"), HasSubstr("truncated"));
  EXPECT_THAT(failure(osm_xml("<action type=\"modify\"/>")), HasSubstr("augmented diff"));
  EXPECT_THAT(failure(osm_xml("<remark> runtime error: Query timed out </remark>")), HasSubstr("not whole"));
  EXPECT_THAT(failure(osm_xml("<node lat='1' lon='1'/>")), HasSubstr("without id"));
  EXPECT_THAT(failure(osm_xml("", "version='0.5'")), HasSubstr("0.5"));
}

TEST_F(OsmDialects, an_object_in_several_extracts_counts_once_in_its_latest_version) {
  std::string nodes;
  for (const MapNode& node : map_nodes) nodes += node_xml(node, "version='1'");
  MapNode moved = map_nodes[3];
  moved.x = 95.0;
  write_bytes(scratch_ / "a.osm", osm_xml(nodes + way_xml(map_ways[0], "version='1'") + way_xml(map_ways[2])));
  write_bytes(scratch_ / "b.osm", osm_xml(nodes + node_xml(moved, "version='2'") + way_xml(map_ways[0], "version='1'") +
                                          way_xml(map_ways[1]) + way_xml(map_ways[2])));
  const std::vector<fs::path> files{scratch_ / "a.osm", scratch_ / "b.osm"};
  const std::string both = told(io::read_osm_roads(files, site_of(100)));
  EXPECT_EQ(both,
            "101 tertiary: 1@10.0,50.0 3@50.0,50.0 4@95.0,50.0\n"
            "102 residential: 2@50.0,10.0 3@50.0,50.0 5@50.0,90.0");
  EXPECT_EQ(told(io::read_osm_roads({files[1], files[0]}, site_of(100))), both) << "the order of the files";
  EXPECT_EQ(io::read_features(files, utm33).size(), 3U) << "two roads and one house";
}

TEST_F(OsmDialects, halves_of_a_way_that_extracts_cut_are_joined) {
  std::string nodes;
  for (const MapNode& node : map_nodes) nodes += node_xml(node);
  MapWay west = map_ways[0], east = map_ways[0];
  west.nodes = {1, 3}, east.nodes = {3, 4};
  write_bytes(scratch_ / "west.osm", osm_xml(nodes + way_xml(west) + way_xml(map_ways[1])));
  write_bytes(scratch_ / "east.osm", osm_xml(nodes + way_xml(east) + way_xml(map_ways[1])));
  const fs::path w = scratch_ / "west.osm", e = scratch_ / "east.osm";
  EXPECT_EQ(told(io::read_osm_roads({w, e}, site_of(100))), whole_map);
  EXPECT_EQ(told(io::read_osm_roads({e, w}, site_of(100))), whole_map);
}

TEST_F(OsmDialects, ways_that_are_not_there_are_told_and_left_out) {
  const auto codes_of = [&](const std::string& tags) {
    std::string text;
    for (const MapNode& node : map_nodes) text += node_xml(node);
    std::string way = way_xml(map_ways[1]);
    const std::size_t at = way.find("<tag");
    way = way.substr(0, at) + tags + "</way>";
    Findings findings;
    const RoadNetwork roads = read(osm_xml(text + way_xml(map_ways[0]) + way), "a.osm", &findings);
    EXPECT_EQ(roads.paths.size(), findings.empty() ? 2U : 1U) << tags;
    return findings.empty() ? std::string() : findings[0].code;
  };
  const auto tag = [](const char* key, const char* value) { return fmt::format("<tag k='{}' v='{}'/>", key, value); };
  const std::string street = tag("highway", "residential");
  for (const std::string& gone :
       {tag("highway", "proposed"), tag("highway", "construction") + tag("construction", "primary"),
        tag("abandoned:highway", "service"), tag("razed:highway", "residential"), street + tag("abandoned", "yes"),
        street + tag("bridge", "demolished"), street + tag("tunnel", "proposed")})
    EXPECT_EQ(codes_of(gone), "osm.not_built") << gone;
  EXPECT_EQ(codes_of(street + tag("area", "yes")), "osm.road_area");
  EXPECT_EQ(codes_of(street + tag("level", "2")), "osm.indoor_level");
  EXPECT_EQ(codes_of(street + tag("indoor", "yes") + tag("layer", "-1") + tag("tunnel", "yes")), "osm.indoor_level");
  for (const std::string& there :
       {street + tag("construction", "minor"), street + tag("was:highway", "track"), street + tag("historic", "yes"),
        street + tag("level", "0") + tag("indoor", "yes"), street + tag("level", "1") + tag("bridge", "yes")})
    EXPECT_EQ(codes_of(there), "") << there;
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// GeoJSON out and in.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/support/vector_io.hpp"
#include "orthodrive/io/vector/road_graph_io.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;

TEST(GeoJson, features_come_back_to_a_centimetre) {
  const Scratch scratch;
  Polygon with_hole = rectangle(origin.x, origin.y, origin.x + 40, origin.y + 30);
  with_hole.holes.push_back({origin + Vec2{5, 5}, origin + Vec2{5, 10}, origin + Vec2{10, 10}, origin + Vec2{10, 5}});
  const std::vector<io::Feature> features{
      {.polygons = {with_hole}, .tags = {{"id", "a"}, {"kind", "road"}}},
      {.polygons = {rectangle(origin.x + 50, origin.y, origin.x + 60, origin.y + 9),
                    rectangle(origin.x + 70, origin.y, origin.x + 75, origin.y + 9)}},
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
  EXPECT_THAT(bytes_of(scratch / "f.geojson"),
              HasSubstr(R"("code":"x.y","message":"Bad \"thing\"","severity":"error")"));
  EXPECT_THAT(bytes_of(scratch / "f.geojson"), HasSubstr("[15.0000000,50.01"));
  io::write_findings(scratch / "none.geojson", {}, utm33);
  EXPECT_TRUE(io::read_features(scratch / "none.geojson", utm33).empty());
}

TEST(GeoJson, road_graph_has_the_roads_before_and_after) {
  const Scratch scratch;
  const auto way = [](std::int64_t id, double north_m) {
    RoadPath path{.osm_id = id, .highway = "primary", .name = "Main St"};
    for (const double x : {0.0, 10.0}) path.nodes.push_back({.p = origin + Vec2{x, north_m}, .width_m = 6.0});
    return path;
  };
  const RoadNetwork before{.crs = utm33, .paths = {way(7, 0.0), way(8, 50.0)}};
  RoadNetwork after{.crs = utm33, .paths = {way(7, 3.0)}};
  for (RoadNode& node : after.paths[0].nodes) node.z_m = 240.1234, node.sigma_offset_m = 0.25, node.sigma_width_m = 0.5;
  after.paths[0].nodes[1].z_m = 241.0;
  io::write_road_graph(scratch / "g.geojson", before, after);
  const nlohmann::json features = nlohmann::json::parse(bytes_of(scratch / "g.geojson")).at("features");
  ASSERT_EQ(features.size(), 3u);
  EXPECT_EQ(features[0]["properties"]["state"], "before");
  EXPECT_EQ(features[0]["properties"]["osm_id"], 7);
  EXPECT_EQ(features[0]["properties"]["z_m"], (nlohmann::json{240.123, 241.0})) << "as high as where it was moved to";
  EXPECT_EQ(features[1]["properties"]["z_m"], (nlohmann::json{nullptr, nullptr})) << "nothing is left of way 8";
  EXPECT_EQ(features[2]["properties"]["state"], "after");
  EXPECT_EQ(features[2]["properties"]["width_m"], (nlohmann::json{6.0, 6.0}));
  EXPECT_EQ(features[2]["properties"]["sigma_offset_m"], (nlohmann::json{0.25, 0.25}));
  EXPECT_EQ(features[2]["properties"]["sigma_width_m"], (nlohmann::json{0.5, 0.5}));
  const std::vector<io::Feature> back = io::read_features(scratch / "g.geojson", utm33);
  EXPECT_NEAR(distance(back.at(2).lines.at(0).at(1), origin + Vec2{10, 3}), 0.0, 0.01);
}

TEST(GeoJson, truncated) {
  const Scratch scratch;
  io::write_geojson(scratch / "a.geojson", {{.lines = {{origin, origin + Vec2{10, 3}}}}}, utm33);
  truncate_to(scratch / "a.geojson", 0.7);
  EXPECT_THROW((void)io::read_features(scratch / "a.geojson", utm33), InputError);
}

}  // namespace
}  // namespace orthodrive

// GeoJSON out and in.

#include <gmock/gmock.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/vector_io.hpp"
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

TEST(GeoJson, truncated) {
  const Scratch scratch;
  io::write_geojson(scratch / "a.geojson", {{.lines = {{origin, origin + Vec2{10, 3}}}}}, utm33);
  truncate_to(scratch / "a.geojson", 0.7);
  EXPECT_THROW((void)io::read_features(scratch / "a.geojson", utm33), InputError);
}

}  // namespace
}  // namespace orthodrive

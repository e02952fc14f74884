// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/vector/control_point_reader.hpp"

namespace orthodrive {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string control_feature(double x_m, double y_m, const std::string& properties) {
  static const CoordinateTransform lonlat_from_site(utm33, Crs{"EPSG:4326"});
  const Vec2 p = lonlat_from_site.target_from_source(origin + Vec2{x_m, y_m});
  return fmt::format(
      R"({{"type":"Feature","properties":{{{}}},"geometry":{{"type":"Point","coordinates":[{:.9f},{:.9f}]}}}})",
      properties, p.x, p.y);
}
std::string collection(const std::string& features) {
  return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}
io::ControlPoints control_points_of(const std::string& text) {
  const Scratch scratch;
  write_bytes(scratch / "heights.geojson", text);
  return io::read_control_points({scratch / "heights.geojson"}, site_of(1000.0));
}
std::string refusal_of(const std::string& text) {
  try {
    (void)control_points_of(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

TEST(ControlPoints, fields_become_numbers_and_those_that_lack_have_defaults) {
  const io::ControlPoints read = control_points_of(collection(
      control_feature(100, 200, R"("z_m":312.5,"note":"nail in the kerb","sigma_m":null)") + "," +
      control_feature(300, 200, R"("z_m":"318","clearance_m":4.9,"sigma_m":0.02,"osm_id":123456789012,"layer":-1)")));
  ASSERT_EQ(read.points.size(), 2u);
  EXPECT_LT(distance(read.points[0].p, origin + Vec2{100, 200}), 1e-3);
  EXPECT_EQ(read.points[0].z_m, 312.5);
  EXPECT_TRUE(std::isnan(read.points[0].clearance_m));
  EXPECT_EQ(read.points[0].sigma_m, 0.05);
  EXPECT_EQ(read.points[0].osm_id, 0);
  EXPECT_FALSE(read.points[0].layer);
  EXPECT_EQ(read.points[1].z_m, 318.0);
  EXPECT_EQ(read.points[1].clearance_m, 4.9);
  EXPECT_EQ(read.points[1].sigma_m, 0.02);
  EXPECT_EQ(read.points[1].osm_id, 123456789012);
  EXPECT_EQ(read.points[1].layer, -1);
  EXPECT_TRUE(read.findings.empty());
}

TEST(ControlPoints, points_outside_the_area_are_findings) {
  const io::ControlPoints read = control_points_of(
      collection(control_feature(5000, 200, R"("z_m":312.5)") + "," + control_feature(-5, 200, R"("z_m":312.5)")));
  ASSERT_EQ(read.points.size(), 1u) << "roads at the edge of the area are as wide";
  ASSERT_EQ(read.findings.size(), 1u);
  EXPECT_EQ(read.findings[0].code, "control_points.outside_area");
  EXPECT_NEAR(read.findings[0].x_m, origin.x + 5000, 0.01);
  EXPECT_THAT(read.findings[0].message, HasSubstr("heights.geojson: feature 1"));
}

TEST(ControlPoints, malformed_files_are_one_line) {
  const std::string good = control_feature(1, 1, R"("z_m":1)") + ",";
  for (
      const auto& [text, said] : std::vector<std::pair<std::string, std::string>>{
          {collection(good + control_feature(1, 1, R"("z":300)")), "feature 2: has neither 'z_m'"},
          {collection(control_feature(1, 1, R"("z_m":"high")")), "'z_m' is 'high', need a number from -1500"},
          {collection(control_feature(1, 1, R"("z_m":1e9)")), "'z_m' is '1000000000'"},
          {collection(control_feature(1, 1, R"("z_m":"nan")")), "'z_m' is 'nan'"},
          {collection(control_feature(1, 1, R"("z_m":1,"sigma_m":0)")), "'sigma_m' is '0', need a number from 0.001"},
          {collection(control_feature(1, 1, R"("z_m":1,"layer":0.5)")), "'layer' is '0.5', need a whole number"},
          {collection(control_feature(1, 1, R"("z_m":1,"osm_id":-3)")), "'osm_id' is '-3'"},
          {collection(control_feature(1, 1, R"("clearance_m":-2)")), "'clearance_m' is '-2'"},
          {collection(""), "has no point"},
          {R"({"type":"Feature","properties":{"z_m":1},"geometry":{"type":"LineString","coordinates":[[15,50],[15.1,50]]}})",
           "feature 1: is no single point"},
          {"z_m,x,y\n", "heights.geojson"}}) {
    EXPECT_THAT(refusal_of(text), AllOf(HasSubstr("heights.geojson"), HasSubstr(said), Not(HasSubstr("\n"))));
  }
}

}  // namespace
}  // namespace orthodrive

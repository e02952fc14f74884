// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/osm/area_reader.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::io {
namespace {
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A square of 0.1 degrees in two ways, an island of 0.01 and a hole of 0.02; relation 7 has them all.
struct Town {
  std::string nodes, ways, members;
  Town() {
    square(1, 12.0, 57.0, 0.1, true);
    square(11, 12.2, 57.0, 0.01, false);
    square(21, 12.04, 57.04, 0.02, false, "inner");
  }
  void square(int id, double lon, double lat, double size, bool in_two, const char* role = "outer") {
    const double corners[4][2] = {{lon, lat}, {lon + size, lat}, {lon + size, lat + size}, {lon, lat + size}};
    for (int i = 0; i < 4; ++i)
      nodes += fmt::format("<node id=\"{}\" lon=\"{:.7f}\" lat=\"{:.7f}\"/>", id + i, corners[i][0], corners[i][1]);
    const auto way = [&](int way_id, const std::vector<int>& refs) {
      ways += fmt::format("<way id=\"{}\">", way_id);
      for (const int ref : refs) ways += fmt::format("<nd ref=\"{}\"/>", ref);
      ways += "</way>";
      members += fmt::format("<member type=\"way\" ref=\"{}\" role=\"{}\"/>", way_id, role);
    };
    if (in_two) {
      way(id, {id, id + 1, id + 2});
      way(id + 1, {id, id + 3, id + 2});
    } else {
      way(id, {id, id + 1, id + 2, id + 3, id});
    }
  }
  [[nodiscard]] std::string osm() const {
    return "<osm version=\"0.6\">" + nodes + ways + "<relation id=\"7\">" + members +
           "<tag k=\"type\" v=\"boundary\"/></relation><relation id=\"8\"><member type=\"node\" ref=\"1\" "
           "role=\"\"/></relation></osm>";
  }
};

std::string without(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  return text.erase(at, text.find(to, at) + to.size() - at);
}

class RelationTest : public testing::Test {
 protected:
  Scratch scratch;
  std::filesystem::path file = scratch / "town.osm";
  Town town;
  void expect_refused(const std::string& osm, std::int64_t id, const std::string& message) {
    write_bytes(file, osm);
    EXPECT_THAT([&] { (void)read_relation(file, id); }, ThrowsMessage<InputError>(HasSubstr(message)));
  }
};

TEST_F(RelationTest, its_ways_become_polygons_largest_first_with_their_holes) {
  write_bytes(file, town.osm());
  const MultiPolygon polygons = read_relation(file, 7);
  ASSERT_EQ(polygons.size(), 2u);
  EXPECT_NEAR(area_m2(polygons[0]), 0.1 * 0.1 - 0.02 * 0.02, 1e-9);
  ASSERT_EQ(polygons[0].holes.size(), 1u);
  EXPECT_EQ(polygons[0].outer.size(), 4u);
  EXPECT_NEAR(area_m2(polygons[1]), 0.01 * 0.01, 1e-9);
}

TEST_F(RelationTest, what_the_file_lacks_is_told) {
  expect_refused(town.osm(), 9, "has no relation 9 among its 2");
  expect_refused(town.osm(), 8, "has no way and so no area");
  expect_refused(without(town.osm(), "<way id=\"2\">", "</way>"), 7, "is incomplete: 1 of its 4 ways");
  expect_refused(without(town.osm(), "<node id=\"12\"", "/>"), 7, "is incomplete: 1 of its nodes");
  expect_refused(without(town.osm(), "<member type=\"way\" ref=\"2\"", "/>"), 7, "close no ring");
  expect_refused(town.osm().substr(0, 300), 7, "truncated");
  expect_refused("", 7, "is empty");
}

TEST(AreaReader, rings_of_geojson_are_checked_and_turned) {
  const Polygon polygon = polygon_of_rings({{{0, 0}, {0, 1}, {1, 1}, {1, 1}, {1, 0}, {0, 0}}});
  EXPECT_EQ(polygon.outer.size(), 4u);
  EXPECT_GT(signed_area_m2(polygon.outer), 0.0);
  EXPECT_THROW((void)polygon_of_rings({}), OptionError);
  EXPECT_THROW((void)polygon_of_rings({{{0, 0}, {0, 1}, {1, 1}}}), OptionError);
}

TEST(AreaReader, another_crs_than_wgs84_is_told) {
  const Scratch scratch;
  const std::string geometry = R"("type":"Polygon","coordinates":[[[0,0],[1,0],[1,1],[0,0]]])";
  const auto crs = [](const std::string& name) {
    return R"(,"crs":{"type":"name","properties":{"name":")" + name + R"("}}})";
  };
  write_bytes(scratch / "a.geojson", "{" + geometry + crs("urn:ogc:def:crs:OGC:1.3:CRS84"));
  EXPECT_EQ(read_areas(scratch / "a.geojson").size(), 1u);
  write_bytes(scratch / "a.geojson", "{" + geometry + crs("urn:ogc:def:crs:EPSG::25833"));
  EXPECT_THAT([&] { (void)read_areas(scratch / "a.geojson"); },
              ThrowsMessage<InputError>(HasSubstr("EPSG::25833; save it in WGS84")));
}

}  // namespace
}  // namespace orthodrive::io

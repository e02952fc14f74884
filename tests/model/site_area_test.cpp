// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/site_area.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {
using testing::AllOf;
using testing::HasSubstr;

std::string fault_of_box(const LonLatBox& box) {
  try {
    (void)site_frame_of(polygon_of_box(box));
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

std::string fault_of(const Ring& ring) {
  try {
    check_lonlat_area({ring, {}});
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

TEST(SiteArea, boxes_that_are_in_order_pass) {
  for (const LonLatBox& box : {LonLatBox{15.72, 50.01, 15.79, 50.05}, LonLatBox{-105.3, 39.9, -105.2, 40.0},
                               LonLatBox{-0.01, -0.01, 0.01, 0.01}, LonLatBox{179.9, -17.1, 180.0, -17.0},
                               LonLatBox{15.0, 83.9, 15.1, 84.0}, LonLatBox{18.4, -34.0, 18.5, -33.9}})
    EXPECT_EQ(fault_of_box(box), "") << box[0];
}

TEST(SiteArea, a_box_in_the_wrong_order_says_the_right_one) {
  const std::string right = "15.72,50.01,15.79,50.05";
  for (const LonLatBox& box : {LonLatBox{15.79, 50.01, 15.72, 50.05},   // east first
                               LonLatBox{15.72, 50.05, 15.79, 50.01},   // north first
                               LonLatBox{15.79, 50.05, 15.72, 50.01},   // north-east first
                               LonLatBox{15.72, 15.79, 50.01, 50.05},   // west, east, south, north
                               LonLatBox{50.01, 50.05, 15.72, 15.79}})  // south, north, west, east
    EXPECT_THAT(fault_of_box(box), AllOf(HasSubstr("did you mean "), HasSubstr(right))) << box[0] << " " << box[1];
  // Latitude first is a place, too, unless no such latitude exists.
  EXPECT_EQ(fault_of_box({50.01, 15.72, 50.05, 15.79}), "");
  EXPECT_THAT(fault_of_box({39.9, -105.3, 40.0, -105.2}), HasSubstr("did you mean -105.3,39.9,-105.2,40?"));
}

TEST(SiteArea, boxes_that_cannot_be_say_what_to_do) {
  EXPECT_THAT(fault_of_box({179.9, -17.1, -179.9, -17.0}),
              AllOf(HasSubstr("antimeridian"), HasSubstr("179.9,-17.1,180,-17 and -180,-17.1,-179.9,-17")));
  EXPECT_THAT(fault_of_box({15, 85, 15.1, 85.1}), HasSubstr("UTM ends at 84 degrees"));
  EXPECT_THAT(fault_of_box({15, -85.1, 15.1, -85}), HasSubstr("UTM ends at 84 degrees"));
  EXPECT_THAT(fault_of_box({15, 50, 15, 50.1}), HasSubstr("is empty"));
  EXPECT_THAT(fault_of_box({15, 50, 15.0001, 50.1}), HasSubstr("a site needs at least 50 m each way"));
  EXPECT_THAT(fault_of_box({500000, 5500000, 501000, 5501000}), HasSubstr("no such place on earth"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(fault_of_box({15, 50, nan, 51}), HasSubstr("need four numbers"));
}

TEST(SiteArea, rings_that_cannot_be_say_where) {
  EXPECT_EQ(fault_of({{15, 50}, {15.1, 50}, {15.05, 50.1}}), "");
  EXPECT_THAT(fault_of({{15, 50}, {15.1, 50.1}, {15.1, 50}, {15, 50.1}}),
              HasSubstr("crosses or touches itself near 15.050000, 50.050000"));
  EXPECT_THAT(fault_of({{15, 50}, {15.1, 50}}), HasSubstr("has 2 corners, a polygon needs three"));
  EXPECT_THAT(fault_of({}), HasSubstr("has no corner"));
  EXPECT_THAT(fault_of({{15, 50}, {15.1, 50}, {15.2, 50}}), HasSubstr("crosses or touches itself"));  // no area
  EXPECT_THAT(fault_of({{179, 50}, {-179, 50}, {-179, 51}, {179, 51}}), HasSubstr("antimeridian"));
  EXPECT_THAT(fault_of({{5e5, 5e6}, {5.1e5, 5e6}, {5e5, 5.1e6}}), HasSubstr("save it in WGS84"));
}

TEST(SiteArea, a_hole_stays_and_counts) {
  const Polygon ring{{{15, 50}, {15.1, 50}, {15.1, 50.1}, {15, 50.1}}, {}};
  Polygon holed = ring;
  holed.holes.push_back({{15.04, 50.04}, {15.04, 50.06}, {15.06, 50.06}, {15.06, 50.04}});
  EXPECT_NEAR(area_m2(site_frame_of(holed).area) / area_m2(site_frame_of(ring).area), 0.96, 1e-4);
}

TEST(SiteArea, the_zone_is_that_of_the_middle) {
  EXPECT_EQ(site_frame_of(polygon_of_box({11.9, 50, 12.3, 50.1})).crs.definition, "EPSG:32633");
  EXPECT_EQ(site_frame_of(polygon_of_box({11.7, 50, 12.1, 50.1})).crs.definition, "EPSG:32632");
  EXPECT_EQ(site_frame_of(polygon_of_box({11.7, -50.1, 12.1, -50})).crs.definition, "EPSG:32732");
  EXPECT_EQ(site_frame_of(polygon_of_box({179.9, 0, 180, 0.1})).crs.definition, "EPSG:32660");
}

TEST(SiteArea, far_from_the_meridian_is_a_finding_with_the_error_of_lengths) {
  const Polygon near = polygon_of_box({11.8, 0.0, 12.2, 0.1});  // across a border of zones: 3.2 degrees
  EXPECT_TRUE(findings_of_area(near, site_frame_of(near)).empty());
  const Polygon wide = polygon_of_box({5.5, 0.0, 10.0, 0.2});  // zone 32, whose middle is 9
  const Findings findings = findings_of_area(wide, site_frame_of(wide));
  EXPECT_TRUE(findings.empty());  // 3.5 degrees
  const Polygon far = polygon_of_box({4.7, 0.0, 4.8, 0.1});
  const SiteFrame frame = site_frame_of(far, "EPSG:32632");
  const Findings off = findings_of_area(far, frame);
  ASSERT_EQ(off.size(), 1u);
  // Exact: the length in the plane of a tenth of a degree of longitude on the equator, over its true one.
  const CoordinateTransform transform(Crs{"EPSG:4326"}, frame.crs);
  const double plane = distance(transform.target_from_source({4.7, 0}), transform.target_from_source({4.701, 0}));
  const double per_mille = 1000.0 * (plane / (6378137.0 * 0.001 * std::numbers::pi / 180.0) - 1.0);
  EXPECT_THAT(off[0].message, HasSubstr(std::to_string(per_mille).substr(0, 3) + " per mille"));
}

TEST(SiteArea, a_crs_of_degrees_is_refused) {
  const Polygon box = polygon_of_box({15, 50, 15.1, 50.1});
  EXPECT_THROW((void)site_frame_of(box, "EPSG:4326"), OptionError);
  EXPECT_THROW((void)site_frame_of(box, "EPSG:1"), Error);
  EXPECT_EQ(site_frame_of(box, "EPSG:5514").crs.definition, "EPSG:5514");
}

TEST(SiteArea, a_crs_whose_unit_is_no_metre_on_the_ground_is_refused_with_its_scale) {
  const auto fault = [](const char* crs, Vec2 lonlat) {
    try {
      check_scale({crs}, lonlat);
    } catch (const OptionError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const Vec2 place{15.0, 47.5}, york{-74.0, 40.7};
  EXPECT_THAT(fault("EPSG:3857", place),
              testing::AllOf(HasSubstr("'EPSG:3857' has a unit of 0.67"), HasSubstr("leave area.crs out for UTM")));
  EXPECT_THAT(fault("EPSG:3395", place), HasSubstr("unit of 0.67"));
  EXPECT_THAT(fault("EPSG:2263", york), HasSubstr("unit of 0.305 m"));
  EXPECT_THAT(fault("+proj=eqc +datum=WGS84 +units=m", place), HasSubstr("unit of 0.67"));
  EXPECT_THAT(fault("+proj=tmerc +lat_0=0 +lon_0=15 +datum=WGS84 +units=km", place), HasSubstr("unit of 1e+03 m"));
  for (const char* national : {"EPSG:32633", "EPSG:31287", "EPSG:3035", "EPSG:5514"})
    EXPECT_EQ(fault(national, place), "") << national;
  EXPECT_EQ(fault("EPSG:2154", {9.2, 42.0}), "");  // Corsica, at the rim of Lambert 93
  EXPECT_EQ(fault("EPSG:32618", york), "");
  EXPECT_THROW(check_crs({"EPSG:4978"}), OptionError);              // from the middle of the earth
  const Polygon equator = polygon_of_box({36.8, -0.1, 36.9, 0.0});  // mercator is off by 7 per mille northwards
  const Findings findings = findings_of_area(equator, site_frame_of(equator, "EPSG:3857"));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, "area.scale");
  EXPECT_THAT(findings[0].message, HasSubstr("off by 6.7 per mille"));
}

}  // namespace
}  // namespace orthodrive

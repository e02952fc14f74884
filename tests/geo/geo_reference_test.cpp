// SPDX-License-Identifier: Apache-2.0
// CRSs as text for others: who reads it finds the place; what a unit is on the ground; places of thin areas.

#include "orthodrive/geo/geo_reference.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/area_places.hpp"
#include "orthodrive/geo/ground_scale.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
using testing::StartsWith;

const Crs lonlat_crs{"EPSG:4326"};

struct NationalCrs {
  const char* code;
  Vec2 lonlat;  ///< in the country
};
/// The CRSs in which road authorities of these countries hold their data, and older ones that are still met.
const std::vector<NationalCrs> national_crss{
    {"EPSG:27700", {-1.5, 52.5}},   {"EPSG:28992", {5.4, 52.1}},    {"EPSG:31370", {4.5, 50.6}},
    {"EPSG:5514", {15.8, 50.0}},    {"EPSG:31467", {9.2, 48.8}},    {"EPSG:23700", {19.1, 47.5}},
    {"EPSG:31700", {26.1, 44.4}},   {"EPSG:3844", {26.1, 44.4}},    {"EPSG:3912", {14.5, 46.05}},
    {"EPSG:3794", {14.5, 46.05}},   {"EPSG:21781", {7.45, 46.95}},  {"EPSG:2056", {8.54, 47.37}},
    {"EPSG:31287", {14.3, 48.3}},   {"EPSG:31256", {16.4, 48.2}},   {"EPSG:2393", {24.9, 60.2}},
    {"EPSG:3067", {24.9, 60.2}},    {"EPSG:27572", {2.35, 48.85}},  {"EPSG:2154", {5.4, 43.3}},
    {"EPSG:3003", {9.2, 45.5}},     {"EPSG:29902", {-6.3, 53.35}},  {"EPSG:2157", {-6.3, 53.35}},
    {"EPSG:2180", {21.0, 52.2}},    {"EPSG:2177", {19.0, 50.3}},    {"EPSG:3006", {18.1, 59.3}},
    {"EPSG:23030", {-3.7, 40.4}},   {"EPSG:2100", {23.7, 38.0}},    {"EPSG:3763", {-9.1, 38.7}},
    {"EPSG:20790", {-9.1, 38.7}},   {"EPSG:2193", {174.8, -41.3}},  {"EPSG:27200", {174.8, -41.3}},
    {"EPSG:28355", {145.0, -37.8}}, {"EPSG:7855", {145.0, -37.8}},  {"EPSG:2451", {139.7, 35.7}},
    {"EPSG:30169", {139.7, 35.7}},  {"EPSG:26710", {-122.3, 47.6}}, {"EPSG:26910", {-122.3, 47.6}},
    {"EPSG:29101", {-47.9, -15.8}}, {"EPSG:2326", {114.2, 22.3}},   {"EPSG:5186", {127.0, 37.5}},
    {"EPSG:3346", {25.3, 54.7}},    {"EPSG:3301", {24.8, 59.4}},    {"EPSG:5179", {127.0, 37.5}},
    {"EPSG:27429", {-8.6, 41.1}},   {"EPSG:3765", {16.0, 45.8}},    {"EPSG:7405", {-1.5, 52.5}},
};

double apart_m(Vec2 lonlat_a, Vec2 lonlat_b) {
  const Vec3 d = ecef_from_geographic(lonlat_a.x, lonlat_a.y, 0.0) - ecef_from_geographic(lonlat_b.x, lonlat_b.y, 0.0);
  return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
}

TEST(GeoReference, readers_of_national_crss_find_the_place_both_ways) {
  for (const auto& [code, lonlat] : national_crss) {
    SCOPED_TRACE(code);
    const CoordinateTransform meant(Crs{code}, lonlat_crs);
    const Vec2 p = meant.source_from_target(lonlat);
    const Box2 site = Box2{p.x, p.y, p.x, p.y}.grown(5000.0);  // 10 x 10 km
    const std::string text = geo_reference(Crs{code}, site);
    EXPECT_THAT(text, StartsWith("+proj="));  // simulators read no WKT
    EXPECT_EQ(text.find("no_defs"), std::string::npos);
    const CoordinateTransform read(Crs{text}, lonlat_crs);
    for (const Vec2 q : {p, Vec2{site.min_x, site.max_y}, Vec2{site.max_x, site.min_y}}) {
      EXPECT_LT(apart_m(read.target_from_source(q), meant.target_from_source(q)), 0.5) << text;
      EXPECT_LT(distance(read.source_from_target(meant.target_from_source(q)), q), 0.5) << text;
    }
    EXPECT_LT(apart_m(read.target_from_source(p), meant.target_from_source(p)), 0.01) << text;
  }
}

TEST(GeoReference, what_needs_no_shift_is_the_proj_string) {
  const Box2 box{460000.0, 5270000.0, 461000.0, 5271000.0};
  for (const char* code : {"EPSG:32633", "EPSG:25833", "EPSG:3006"})
    EXPECT_EQ(geo_reference({code}, box), proj_string({code})) << code;
  EXPECT_EQ(geo_reference({"EPSG:32633"}, box), "+proj=utm +zone=33 +datum=WGS84 +units=m");
  EXPECT_EQ(geo_reference({"EPSG:32633+5773"}, box), "+proj=utm +zone=33 +datum=WGS84 +units=m");  // sea level: no word
  const std::string shifted = "+proj=tmerc +lat_0=0 +lon_0=15 +ellps=bessel +towgs84=600,70,400,0,0,0,0 +units=m";
  EXPECT_THAT(geo_reference({shifted}, {0.0, 5e6, 1e3, 5.001e6}), HasSubstr("+towgs84=600,70,400,0,0,0,0"));
}

TEST(GeoReference, what_no_proj_string_says_is_wkt_on_one_line) {
  // Axes to the west and south: PROJ.4 text has them, PROJ's reading of it is what counts; oblique ones without a name.
  const Crs odd{"EPSG:5513"};
  const CoordinateTransform meant(odd, lonlat_crs);
  const Vec2 p = meant.source_from_target({15.8, 50.0});
  const std::string text = geo_reference(odd, Box2{p.x, p.y, p.x, p.y}.grown(1000.0));
  EXPECT_EQ(text.find('\n'), std::string::npos);
  EXPECT_LT(apart_m(CoordinateTransform(Crs{text}, lonlat_crs).target_from_source(p), {15.8, 50.0}), 1.0) << text;
}

TEST(GeoReference, an_unknown_crs_is_refused_and_a_box_beyond_the_earth_is_not) {
  EXPECT_THROW((void)geo_reference({"EPSG:1"}, {}), Error);
  EXPECT_THAT(geo_reference({"EPSG:31467"}, {1e12, 1e12, 2e12, 2e12}), StartsWith("+proj=tmerc"));
}

TEST(GeoReference, two_names_of_one_crs_are_the_same_place_and_two_datums_are_not) {
  const Vec2 p{460000.0, 5270000.0};
  EXPECT_TRUE(is_same_place({"EPSG:32633"}, {"+proj=utm +zone=33 +datum=WGS84 +units=m"}, p));
  EXPECT_FALSE(is_same_place({"EPSG:32633"}, {"EPSG:32632"}, p));
  EXPECT_FALSE(is_same_place({"EPSG:31467"}, {proj_string({"EPSG:31467"})}, {3500000.0, 5400000.0}));
  EXPECT_FALSE(is_same_place({"EPSG:32633"}, {"no CRS"}, p));
}

TEST(GroundScale, metres_feet_degrees_and_mercator) {
  const Vec2 place{14.5, 47.6};
  const double cosine = std::cos(place.y * std::numbers::pi / 180.0);
  EXPECT_LT(ground_scale({"EPSG:32633"}, place).error(), 0.0005);
  EXPECT_LT(ground_scale({"EPSG:31287"}, place).error(), 0.0005);
  const GroundScale mercator = ground_scale({"EPSG:3857"}, place);
  EXPECT_NEAR(mercator.least_m, cosine, 0.005);  // Snyder: secant of the latitude, on a sphere
  EXPECT_NEAR(mercator.most_m, cosine, 0.005);
  EXPECT_NEAR(ground_scale({"EPSG:3395"}, place).least_m, cosine * 1.0018, 1e-3);
  const GroundScale feet = ground_scale({"EPSG:2263"}, {-74.0, 40.7});
  EXPECT_NEAR(feet.least_m, 0.3048, 1e-4);
  EXPECT_NEAR(feet.most_m, feet.least_m, 1e-6);  // conformal
  EXPECT_NEAR(ground_scale({"EPSG:4326"}, place).most_m, 111170.0, 100.0);
  const GroundScale plate = ground_scale({"+proj=eqc +datum=WGS84 +units=m"}, place);  // true to the north alone
  EXPECT_NEAR(plate.least_m, cosine, 0.005);
  EXPECT_NEAR(plate.most_m, 1.0, 0.005);
  EXPECT_TRUE(std::isfinite(ground_scale({"EPSG:5041"}, {0.0, 90.0}).error()));
  EXPECT_THROW((void)ground_scale({"EPSG:1"}, place), Error);
}

std::size_t places_of(const Polygon& area, double step_m, double& farthest_m) {
  std::size_t places = 0;
  farthest_m = 0.0;
  const Box2 box = bounds_of(area.outer).grown(1e-6);
  visit_area(area, step_m, [&](Vec2 p) {
    ++places;
    EXPECT_TRUE(box.contains(p));
    farthest_m = std::max(farthest_m, distance(p, area.outer.front()));
  });
  return places;
}

TEST(AreaPlaces, small_thin_and_flat_areas_have_places_all_along) {
  const Vec2 o{460003.0, 5270007.0};
  double farthest_m = 0.0;
  EXPECT_EQ(places_of({{o, o + Vec2{100, 0}, o + Vec2{100, 100}, o + Vec2{0, 100}}, {}}, 1.0, farthest_m), 10000u);
  const Polygon strip{{o, o + Vec2{280, 0}, o + Vec2{280, 8}, o + Vec2{0, 8}}, {}};
  EXPECT_GT(places_of(strip, 30.0, farthest_m), 200u);
  EXPECT_GT(farthest_m, 270.0);
  const Polygon slanting{{o, o + Vec2{200, 200}, o + Vec2{199.9, 200.1}}, {}};
  EXPECT_GT(places_of(slanting, 30.0, farthest_m), 50u);
  EXPECT_GT(farthest_m, 250.0);
  EXPECT_GT(places_of({{o, o + Vec2{280, 0}}, {}}, 30.0, farthest_m), 200u);  // the hull of one straight road
  EXPECT_GT(farthest_m, 270.0);
  EXPECT_GT(places_of({{o, o + Vec2{0.2, 0}, o + Vec2{0.2, 0.2}, o + Vec2{0, 0.2}}, {}}, 30.0, farthest_m), 100u);
  EXPECT_EQ(places_of({{o}, {}}, 30.0, farthest_m), 1u);
  EXPECT_EQ(places_of({}, 30.0, farthest_m), 0u);
}

}  // namespace
}  // namespace orthodrive

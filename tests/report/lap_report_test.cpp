// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/lap_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/drive/drive_route.hpp"
#include "orthodrive/geo/crs.hpp"
#include "orthodrive/report/lap_exchange.hpp"
#include "orthodrive/report/lap_table.hpp"

namespace orthodrive {
namespace {

using namespace test;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(LapReport, csv_has_the_agreed_columns_and_a_row_a_sample) {
  const DriveResult lap = simulate_lap(map_of({make_circle(1, 30.0)}), family());
  const std::string csv = lap_csv(lap);
  EXPECT_THAT(csv,
              StartsWith("t_s,s_m,x_m,y_m,z_m,heading_rad,pitch_rad,roll_rad,speed_mps,a_lon_mps2,a_lat_mps2,"
                         "curvature_1pm,gradient,road_id,road_s_m,road_t_m,z_fl_m,z_fr_m,z_rl_m,z_rr_m,a_vert_mps2,"));
  EXPECT_THAT(csv, HasSubstr(",throttle,brake,gear,engine_rpm,fuel_kg,load_fl_n,"));
  EXPECT_THAT(csv, HasSubstr("\n0.000,"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), lap.samples.size() + 1);
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), ',')), 51 * (lap.samples.size() + 1));
  EXPECT_THAT(csv, Not(HasSubstr("nan")));
}

TEST(LapReport, page_is_complete_and_escapes_names) {
  Road circle = make_circle(1, 30.0);
  circle.name = "R&D <Ring>";
  const RoadMap map = map_of({circle});
  const std::string html = lap_report_html(map, simulate_lap(map, family()));
  EXPECT_THAT(html, StartsWith("<!doctype html>"));
  EXPECT_THAT(html, HasSubstr("R&amp;D &lt;Ring&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, Not(HasSubstr("http://localhost")));
  std::size_t plots = 0;
  for (std::size_t at = html.find("role=\"img\""); at != std::string::npos; at = html.find("role=\"img\"", at + 1))
    ++plots;
  EXPECT_EQ(plots, 12u);
}

TEST(LapTable, cycle_has_a_row_a_second) {
  const DriveResult lap = simulate_lap(map_of({make_circle(1, 60.0)}), family());
  const std::string cycle = cycle_csv(lap);
  EXPECT_THAT(cycle, StartsWith("time_s,speed_kmh,gradient_percent,height_m,distance_m,gear\n0,"));
  EXPECT_EQ(std::count(cycle.begin(), cycle.end(), '\n'), 1 + static_cast<long>(std::ceil(lap.samples.size() / 100.0)));
}

TEST(LapExchange, gpx_leads_back_to_where_the_car_was) {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.3, 120.0, Line{}}, 250.0);
  const DriveResult lap = simulate_lap(map_of({road}), family());
  const std::string text = lap_gpx(lap, "EPSG:32633");
  pugi::xml_document gpx;
  ASSERT_TRUE(gpx.load_string(text.c_str()));
  const CoordinateTransform back(Crs{"EPSG:4326"}, Crs{"EPSG:32633"});
  std::size_t i = 0;
  for (const pugi::xml_node point : gpx.child("gpx").child("trk").child("trkseg").children("trkpt")) {
    const DriveSample& s = lap.samples[std::min(i, lap.samples.size() - 1)];
    const Vec2 p = back.target_from_source({point.attribute("lon").as_double(), point.attribute("lat").as_double()});
    ASSERT_NEAR(p.x, s.x_m, 0.01);
    ASSERT_NEAR(p.y, s.y_m, 0.01);
    ASSERT_NEAR(point.child("ele").text().as_double(), s.z_m, 1e-3);
    i += 10;
  }
  EXPECT_GT(i, lap.samples.size() - 10);
  EXPECT_THAT(text, HasSubstr("<time>2000-01-01T00:00:00.100Z</time>"));
  EXPECT_THROW((void)lap_gpx(lap, "no such system"), Error);
}

TEST(LapExchange, openscenario_leads_the_rear_axle_along_the_way_in_time) {
  Road road = make_road(1, {0.0, 458000.0, 5540000.0, 0.3, 120.0, Line{}}, 250.0);
  const DriveResult lap = simulate_lap(map_of({road}), family());
  pugi::xml_document doc;
  ASSERT_TRUE(doc.load_string(lap_openscenario(lap, "../a&b.xodr").c_str()));
  const pugi::xml_node root = doc.child("OpenSCENARIO");
  EXPECT_STREQ(root.child("RoadNetwork").child("LogicFile").attribute("filepath").value(), "../a&b.xodr");
  const pugi::xpath_node_set vertices = root.select_nodes("//FollowTrajectoryAction//Polyline/Vertex");
  ASSERT_GE(vertices.size(), lap.samples.size() / 10);
  double last_s = -1.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const pugi::xml_node vertex = vertices[i].node(), place = vertex.child("Position").child("WorldPosition");
    const DriveSample& s = lap.samples[std::min(10 * i, lap.samples.size() - 1)];
    EXPECT_GT(vertex.attribute("time").as_double(), last_s);
    last_s = vertex.attribute("time").as_double();
    ASSERT_NEAR(last_s, s.t_s, 1e-3);
    ASSERT_NEAR(std::hypot(place.attribute("x").as_double() - s.x_m, place.attribute("y").as_double() - s.y_m),
                0.5 * lap.car.body.wheelbase_m, 0.01);
    ASSERT_NEAR(place.attribute("h").as_double(), s.heading_rad, 1e-5);
  }
}

}  // namespace
}  // namespace orthodrive

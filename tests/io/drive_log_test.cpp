// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "io/npy_bytes.hpp"
#include "io/places.hpp"
#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/opendrive/drive_log_io.hpp"
#include "orthodrive/io/support/npy_reader.hpp"
#include "paths.hpp"

namespace orthodrive {
namespace {

using io::read_drive_logs;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Npy, both_orders_and_several_types_are_read) {
  const Scratch scratch;
  write_bytes(scratch / "c.npy", npy<double>("<f8", "(2, 3)", {1, 2, 3, 4, 5, 6}));
  write_bytes(scratch / "f.npy", npy<double>("<f8", "(2, 3)", {1, 4, 2, 5, 3, 6}, "True"));
  write_bytes(scratch / "s.npy", npy<float>("<f4", "(3,)", {0.5f, -1.0f, 2.0f}));
  write_bytes(scratch / "i.npy", npy<std::int32_t>("<i4", "(2,)", {7, -8}));
  for (const char* name : {"c.npy", "f.npy"}) {
    const io::NpyTable table = io::read_npy(scratch / name);
    EXPECT_EQ(table.rows, 2u);
    EXPECT_EQ(table.columns, 3u);
    EXPECT_THAT(table.values, ElementsAre(1, 2, 3, 4, 5, 6));
  }
  EXPECT_THAT(io::read_npy(scratch / "s.npy").values, ElementsAre(0.5, -1.0, 2.0));
  EXPECT_THAT(io::read_npy(scratch / "i.npy").values, ElementsAre(7, -8));
}

TEST(Npy, what_is_wrong_is_said) {
  const Scratch scratch;
  const auto told = [&](const std::string& bytes) {
    write_bytes(scratch / "a.npy", bytes);
    return message_of<InputError>([&] { (void)io::read_npy(scratch / "a.npy"); });
  };
  EXPECT_THAT(told("lat,lon\n"), HasSubstr("no .npy file"));
  EXPECT_THAT(told(npy<double>(">f8", "(1,)", {1})), HasSubstr("little-endian"));
  EXPECT_THAT(told(npy<double>("<f8", "(1, 1, 1)", {1})), HasSubstr("3 dimensions"));
  EXPECT_THAT(told(npy<double>("<f8", "(4, 2)", {1, 2, 3})), AllOf(HasSubstr("4 x 2"), HasSubstr("3 are there")));
  EXPECT_THAT(told(npy<double>("<f8", "(9999999999999999, 2)", {1, 2, 3})), HasSubstr("cut off"));
  EXPECT_THAT(told(npy<double>("<f8", "(2,)", {1, 2}).substr(0, 30)), HasSubstr("in its header"));
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_npy(scratch / "none.npy"); }), HasSubstr("no such file"));
}

Vec2 lonlat_of(Vec2 p) {
  static const CoordinateTransform lonlat_from_site(utm33, Crs{"EPSG:4326"});
  return lonlat_from_site.target_from_source(origin + p);
}
std::string row(double time, Vec2 p, const std::string& more = "") {
  const Vec2 lonlat = lonlat_of(p);
  return fmt::format("{},{:.9f},{:.9f}{}\n", time, lonlat.y, lonlat.x, more);
}
io::DriveLogs read_text(const std::string& text) {
  const Scratch scratch;
  write_bytes(scratch / "drive.csv", text);
  return read_drive_logs({scratch / "drive.csv"}, site_of(1000.0));
}

TEST(DriveLogCsv, all_columns_arrive_with_units_and_signs) {
  const auto read = read_text(
      "# a "
      "comment\ntime_s,lat,lon,alt_m,sigma_m,roll_deg,pitch_deg,heading_deg,acc_x_mps2,acc_y_mps2,acc_z_mps2,yaw_rate_"
      "dps,speed_mps,climb_mps\n" +
      row(1.0, {100, 200}, ",50.5,0.8,2,-3,90,0.1,0.2,9.8,10,15,-0.5") +
      row(1.1, {101.5, 200}, ",50.4,0.8,2,-3,0,0.1,0.2,9.8,10,15,-0.5"));
  EXPECT_THAT(read.findings, IsEmpty());
  ASSERT_EQ(read.log.recordings.size(), 1u);
  EXPECT_EQ(read.log.crs, utm33);
  EXPECT_THAT(read.log.sources, ElementsAre("drive.csv"));
  const DriveRecording& recording = read.log.recordings[0];
  ASSERT_EQ(recording.poses.size(), 2u);
  ASSERT_EQ(recording.imu.size(), 2u);
  const DrivePose& pose = recording.poses[0];
  EXPECT_LT(distance(pose.p, origin + Vec2{100, 200}), 1e-3);
  EXPECT_EQ(pose.z_m, 50.5);
  EXPECT_EQ(pose.sigma_p_m, 0.8);
  EXPECT_NEAR(pose.roll_rad, 2 * std::numbers::pi / 180, 1e-12);
  EXPECT_NEAR(pose.pitch_rad, -3 * std::numbers::pi / 180, 1e-12);
  EXPECT_NEAR(pose.heading_rad, 0.0, 1e-4);  // east; the site is on the central meridian
  EXPECT_NEAR(recording.poses[1].heading_rad, std::numbers::pi / 2, 1e-4);
  EXPECT_EQ(pose.speed_mps, 15.0);
  EXPECT_EQ(pose.climb_mps, -0.5);
  EXPECT_EQ(recording.imu[1].specific_force_mps2.y, 0.2);
  EXPECT_NEAR(recording.imu[1].yaw_rate_radps, 10 * std::numbers::pi / 180, 1e-12);
}

TEST(DriveLogCsv, missing_columns_and_cells_are_not_recorded) {
  const auto read = read_text("lon,extra,time_s,lat,acc_z_mps2\n" +
                              fmt::format("{1:.9f},x,1,{0:.9f},9.7\n,,1.01,,9.9\n{1:.9f},x,1.02,{0:.9f},\n",
                                          lonlat_of({10, 10}).y, lonlat_of({10, 10}).x));
  ASSERT_EQ(read.findings.size(), 2u);
  EXPECT_EQ(read.findings[0].code, "drive_log.unknown_column");
  EXPECT_THAT(read.findings[0].message, HasSubstr("extra"));
  EXPECT_EQ(read.findings[1].code, "drive_log.no_attitude");  // such poses say nothing of gradients
  ASSERT_EQ(read.log.recordings.size(), 1u);
  const DriveRecording& recording = read.log.recordings[0];
  EXPECT_EQ(recording.poses.size(), 2u);
  ASSERT_EQ(recording.imu.size(), 3u);  // the row without position as well
  EXPECT_EQ(recording.imu[1].specific_force_mps2.z, 9.9);
  EXPECT_TRUE(std::isnan(recording.imu[2].specific_force_mps2.z));
  for (const double value : {recording.poses[0].z_m, recording.poses[0].roll_rad, recording.poses[0].heading_rad,
                             recording.poses[0].speed_mps, recording.imu[0].yaw_rate_radps})
    EXPECT_TRUE(std::isnan(value));
}

TEST(DriveLogCsv, gaps_and_jumps_split_with_a_finding) {
  std::string text = "time_s,lat,lon,alt_m,speed_mps\n";
  for (int i = 0; i < 40; ++i) {
    const double gap_s = i >= 10 ? 5.0 : 0.0;
    const Vec2 jump = i >= 20 && i < 30 ? Vec2{0, 60} : Vec2{};
    text += row(0.1 * i + gap_s, Vec2{100 + 1.0 * i, 100} + jump, i >= 35 ? ",58,10" : ",50,10");  // 8 m up at the end
  }
  const auto read = read_text(text);
  std::vector<std::size_t> sizes;
  for (const DriveRecording& recording : read.log.recordings) {
    sizes.push_back(recording.poses.size());
    EXPECT_EQ(recording.source, 0u);
  }
  EXPECT_THAT(sizes, ElementsAre(10, 10, 10, 5, 5));
  std::vector<std::string> codes;
  for (const Finding& finding : read.findings) codes.push_back(finding.code);
  EXPECT_THAT(codes, ElementsAre("drive_log.gap", "drive_log.jump", "drive_log.jump", "drive_log.jump"));
  EXPECT_NEAR(read.findings[1].y_m, origin.y + 160, 1e-3);
}

TEST(DriveLogCsv, poses_without_place_order_or_area_are_left_out) {
  const auto read = read_text("time_s,lat,lon,alt_m\n" + row(1, {10, 10}, ",5") + "1.1,0,0,5\n" +
                              row(0.5, {11, 10}, ",5") + row(1.2, {12, 10}, ",5") + row(1.3, {9000, 10}, ",5"));
  ASSERT_EQ(read.log.recordings.size(), 1u);
  EXPECT_EQ(read.log.recordings[0].poses.size(), 2u);
  std::vector<std::string> codes;
  for (const Finding& finding : read.findings) codes.push_back(finding.code);
  EXPECT_THAT(codes, ElementsAre("drive_log.no_position", "drive_log.time_order", "drive_log.outside_area"));
}

TEST(DriveLogCsv, errors_name_the_line) {
  const auto told = [](const std::string& text) { return message_of<InputError>([&] { (void)read_text(text); }); };
  EXPECT_THAT(told(""), HasSubstr("empty"));
  EXPECT_THAT(told("time_s,lat\n1,2\n"), HasSubstr("no column lon"));
  EXPECT_THAT(told("time_s,lat,lon,lat\n"), HasSubstr("twice"));
  EXPECT_THAT(told("time_s,lat,lon\n1,50,15\n2,50\n"), AllOf(HasSubstr("line 3"), HasSubstr("2 values")));
  EXPECT_THAT(told("time_s,lat,lon\n1,50,here\n"), AllOf(HasSubstr("line 2"), HasSubstr("lon is 'here'")));
  EXPECT_THAT(told("time_s,lat,lon\n"), HasSubstr("no pose"));
  EXPECT_THAT(message_of<InputError>([] { (void)read_drive_logs({"/nowhere/a.csv"}, site_of(10)); }),
              HasSubstr("no such drive log"));
}

/// A comma2k19 segment of a car that drives north-east, nose up by 3 degrees, left side up by 2.
TEST(DriveLogComma, axes_become_those_of_iso_8855) {
  const Scratch scratch;
  const double deg = std::numbers::pi / 180.0, yaw = 45 * deg, pitch = -3 * deg, roll = 2 * deg;
  const Vec2 lonlat = lonlat_of({300, 300});
  const double lon = lonlat.x * deg, lat = lonlat.y * deg;
  const std::array<Vec3, 3> enu{Vec3{-std::sin(lon), std::cos(lon), 0},
                                Vec3{-std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat)},
                                Vec3{std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)}};
  const auto ecef = [&](double e, double n, double u) { return enu[0] * e + enu[1] * n + enu[2] * u; };
  const double cy = std::cos(yaw), sy = std::sin(yaw), cp = std::cos(pitch), sp = std::sin(pitch), cr = std::cos(roll),
               sr = std::sin(roll);
  const Vec3 forward = ecef(cy * cp, sy * cp, -sp),
             left = ecef(cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr),
             up = ecef(cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr);
  const Vec3 right = left * -1.0, down = up * -1.0;  // columns of the rotation; its quaternion by Shepperd's method
  const double m[3][3] = {{forward.x, right.x, down.x}, {forward.y, right.y, down.y}, {forward.z, right.z, down.z}};
  std::array<double, 4> q{};
  const double squares[4] = {1 + m[0][0] + m[1][1] + m[2][2], 1 + m[0][0] - m[1][1] - m[2][2],
                             1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2]};
  const int big = static_cast<int>(std::max_element(squares, squares + 4) - squares);
  const double products[4][4] = {{squares[0], m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]},
                                 {m[2][1] - m[1][2], squares[1], m[0][1] + m[1][0], m[0][2] + m[2][0]},
                                 {m[0][2] - m[2][0], m[0][1] + m[1][0], squares[2], m[1][2] + m[2][1]},
                                 {m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], squares[3]}};
  for (int i = 0; i < 4; ++i) q[i] = 0.5 * products[big][i] / std::sqrt(squares[big]);

  std::vector<double> times, places, speeds, attitudes;
  for (int i = 0; i < 3; ++i) {
    const Vec3 p = ecef_from_geographic(lonlat.x, lonlat.y, 240.0) + ecef(0.5 * i, 0.5 * i, 0.05 * i),
               v = ecef(10, 10, 1);
    times.push_back(5.0 + 0.05 * i);
    for (const double x : {p.x, p.y, p.z}) places.push_back(x);
    for (const double x : {v.x, v.y, v.z}) speeds.push_back(x);
    for (const double x : q) attitudes.push_back(x);
  }
  for (const char* folder : {"pose", "imu"}) std::filesystem::create_directories(scratch / folder);
  write_bytes(scratch / "pose/times.npy", npy("<f8", "(3,)", times));
  write_bytes(scratch / "pose/positions_ecef.npy", npy("<f8", "(3, 3)", places));
  write_bytes(scratch / "pose/velocities_ecef.npy", npy("<f8", "(3, 3)", speeds));
  write_bytes(scratch / "pose/orientations_ecef.npy", npy("<f8", "(3, 4)", attitudes));
  write_bytes(scratch / "imu/accelerometer_t.npy", npy<double>("<f8", "(2,)", {5.01, 5.02}));
  write_bytes(scratch / "imu/accelerometer_value.npy", npy<double>("<f8", "(2, 3)", {1, 2, -9.8, 1, 2, -9.8}));
  write_bytes(scratch / "imu/gyro_value.npy", npy<double>("<f8", "(2, 3)", {0, 0, 0.5, 0, 0, 0.5}));

  const auto read = read_drive_logs({scratch.folder()}, site_of(1000.0));
  EXPECT_THAT(read.findings, IsEmpty());
  ASSERT_EQ(read.log.recordings.size(), 1u);
  const DriveRecording& recording = read.log.recordings[0];
  const DrivePose& pose = recording.poses[0];
  EXPECT_LT(distance(pose.p, origin + Vec2{300, 300}), 1e-3);
  EXPECT_NEAR(pose.z_m, 240.0, 1e-3);
  EXPECT_NEAR(pose.pitch_rad, pitch, 1e-9);
  EXPECT_NEAR(pose.roll_rad, roll, 1e-9);
  EXPECT_NEAR(pose.heading_rad, yaw, 1e-4);
  EXPECT_NEAR(pose.speed_mps, std::sqrt(200.0), 1e-9);
  EXPECT_NEAR(pose.climb_mps, 1.0, 1e-9);
  ASSERT_EQ(recording.imu.size(), 2u);
  EXPECT_EQ(recording.imu[0].specific_force_mps2.x, 1.0);
  EXPECT_EQ(recording.imu[0].specific_force_mps2.y, -2.0);
  EXPECT_EQ(recording.imu[0].specific_force_mps2.z, 9.8);
  EXPECT_EQ(recording.imu[0].yaw_rate_radps, -0.5);

  // Without velocities the speed is that of the bus.
  std::filesystem::remove(scratch / "pose/velocities_ecef.npy");
  std::filesystem::create_directories(scratch / "can");
  write_bytes(scratch / "can/speed_t.npy", npy<double>("<f8", "(2,)", {5.0, 5.2}));
  write_bytes(scratch / "can/speed_value.npy", npy<double>("<f8", "(2, 1)", {10.0, 14.0}));
  const auto without = read_drive_logs({scratch.folder()}, site_of(1000.0));
  EXPECT_NEAR(without.log.recordings.at(0).poses.at(1).speed_mps, 11.0, 1e-9);

  write_bytes(scratch / "pose/velocities_ecef.npy", npy("<f8", "(2, 3)", std::vector<double>(6, 1.0)));
  EXPECT_THAT(message_of<InputError>([&] { (void)read_drive_logs({scratch.folder()}, site_of(1000.0)); }),
              HasSubstr("need 3 x 3"));
  std::filesystem::remove(scratch / "pose/times.npy");
  EXPECT_THAT(message_of<InputError>([&] { (void)read_drive_logs({scratch.folder()}, site_of(1000.0)); }),
              HasSubstr("no comma2k19 segment"));
}

TEST(DriveLogComma, the_real_minute_has_gravity_below_it) {
  const std::filesystem::path folder = paths::in_source("../shared/data/drives/comma2k19");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  const auto read =
      read_drive_logs({folder}, SiteFrame{Crs{"EPSG:32610"}, rectangle(545000, 4173000, 548000, 4178000)});
  EXPECT_THAT(read.findings, IsEmpty());
  ASSERT_EQ(read.log.recordings.size(), 1u);
  const DriveRecording& recording = read.log.recordings[0];
  EXPECT_EQ(recording.poses.size(), 1200u);
  EXPECT_GT(recording.imu.size(), 6200u);
  double up = 0.0, headings = 0.0;
  for (const DriveImu& imu : recording.imu) up += imu.specific_force_mps2.z / static_cast<double>(recording.imu.size());
  EXPECT_NEAR(up, 9.7, 0.2);
  for (std::size_t i = 20; i < recording.poses.size(); i += 20) {  // the car's nose points where it goes
    const Vec2 d = recording.poses[i].p - recording.poses[i - 20].p;
    headings +=
        std::abs(std::remainder(std::atan2(d.y, d.x) - recording.poses[i - 10].heading_rad, 2 * std::numbers::pi)) /
        59.0;
  }
  EXPECT_LT(headings, 0.04);
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// OpenCRG files under the wheels.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "drive/cars.hpp"
#include "drive/roads.hpp"
#include "orthodrive/drive/drive_route.hpp"
#include "roadquery/crg/road_crgs.hpp"

namespace orthodrive {
namespace {

using namespace test;

/// Waves of 4 m length and 20 mm height from row to row, 0.25 m apart, 6 m to either side.
void write_washboard(const std::filesystem::path& path, double length_m) {
  std::ofstream out(path);
  out << "$ROAD_CRG\nREFERENCE_LINE_INCREMENT = 0.25\nLONG_SECTION_V_INCREMENT = 6\n$KD_DEFINITION\n#:LRFI\n"
         "D:long section 1,m\nD:long section 2,m\nD:long section 3,m\n$$$$\n";
  out.setf(std::ios::fixed);
  out.precision(6);
  for (double u = 0.0; u <= length_m + 0.25; u += 0.25)
    for (int column = 0; column < 3; ++column) {
      out.width(10);
      out << 0.02 * std::sin(0.5 * std::numbers::pi * u) << (column == 2 ? "\n" : "");
    }
}

TEST(DriveRelief, wheels_stand_on_what_a_crg_file_lays_on_the_road) {
  Road road = make_road(1, {0.0, 0.0, 0.0, 0.0, 300.0, Line{}});
  road.surface = {{.file = "board.crg", .s_start = 0.0, .s_end = 300.0, .mode = "attached"}};
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "orthodrive_drive_relief";
  std::filesystem::create_directories(folder);
  write_washboard(folder / "board.crg", 300.0);
  RoadMap map = map_of({road});
  const DriveResult smooth = simulate_lap(map, test::family());
  roadquery::load_crgs(map, (folder / "roads.xodr").string());
  std::filesystem::remove_all(folder);
  const DriveResult rough = simulate_lap(map, test::family());

  ASSERT_TRUE(rough.finished);
  for (const DriveSample& s : smooth.samples)
    for (const double z : s.wheel_z_m) EXPECT_NEAR(z, 0.0, 1e-6);
  double square = 0.0, most = 0.0;
  for (const DriveSample& s : rough.samples)
    for (const double z : s.wheel_z_m) square += z * z, most = std::max(most, std::abs(z));
  // Linear between 16 rows a wave: 2 % less than the sine's 1 / sqrt(2).
  EXPECT_NEAR(std::sqrt(square / (4.0 * static_cast<double>(rough.samples.size()))), 0.02 / std::sqrt(2.0), 1e-3);
  EXPECT_NEAR(most, 0.02, 1e-3);
}

}  // namespace
}  // namespace orthodrive

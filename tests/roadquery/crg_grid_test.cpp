// SPDX-License-Identifier: Apache-2.0
// OpenCRG files made ready for the query: against a real peer, closed forms and the files' own numbers.

#include "roadquery/crg/crg_grid.hpp"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "paths.hpp"
#include "roadquery/crg/read_crg.hpp"

namespace roadquery {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
const fs::path asam = orthodrive::paths::in_source("..") / "shared" / "data" / "opencrg";

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class AsamGrid : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(asam)) GTEST_SKIP() << "NOT TESTED: no OpenCRG files at " << asam;
  }
  static CrgGrid grid(const std::string& name) { return CrgGrid(read_crg((asam / name).string())); }
};

void expect_near(double got, double want, double tolerance, const std::string& where) {
  ASSERT_EQ(std::isnan(got), std::isnan(want)) << where << ": " << got << ", want " << want;
  if (!std::isnan(want)) {
    EXPECT_NEAR(got, want, tolerance) << where;
  }
}

/// What PyOpenCRG makes of a file with some lines more: pyopencrg_values.txt.
struct PeerCase {
  std::string name, block;                          ///< block: to put before $KD_Definition
  std::vector<std::array<double, 5>> at_uv, at_xy;  ///< u, v, z, dz/du, dz/dv; and x, y, z, dz/dx, dz/dy
};

std::vector<PeerCase> peer_cases() {
  std::ifstream in(orthodrive::paths::in_source("tests/roadquery/pyopencrg_values.txt"));
  std::vector<PeerCase> cases;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "#") continue;
    if (word == "case") {
      words >> cases.emplace_back().name;
    } else if (word == "uv" || word == "xy") {
      auto& row = (word == "uv" ? cases.back().at_uv : cases.back().at_xy).emplace_back();
      for (double& value : row) words >> word, value = std::stod(word);  // stod knows nan
    } else {
      cases.back().block += line + "\n";
    }
  }
  return cases;
}

TEST_F(AsamGrid, agrees_with_pyopencrg_under_every_option_and_modifier) {
  const std::string original = bytes_of(asam / "handmade_curved_banked_sloped.crg");
  std::size_t compared = 0;
  for (const PeerCase& c : peer_cases()) {
    compared += c.at_uv.size() + c.at_xy.size();
    std::string bytes = original;
    bytes.insert(bytes.find("$KD_Definition"), c.block);
    const CrgGrid grid(parse_crg(bytes, c.name));
    for (const auto& want : c.at_uv) {
      const std::string where = c.name + " at u = " + std::to_string(want[0]) + ", v = " + std::to_string(want[1]);
      const CrgHeight got = grid.evaluate(want[0], want[1], CrgPart::whole);
      expect_near(got.z_m, want[2], 2e-8, where);
      expect_near(got.dz_du, want[3], 2e-8, where + ", dz/du");
      expect_near(got.dz_dv, want[4], 2e-7, where + ", dz/dv");
    }
    for (const auto& want : c.at_xy) {
      const std::string where = c.name + " at x = " + std::to_string(want[0]);
      const auto place = grid.place(want[0], want[1]);
      ASSERT_TRUE(place) << where;
      const CrgHeight got = grid.evaluate(place->u_m, place->v_m, CrgPart::whole);
      expect_near(got.z_m, want[2], 2e-8, where);
      expect_near(got.dz_du * place->du_dx + got.dz_dv * place->dv_dx, want[3], 2e-7, where + ", dz/dx");
      expect_near(got.dz_du * place->du_dy + got.dz_dv * place->dv_dy, want[4], 2e-7, where + ", dz/dy");
    }
  }
  EXPECT_EQ(compared, 204U);
}

TEST_F(AsamGrid, every_file_is_read_and_gives_its_own_values) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(asam)) {
    if (entry.path().extension() != ".crg") continue;
    const CrgFile file = read_crg(entry.path().string());
    const CrgGrid grid(file);
    const CrgSurface& s = file.surface;
    ++files;
    for (std::size_t i = 0; i < s.rows(); i += 1 + s.rows() / 40)
      for (std::size_t j = 0; j < s.columns(); j += 1 + s.columns() / 40) {
        const double u = s.u_start_m + s.u_increment_m * static_cast<double>(i);
        const double z = grid.evaluate(u, s.v_m[j], CrgPart::grid).z_m;
        ASSERT_FALSE(std::isnan(z)) << entry.path() << " row " << i << ", column " << j;
        if (!std::isnan(s.grid(i, j))) {
          ASSERT_NEAR(z, s.grid(i, j), 1e-7) << entry.path() << " row " << i << ", column " << j;
        }
      }
  }
  EXPECT_EQ(files, 14);
}

TEST_F(AsamGrid, banked_and_sloped_are_what_their_channels_say) {
  const CrgGrid banked = grid("handmade_banked.crg"), sloped = grid("handmade_sloped.crg");
  // Both files have the same grid; banking 0.011 per row up to row 11, the slope of a row that of the step to it.
  for (const double v : {-1.4, -0.3, 0.8}) {
    const double flat = banked.evaluate(4.0, v, CrgPart::grid).z_m;
    EXPECT_NEAR(banked.evaluate(4.0, v, CrgPart::whole).z_m, flat + 0.033 * v, 1e-12) << v;
    EXPECT_NEAR(sloped.evaluate(4.0, v, CrgPart::whole).z_m, flat + 0.011 + 0.022 + 0.033, 1e-12) << v;
  }
}

TEST_F(AsamGrid, circle_is_a_circle) {
  const CrgGrid circle = grid("handmade_circle.crg");  // chords of 10 m that turn by 0.25 rad
  const double radius = 5.0 / std::sin(0.125), to_center = circle.start_phi_rad() - 0.125 + 0.5 * M_PI;
  const double x = circle.start_x_m() + radius * std::cos(to_center);
  const double y = circle.start_y_m() + radius * std::sin(to_center);
  double u = 0.0;
  for (int k = 5; k < 45; ++k) {  // from the second strip on; 2.75 rad, just before the file's headings jump
    const double angle = to_center + M_PI + 0.06 * k;
    const auto place = circle.place(x + (radius - 1.2) * std::cos(angle), y + (radius - 1.2) * std::sin(angle), u);
    ASSERT_TRUE(place) << k;
    // Within the strip the place is on a chord: at most the sagitta off in v and, in u, the sine against the angle.
    EXPECT_NEAR(place->u_m, 10.0 * 0.06 * k / 0.25, 0.03) << k;
    EXPECT_NEAR(place->v_m, 1.2, radius * (1.0 - std::cos(0.125)) + 1e-9) << k;
    u = place->u_m;
  }
}

/// Straight along x from (10, 20), 100 rows of 0.5 m, uneven columns; a plane in u and v, so bilinear is exact.
CrgFile plane(bool even) {
  CrgFile file;
  CrgSurface& s = file.surface;
  s.u_start_m = 5.0, s.u_increment_m = 0.5;
  s.v_m = even ? std::vector<double>{-2.0, -1.0, 0.0, 1.0, 2.0}
               : std::vector<double>{-2.0, -1.999, -0.3, 0.25, 0.250001, 2.0};
  s.phi_rad.assign(100, 0.0), s.slope.assign(100, 0.0), s.banking.assign(100, 0.0);
  for (std::size_t i = 0; i < 100; ++i)
    for (const double v : s.v_m) s.grid_m.push_back(0.01 * (5.0 + 0.5 * static_cast<double>(i)) + 0.02 * v);
  integrate_reference_line(s, 10.0, 20.0, 0.0);
  return file;
}

TEST(CrgGrid, plane_is_a_plane_with_even_and_uneven_columns) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(5.0, 54.5), v(-2.0, 2.0);
  for (const bool even : {true, false}) {
    const CrgGrid grid(plane(even));
    for (int k = 0; k < 2000; ++k) {
      const double at_u = u(random), at_v = k % 10 == 0 ? 0.2500005 : v(random);
      const CrgHeight h = grid.evaluate(at_u, at_v, CrgPart::whole);
      ASSERT_NEAR(h.z_m, 0.01 * at_u + 0.02 * at_v, 1e-7);
      ASSERT_NEAR(h.dz_du, 0.01, 1e-6);
      if (even || (std::abs(at_v - 0.25) > 1e-5 && at_v > -1.99)) {
        ASSERT_NEAR(h.dz_dv, 0.02, 1e-6) << at_v;
      }
    }
    EXPECT_NEAR(grid.evaluate(54.5, 2.0, CrgPart::whole).z_m, 0.585, 1e-8) << "the last corner";
  }
}

TEST(CrgGrid, slope_is_the_derivative_of_height) {
  CrgFile file = plane(true);
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (double& z : file.surface.grid_m) z += noise(random);
  for (std::size_t i = 0; i < 100; ++i) {
    file.surface.phi_rad[i] = 0.01 * static_cast<double>(i > 0 ? i : 1);
    file.surface.slope[i] = 0.02, file.surface.banking[i] = 0.001 * static_cast<double>(i);
  }
  integrate_reference_line(file.surface, 1e6, 5e6, 300.0);
  const CrgGrid grid(file);
  const double h = 1e-4;
  for (int k = 0; k < 200; ++k) {
    const double x = 1e6 + 0.1 * k + 0.013, y = 5e6 + 0.5 + 0.0005 * k * k;
    const auto z_at = [&](double px, double py) {
      const auto place = grid.place(px, py, 5.0 + 0.1 * k);
      return place ? grid.evaluate(place->u_m, place->v_m, CrgPart::whole).z_m : missing;
    };
    const auto place = grid.place(x, y, 5.0 + 0.1 * k);
    ASSERT_TRUE(place);
    const CrgHeight at = grid.evaluate(place->u_m, place->v_m, CrgPart::whole);
    const double zx = (z_at(x + h, y) - z_at(x - h, y)) / (2.0 * h);
    const double zy = (z_at(x, y + h) - z_at(x, y - h)) / (2.0 * h);
    const double row = std::fmod(place->u_m * 2.0, 1.0), column = std::fmod(place->v_m + 10.0, 1.0);
    if (row < 1e-3 || row > 0.999 || column < 1e-3 || column > 0.999) continue;  // the slope jumps there
    ASSERT_NEAR(zx, at.dz_du * place->du_dx + at.dz_dv * place->dv_dx, 2e-5) << k;
    ASSERT_NEAR(zy, at.dz_du * place->du_dy + at.dz_dv * place->dv_dy, 2e-5) << k;
  }
}

TEST(CrgGrid, missing_values_stay_missing_where_the_file_asks_for_it) {
  CrgFile file = plane(true);
  file.modifiers["grid_nan_mode"] = 0.0;
  file.surface.grid_m[5 * 10 + 2] = missing;  // row 10 (u = 10), v = 0
  const CrgGrid grid(file);
  EXPECT_TRUE(std::isnan(grid.evaluate(10.2, 0.3, CrgPart::whole).z_m));
  EXPECT_TRUE(std::isnan(grid.evaluate(9.9, -0.3, CrgPart::whole).z_m));
  EXPECT_NEAR(grid.evaluate(10.5, 0.3, CrgPart::whole).z_m, 0.111, 1e-8) << "on the line of the next row";
  EXPECT_NEAR(grid.evaluate(10.2, 1.0, CrgPart::whole).z_m, 0.122, 1e-8) << "on the line of the next column";
  EXPECT_FALSE(std::isnan(grid.evaluate(10.2, 1.0, CrgPart::whole).dz_dv));
  file.modifiers.clear();
  EXPECT_NEAR(CrgGrid(file).evaluate(10.0, 0.0, CrgPart::whole).z_m, 0.1, 1e-8) << "filled from both sides";
}

TEST(CrgGrid, whole_rows_without_values_take_the_nearest_row) {
  CrgFile file = plane(true);
  for (std::size_t i = 10; i < 20; ++i)
    for (std::size_t j = 0; j < 5; ++j) file.surface.grid_m[i * 5 + j] = missing;
  const CrgGrid grid(file);
  EXPECT_NEAR(grid.evaluate(5.0 + 0.5 * 12, 1.0, CrgPart::grid).z_m, 0.01 * 9.5 + 0.02, 1e-8);
  EXPECT_NEAR(grid.evaluate(5.0 + 0.5 * 18, 1.0, CrgPart::grid).z_m, 0.01 * 15.0 + 0.02, 1e-8);
  for (double& z : file.surface.grid_m) z = missing;
  EXPECT_TRUE(std::isnan(CrgGrid(file).evaluate(20.0, 0.0, CrgPart::grid).z_m)) << "nothing to fill from";
}

TEST(CrgGrid, nonsense_places_have_no_height_and_no_end) {
  const CrgGrid grid(plane(true));
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double odd : {missing, infinite, -infinite, 1e300, -1e300, 1e17}) {
    const CrgHeight along = grid.evaluate(odd, 0.0, CrgPart::whole), across = grid.evaluate(10.0, odd, CrgPart::whole);
    EXPECT_EQ(std::isnan(along.z_m), !std::isfinite(odd)) << odd;
    EXPECT_EQ(std::isnan(across.z_m), !std::isfinite(odd)) << odd;
    (void)grid.place(odd, 20.0, 5.0), (void)grid.place(10.0, odd), (void)grid.place(12.0, 20.0, odd);
  }
}

/// Every place beside a spiral that is not folded is found from a bad hint, too.
TEST(CrgGrid, place_walks_from_any_hint) {
  CrgFile file = plane(true);
  for (std::size_t i = 1; i < 100; ++i) {
    const auto x = static_cast<double>(i);
    file.surface.phi_rad[i] = 0.0002 * x * x;
  }
  file.surface.phi_rad[0] = file.surface.phi_rad[1];
  integrate_reference_line(file.surface, 0.0, 0.0, 0.0);
  const CrgGrid grid(file);
  std::mt19937 random(9);
  std::uniform_int_distribution<std::size_t> row(0, 98);
  std::uniform_real_distribution<double> left(-2.0, 2.0), hint(5.0, 54.5);
  int found = 0;
  for (int k = 0; k < 3000; ++k) {
    const std::size_t i = row(random);
    const double v = left(random), c = std::cos(file.surface.phi_rad[i + 1]), n = std::sin(file.surface.phi_rad[i + 1]);
    const double x = 0.5 * (file.surface.x_m[i] + file.surface.x_m[i + 1]) - n * v;
    const double y = 0.5 * (file.surface.y_m[i] + file.surface.y_m[i + 1]) + c * v;
    const auto near = grid.place(x, y, 5.0 + 0.5 * static_cast<double>(i)), all = grid.place(x, y);
    ASSERT_TRUE(near && all);
    EXPECT_NEAR(near->v_m, v, 1e-9);
    EXPECT_NEAR(near->u_m, 5.0 + 0.5 * (static_cast<double>(i) + 0.5), 0.04) << "the last strip leans";
    EXPECT_NEAR(all->u_m, near->u_m, 1e-9);
    const auto far = grid.place(x, y, hint(random));
    if (!far) continue;  // the way there leads through folds
    ++found;
    EXPECT_NEAR(far->u_m, near->u_m, 1e-6) << "row " << i << ", v " << v;
  }
  EXPECT_GT(found, 2000);
}

TEST(CrgGrid, what_cannot_be_evaluated_is_refused) {
  const auto expect_refused = [](const char* name, double value, bool option, const char* what) {
    CrgFile file = plane(true);
    (option ? file.options : file.modifiers)[name] = value;
    try {
      const CrgGrid grid(file);
      ADD_FAILURE() << name << " = " << value << " is taken";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(what)) << name;
    }
  };
  expect_refused("border_mode_u", 5.0, true, "need 0, 1, 2, 3 or 4");
  expect_refused("border_mode_v", 1.5, true, "border_mode_v");
  expect_refused("scale_length", 0.0, false, "not positive");
  expect_refused("scale_width", -1.0, false, "not positive");
  expect_refused("grid_nan_mode", 3.0, false, "need 0, 1 or 2");
  expect_refused("scale_z_grid", 1e300, false, "beyond 1e8");
  expect_refused("refpoint_x", 1e200, false, "beyond 1e8");
  CrgFile infinite = plane(true);
  infinite.surface.grid_m[7] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(CrgGrid{infinite}, std::runtime_error);
}

}  // namespace
}  // namespace roadquery

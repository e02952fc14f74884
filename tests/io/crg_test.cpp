// SPDX-License-Identifier: Apache-2.0
// OpenCRG files: those of ASAM with known shapes, our own, and broken ones.

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "io/scratch.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/io/opendrive/opencrg_io.hpp"
#include "paths.hpp"
#include "roadquery/crg/crg_grid.hpp"

namespace orthodrive {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const fs::path asam = paths::in_source("..") / "shared" / "data" / "opencrg";

class AsamCrg : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(asam)) GTEST_SKIP() << "NOT TESTED: no OpenCRG files at " << asam;
  }
  static CrgSurface surface(const char* name) { return io::read_crg(asam / name).surface; }
};

/// Equal bit for bit; NaN equals NaN.
void expect_near(const std::vector<double>& a, const std::vector<double>& b, double tolerance = 0.0) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(std::isnan(a[i]), std::isnan(b[i])) << i;
    if (!std::isnan(a[i])) {
      ASSERT_NEAR(a[i], b[i], tolerance) << i;
    }
  }
}

TEST_F(AsamCrg, banked_one_has_its_banking) {
  const CrgSurface s = surface("handmade_banked.crg");
  ASSERT_EQ(s.rows(), 23u);
  EXPECT_EQ(s.v_m, (std::vector<double>{-1.5, -1.25, -1.0, 0.0, 1.0, 1.25, 1.5}));
  EXPECT_EQ(s.u_end_m(), 22.0);
  EXPECT_DOUBLE_EQ(s.banking[5], 0.044);
  EXPECT_DOUBLE_EQ(s.banking[11], 0.11);
  EXPECT_NEAR(crg_height(s, {11.0, 1.25}), 0.11 * 1.25 + 0.0111111, 1e-15);
  EXPECT_NEAR(crg_height(s, {10.5, -1.5}), -1.5 * 0.5 * (0.099 + 0.11), 1e-15);
  EXPECT_NEAR(crg_height(s, {7.0, 1.375}), 0.066 * 1.375 + 0.5 * (0.0222222 + 0.0333333), 1e-15) << "uneven columns";
}

TEST_F(AsamCrg, slope_of_a_row_is_that_of_the_step_to_it) {
  const CrgSurface s = surface("handmade_sloped.crg");
  EXPECT_NEAR(s.z_m[1], 0.0, 1e-15);
  EXPECT_NEAR(s.z_m[2], 0.011, 1e-15);
  EXPECT_NEAR(s.z_m[3], 0.033, 1e-15);
  EXPECT_NEAR(s.z_m[22], 0.011 * 2.0 * (1 + 2 + 3 + 4 + 5 + 6 + 7 + 8 + 9 + 10), 1e-14);
  EXPECT_NEAR(crg_height(s, {2.5, 0.0}), 0.022 + 0.0111111, 1e-15);
}

TEST_F(AsamCrg, circle_lies_on_a_circle) {
  const CrgSurface s = surface("handmade_circle.crg");
  ASSERT_EQ(s.rows(), 25u);
  const double radius = 5.0 / std::sin(0.125);  // steps of 10 m that turn by 0.25 rad
  const double to_center = s.phi_rad[1] - 0.125 + 0.5 * M_PI;
  const Vec2 center = Vec2{std::cos(to_center), std::sin(to_center)} * radius;
  for (std::size_t i = 0; i <= 12; ++i) EXPECT_NEAR(distance({s.x_m[i], s.y_m[i]}, center), radius, 1e-12) << i;
  EXPECT_EQ(s.u_increment_m, 10.0) << "not the 1.0 of the virtual channel";
  // A place 1 m inside and 1 m outside, between two rows: the strip there is a trapezium.
  for (const double v : {1.0, -1.0}) {
    const Vec2 p = crg_xy(s, {35.0, v});
    EXPECT_NEAR(distance(p, center), radius * std::cos(0.125) - v, 1e-12);
    const auto uv = roadquery::CrgGrid({.surface = s}).place(p.x, p.y);
    ASSERT_TRUE(uv);
    EXPECT_NEAR(uv->u_m, 35.0, 1e-12);
    EXPECT_NEAR(uv->v_m, v, 1e-12);
  }
}

TEST_F(AsamCrg, arc_turns_as_its_headings_say) {
  const CrgSurface s = surface("handmade_arc.crg");
  EXPECT_EQ(s.rows(), 23u);
  EXPECT_EQ(s.u_end_m(), 88.0);
  EXPECT_EQ(s.phi_rad[0], 0.0) << "the first row has no step";
  EXPECT_EQ(s.phi_rad[10], 2.125);
  double x = 0.0, y = 0.0;
  for (const double phi : {0.0, 0.125, 0.25, 0.375}) x += 4.0 * std::cos(phi), y += 4.0 * std::sin(phi);
  EXPECT_NEAR(s.x_m[4], x, 1e-12);
  EXPECT_NEAR(s.y_m[4], y, 1e-12);
}

TEST_F(AsamCrg, curved_banked_and_sloped_at_once_with_wrapped_records) {
  const CrgSurface s = surface("handmade_curved_banked_sloped.crg"), curved = surface("handmade_curved.crg"),
                   banked = surface("handmade_banked.crg"), sloped = surface("handmade_sloped.crg");
  expect_near(s.phi_rad, curved.phi_rad);
  expect_near(s.x_m, curved.x_m);
  expect_near(s.banking, banked.banking);
  expect_near(s.z_m, sloped.z_m);
  EXPECT_TRUE(std::isnan(s.grid(11, 0)));
  EXPECT_TRUE(std::isnan(s.grid(13, 6)));
  EXPECT_TRUE(std::isnan(crg_height(s, {11.5, -1.4})));
  EXPECT_FALSE(std::isnan(crg_height(s, {11.0, -1.25}))) << "on the line of the next column";
}

TEST_F(AsamCrg, short_files_say_the_same_as_those_with_comments) {
  for (const auto& [a, b] : {std::pair{"handmade_straight.crg", "handmade_straight_minimalist.crg"},
                             std::pair{"handmade_curved.crg", "handmade_curved_minimalist.crg"},
                             std::pair{"handmade_straight.crg", "handmade_straight_double.crg"},
                             std::pair{"handmade_sloped.crg", "handmade_sloped_opts.crg"}}) {
    const CrgSurface p = surface(a), q = surface(b);
    expect_near(p.grid_m, q.grid_m);
    expect_near(p.phi_rad, q.phi_rad);
    expect_near(p.x_m, q.x_m);
    expect_near(p.z_m, q.z_m);
    expect_near(p.v_m, q.v_m);
  }
  EXPECT_THAT(io::read_crg(asam / "handmade_sloped_opts.crg").notes, Contains(HasSubstr("border_mode_u")));
  EXPECT_THAT(io::read_crg(asam / "handmade_platform.crg").notes, Contains(HasSubstr("grid_nan_mode")));
  EXPECT_TRUE(io::read_crg(asam / "handmade_sloped.crg").notes.empty());
}

TEST_F(AsamCrg, sections_run_from_right_to_left) {
  const CrgSurface s = surface("handmade_vtest.crg");
  EXPECT_NEAR(crg_height(s, {3.0, -0.75}), 1.1111111, 1e-12);
  EXPECT_NEAR(crg_height(s, {3.0, 1.0}), 5.5555555, 1e-12);
  EXPECT_TRUE(std::isnan(crg_height(s, {3.0, 1.6})));
  EXPECT_TRUE(std::isnan(crg_height(s, {22.1, 0.0})));
  const CrgSurface platform = surface("handmade_platform.crg");
  EXPECT_NEAR(crg_height(platform, {0.5, 0.3}), 0.5 * (0.9999999 + 1.5), 1e-12);
}

TEST_F(AsamCrg, measured_belgian_block) {
  const io::CrgFile file = io::read_crg(asam / "belgian_block.crg");
  const CrgSurface& s = file.surface;
  EXPECT_EQ(file.format, CrgFormat::krbi);
  ASSERT_EQ(s.rows(), 1001u);
  ASSERT_EQ(s.columns(), 341u);
  EXPECT_NEAR(s.u_start_m, 730.0, 1e-12);
  EXPECT_NEAR(s.u_end_m(), 740.0, 1e-9);
  EXPECT_NEAR(s.v_m.front(), -1.7, 1e-12);
  EXPECT_NEAR(s.v_m.back(), 1.7, 1e-9);
  EXPECT_NEAR(s.phi_rad[1], 2.6527974605560303, 1e-15);
  EXPECT_NEAR(s.phi_rad.back(), 2.3053245544433594, 1e-15) << "the last row stands where it should";
  // The shipped copy went through a text transfer that took six CRs; a wrong place for one would garble all after it.
  EXPECT_THAT(file.notes, Contains(HasSubstr("6 bytes")));
  for (const std::string& note : file.notes) EXPECT_THAT(note, ::testing::Not(HasSubstr("missed the end")));
  CrgSurface again = s;
  integrate_reference_line(again, s.x_m.front(), s.y_m.front(), 0.0);
  EXPECT_NEAR(again.x_m.back(), 226.19866629319293, 1e-4) << "the header's end, by the headings of all rows";
  EXPECT_NEAR(again.y_m.back(), 83.897903016121077, 1e-4);
  double low = 1e9, high = -1e9, sum = 0.0, step = 0.0;
  std::size_t known = 0;
  for (std::size_t i = 0; i < s.rows(); ++i)
    for (std::size_t j = 0; j < s.columns(); ++j) {
      const double z = s.grid(i, j);
      if (std::isnan(z)) continue;
      low = std::min(low, z), high = std::max(high, z), sum += z, ++known;
      if (i > 0 && !std::isnan(s.grid(i - 1, j))) step = std::max(step, std::abs(z - s.grid(i - 1, j)));
    }
  EXPECT_EQ(s.grid_m.size() - known, 22228u);
  EXPECT_NEAR(low, 2.0355, 1e-4);
  EXPECT_NEAR(high, 2.1830, 1e-4);
  EXPECT_NEAR(sum / static_cast<double>(known), 2.113465, 1e-6);
  EXPECT_LT(step, 0.035) << "cobbles have no cliffs";
}

/// Curved, banked, sloped, with holes; UTM coordinates.
CrgSurface test_surface(bool regular, std::size_t rows = 40) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.01, 0.01);
  CrgSurface s;
  s.comment = "made for a test\nsecond line";
  s.u_start_m = 3.0, s.u_increment_m = 0.4999871;
  s.v_m = regular ? std::vector<double>{-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0}
                  : std::vector<double>{-2.125, -1.0, -0.1, 0.0, 0.7, 3.3};
  for (std::size_t i = 0; i < rows; ++i) {
    const auto x = static_cast<double>(i);
    s.phi_rad.push_back(2.9 + 0.02 * x - 0.0003 * x * x);
    s.slope.push_back(0.03 * std::sin(0.1 * x));
    s.banking.push_back(0.05 * std::cos(0.07 * x));
    for (std::size_t j = 0; j < s.v_m.size(); ++j)
      s.grid_m.push_back((i * 7 + j) % 23 == 5 ? std::numeric_limits<double>::quiet_NaN() : noise(random));
  }
  s.phi_rad[0] = s.phi_rad[1], s.slope[0] = s.slope[1];
  integrate_reference_line(s, 345678.12345678, 6391234.87654321, 41.625);
  return s;
}

TEST(Crg, double_binary_reads_back_exactly) {
  const Scratch scratch;
  for (const bool regular : {true, false}) {
    const CrgSurface s = test_surface(regular);
    io::write_crg(scratch / "a.crg", s, CrgFormat::kdbi);
    const io::CrgFile read = io::read_crg(scratch / "a.crg");
    EXPECT_EQ(read.format, CrgFormat::kdbi);
    EXPECT_EQ(read.surface.comment, s.comment);
    EXPECT_EQ(read.surface.u_start_m, s.u_start_m);
    EXPECT_EQ(read.surface.u_increment_m, s.u_increment_m);
    expect_near(read.surface.v_m, s.v_m);
    expect_near(read.surface.phi_rad, s.phi_rad);
    expect_near(read.surface.slope, s.slope);
    expect_near(read.surface.banking, s.banking);
    expect_near(read.surface.x_m, s.x_m);
    expect_near(read.surface.y_m, s.y_m);
    expect_near(read.surface.z_m, s.z_m);
    expect_near(read.surface.grid_m, s.grid_m);
    EXPECT_TRUE(read.notes.empty());
    io::write_crg(scratch / "b.crg", read.surface, CrgFormat::kdbi);
    EXPECT_EQ(bytes_of(scratch / "a.crg"), bytes_of(scratch / "b.crg"));
  }
}

TEST(Crg, other_formats_read_back_to_their_digits) {
  const Scratch scratch;
  for (const auto& [format, tolerance] :
       {std::pair{CrgFormat::lrfi, 0.5e-7}, std::pair{CrgFormat::ldfi, 1e-16}, std::pair{CrgFormat::krbi, 1.2e-7}}) {
    for (const bool regular : {true, false}) {
      const CrgSurface s = test_surface(regular);
      io::write_crg(scratch / "a.crg", s, format);
      const CrgSurface read = io::read_crg(scratch / "a.crg").surface;
      EXPECT_EQ(read.u_increment_m, s.u_increment_m);
      expect_near(read.v_m, s.v_m);
      expect_near(read.phi_rad, s.phi_rad, format == CrgFormat::ldfi ? 1e-15 : tolerance);
      expect_near(read.banking, s.banking, tolerance);
      expect_near(read.grid_m, s.grid_m, tolerance);
      expect_near(read.x_m, s.x_m, 1e-6);
      expect_near(read.z_m, s.z_m, 1e-6);
      EXPECT_EQ(read.x_m.back(), s.x_m.back()) << "the end is the header's";
    }
  }
}

TEST(Crg, files_keep_the_record_lengths_of_the_standard) {
  const Scratch scratch;
  for (const CrgFormat format : {CrgFormat::lrfi, CrgFormat::ldfi, CrgFormat::krbi, CrgFormat::kdbi}) {
    io::write_crg(scratch / "a.crg", test_surface(false), format);
    const std::string bytes = bytes_of(scratch / "a.crg");
    const std::size_t data = bytes.find('\n', bytes.find("\n$$$$") + 1) + 1;
    std::istringstream header(bytes.substr(0, data));
    for (std::string line; std::getline(header, line);) EXPECT_LE(line.size(), 72u) << line;
    if (format == CrgFormat::krbi || format == CrgFormat::kdbi) {
      EXPECT_EQ((bytes.size() - data) % 80, 0u);
      continue;
    }
    std::istringstream records(bytes.substr(data));
    for (std::string line; std::getline(records, line);)
      EXPECT_EQ(line.size() % (format == CrgFormat::lrfi ? 10 : 20), 0u);
  }
}

TEST(Crg, straight_flat_surface_needs_no_banking_and_no_slope) {
  const Scratch scratch;
  CrgSurface s = test_surface(true);
  s.phi_rad.assign(s.rows(), 0.5), s.slope.assign(s.rows(), 0.0), s.banking.assign(s.rows(), 0.0);
  integrate_reference_line(s, 1.0, 2.0, 3.0);
  io::write_crg(scratch / "a.crg", s, CrgFormat::kdbi);
  EXPECT_EQ(bytes_of(scratch / "a.crg").find("D:reference line slope"), std::string::npos);
  const CrgSurface read = io::read_crg(scratch / "a.crg").surface;
  expect_near(read.z_m, s.z_m);
  expect_near(read.grid_m, s.grid_m);
  EXPECT_EQ(crg_height(read, {3.0, 0.5}), crg_height(s, {3.0, 0.5}));
}

TEST(Crg, value_too_long_for_its_column_is_refused) {
  const Scratch scratch;
  CrgSurface s = test_surface(true);
  s.grid_m[3] = -1234567890.0;
  EXPECT_THROW(io::write_crg(scratch / "a.crg", s, CrgFormat::lrfi), Error);
  EXPECT_NO_THROW(io::write_crg(scratch / "a.crg", s, CrgFormat::ldfi));
}

TEST(Crg, place_and_grid_are_each_others_inverse) {
  const CrgSurface s = test_surface(false);
  const roadquery::CrgGrid grid({.surface = s});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(s.u_start_m, s.u_end_m()), v(-2.0, 3.3);
  for (int i = 0; i < 500; ++i) {
    const CrgUv want{u(random), v(random)};
    const Vec2 p = crg_xy(s, want);
    for (const auto& got : {grid.place(p.x, p.y), grid.place(p.x, p.y, want.u_m), grid.place(p.x, p.y, s.u_start_m),
                            grid.place(p.x, p.y, s.u_end_m())}) {
      ASSERT_TRUE(got);
      EXPECT_NEAR(got->u_m, want.u_m, 1e-7);
      EXPECT_NEAR(got->v_m, want.v_m, 1e-7);
    }
  }
  for (const double u_m : {s.u_start_m - 1.0, s.u_end_m() + 1.0}) {
    const Vec2 beyond = crg_xy(s, {u_m, 0.0});
    EXPECT_NEAR(grid.place(beyond.x, beyond.y).value().u_m, u_m, 1e-7) << "straight on";
  }
}

TEST(Crg, bytes_lost_as_newlines_are_put_back) {
  const Scratch scratch;
  CrgSurface s = test_surface(true, 900);
  // Heights about 2 m whose bytes are 40 0D 0A xx, 40 xx 0D 0A, and pairs over two values.
  const auto of_bits = [](std::uint32_t bits) { return static_cast<double>(std::bit_cast<float>(bits)); };
  for (double& z : s.grid_m) {
    const double micrometres = std::isnan(z) ? 0.0 : std::abs(z) * 1e6;
    z = of_bits(0x40010203u + (static_cast<std::uint32_t>(micrometres) % 7000u) * 17u);
  }
  s.grid_m[1000] = of_bits(0x400d0a55u), s.grid_m[3001] = of_bits(0x40030d0au), s.grid_m[5002] = of_bits(0x40020d0au);
  io::write_crg(scratch / "whole.crg", s, CrgFormat::krbi);
  std::string bytes = bytes_of(scratch / "whole.crg");
  const CrgSurface whole = io::read_crg(scratch / "whole.crg").surface;
  int lost = 0;
  for (std::size_t at = bytes.find("\r\n"); at != std::string::npos; at = bytes.find("\r\n", at))
    bytes.erase(at, 1), ++lost;
  ASSERT_GE(lost, 3);
  write_bytes(scratch / "lost.crg", bytes);
  const io::CrgFile mended = io::read_crg(scratch / "lost.crg");
  EXPECT_THAT(mended.notes, Contains(HasSubstr(std::to_string(lost) + " bytes")));
  // A pair may go to another newline of the same few values: what stands between is off by its last bits at most.
  std::size_t differ = 0;
  for (std::size_t i = 0; i < whole.grid_m.size(); ++i) {
    ASSERT_NEAR(mended.surface.grid_m[i], whole.grid_m[i], 0.02) << i;
    differ += mended.surface.grid_m[i] != whole.grid_m[i] ? 1u : 0u;
  }
  EXPECT_LE(differ, 6u);
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

TEST(Crg, broken_files_are_refused_with_the_place) {
  const Scratch scratch;
  io::write_crg(scratch / "a.crg", test_surface(true), CrgFormat::lrfi);
  const std::string good = bytes_of(scratch / "a.crg");
  const std::size_t data = good.find('\n', good.find("\n$$$$") + 1) + 1;
  std::string bad_number = good;
  bad_number.replace(data + 2 * 81 + 35, 3, "0x1");  // within the second row: two records of 8 and 4 values a row
  io::write_crg(scratch / "b.crg", test_surface(true), CrgFormat::kdbi);
  const std::string binary = bytes_of(scratch / "b.crg");
  const struct {
    const char* name;
    std::string bytes, what;
  } cases[] = {
      {"empty", "", "ends before its data"},
      {"no crg", "<xml>\n</xml>\n", "ends before its data"},
      {"no format", replaced(good, "#:LRFI", "*"), "no data format"},
      {"odd format", replaced(good, "#:LRFI", "#:LRFX"), "'LRFX' is not one of"},
      {"no increment", replaced(replaced(good, "REFERENCE_LINE_INCREMENT", "*"), "U:reference line u", "U:nothing"),
       "REFERENCE_LINE_INCREMENT"},
      {"no number", replaced(good, "REFERENCE_LINE_START_X   = 3", "REFERENCE_LINE_START_X   = a3"), "line 9: 'a3"},
      {"no value", replaced(good, "REFERENCE_LINE_START_X   =", "REFERENCE_LINE_START_X    "), "NAME = VALUE"},
      {"degrees", replaced(good, "phi,rad", "phi,deg"), "unit 'deg', need rad"},
      {"bad data", bad_number, "is not a number"},
      {"cut text", good.substr(0, good.size() - 100), ""},
      {"cut binary", binary.substr(0, binary.size() - 200), "record"},
      {"other file", replaced(good, "$KD_DEFINITION", "$ROAD_CRG_FILE\na.crg\n$KD_DEFINITION"), "$ROAD_CRG_FILE"},
      {"end between rows", replaced(good, "REFERENCE_LINE_END_U     = 22.4994969", "REFERENCE_LINE_END_U     = 22.2"),
       "increments after"},
      {"too few rows", good.substr(0, data) + good.substr(data, 5 * (81 + 41)), "asks for 40"},
  };
  for (const auto& c : cases) {
    write_bytes(scratch / "bad.crg", c.bytes);
    try {
      (void)io::read_crg(scratch / "bad.crg");
      ADD_FAILURE() << c.name << " is read";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("bad.crg: "), HasSubstr(c.what))) << c.name;
    }
  }
  EXPECT_THROW((void)io::read_crg(scratch / "none.crg"), InputError);
}

}  // namespace
}  // namespace orthodrive

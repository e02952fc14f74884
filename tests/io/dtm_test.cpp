// SPDX-License-Identifier: Apache-2.0
// Terrain models: own grid, warped, holes, cover.

#include <gdal_priv.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "orthodrive/core/error.hpp"
#include "orthodrive/geo/geoid.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "paths.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

HeightGrid tilted_plane(const GridFrame& frame) {
  HeightGrid grid{.crs = utm33, .frame = frame, .height_m = Raster<float>(frame.width, frame.height)};
  for (int row = 0; row < frame.height; ++row)
    for (int col = 0; col < frame.width; ++col) {
      const Vec2 p = frame.center_of(col, row);
      grid.height_m.at(col, row) = static_cast<float>(100.0 + 0.1 * (p.x - 500000.0) - 0.05 * (p.y - 5540000.0));
    }
  return grid;
}

TEST(Dtm, same_crs_is_cropped_but_not_resampled) {
  const Scratch scratch;
  // The origin is no multiple of the cell: resampling would show.
  const HeightGrid plane = tilted_plane({500003.7, 5540001.3, 10.0, 60, 60});
  io::write_dtm(scratch / "dtm.tif", plane);
  const HeightGrid back =
      io::read_dtm(scratch / "dtm.tif", {utm33, rectangle(500200.0, 5539600.0, 500300.0, 5539700.0)}, 20.0);
  EXPECT_DOUBLE_EQ(std::fmod(back.frame.west_m - plane.frame.west_m, 10.0), 0.0);
  EXPECT_LT(back.frame.width, 18);
  EXPECT_EQ(back.height_m.at(0, 0),
            plane.height_m.at(static_cast<int>((back.frame.west_m - plane.frame.west_m) / 10.0),
                              static_cast<int>((plane.frame.north_m - back.frame.north_m) / 10.0)));
}

TEST(Dtm, other_crs_is_warped_to_the_same_heights) {
  const Scratch scratch;
  io::write_dtm(scratch / "dtm.tif", tilted_plane({500000.0, 5540000.0, 10.0, 60, 60}));
  const Crs utm32{"EPSG:32632"};
  const CoordinateTransform utm32_from_utm33(utm33, utm32);
  Polygon area;
  for (const Vec2 p : {Vec2{500150, 5539550}, Vec2{500400, 5539550}, Vec2{500400, 5539800}, Vec2{500150, 5539800}})
    area.outer.push_back(utm32_from_utm33.target_from_source(p));
  const HeightGrid back = io::read_dtm(scratch / "dtm.tif", {utm32, area});
  for (int row = 8; row < back.frame.height - 8; ++row)
    for (int col = 8; col < back.frame.width - 8; ++col) {
      const Vec2 p = utm32_from_utm33.source_from_target(back.frame.center_of(col, row));
      EXPECT_NEAR(back.height_m.at(col, row), 100.0 + 0.1 * (p.x - 500000.0) - 0.05 * (p.y - 5540000.0), 0.001);
    }
}

TEST(Dtm, nodata_becomes_nan_and_lack_of_cover_is_refused_with_its_share) {
  const Scratch scratch;
  HeightGrid plane = tilted_plane({500000.0, 5540000.0, 5.0, 100, 100});
  for (int row = 0; row < 100; ++row)
    for (int col = 50; col < 100; ++col) plane.height_m.at(col, row) = std::numeric_limits<float>::quiet_NaN();
  io::write_dtm(scratch / "dtm.tif", plane);
  const SiteFrame west{utm33, rectangle(500010.0, 5539600.0, 500200.0, 5539900.0)},
      both{utm33, rectangle(500050.0, 5539600.0, 500450.0, 5539900.0)};
  EXPECT_DOUBLE_EQ(io::coverage(io::read_dtms({scratch / "dtm.tif"}, west), west), 1.0);
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_dtm(scratch / "dtm.tif", both); }),
              HasSubstr("heights for 50.0 %"));
}

/// Writes the plane again with numbers of another unit; `change` sees the file.
void write_in_unit(
    const fs::path& path, double numbers_per_metre,
    const std::function<void(GDALDataset&)>& change = [](GDALDataset&) {}) {
  HeightGrid plane = tilted_plane({500000.0, 5540000.0, 10.0, 60, 60});
  for (float& z : plane.height_m.data) z = static_cast<float>(numbers_per_metre * (static_cast<double>(z) + 300.0));
  io::write_dtm(path, plane);
  GDALDataset* file = GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE);
  ASSERT_NE(file, nullptr);
  change(*file);
  GDALClose(file);
}

// docs/notes/trackers.md has the reports.
TEST(Dtm, units_of_the_band_are_read) {
  const Scratch scratch;
  const SiteFrame site{utm33, rectangle(500200.0, 5539600.0, 500300.0, 5539700.0)};
  write_in_unit(scratch / "m.tif", 1.0);
  const HeightGrid metres = io::read_dtm(scratch / "m.tif", site);
  for (const auto& [name, per_metre] : {std::pair{"cm", 100.0},
                                        {"centimetre", 100.0},
                                        {"Centimeters", 100.0},
                                        {"dm", 10.0},
                                        {"mm", 1000.0},
                                        {"km", 0.001},
                                        {"metre", 1.0},
                                        {"ft", 1.0 / 0.3048}}) {
    write_in_unit(scratch / "u.tif", per_metre, [&](GDALDataset& file) { file.GetRasterBand(1)->SetUnitType(name); });
    const HeightGrid read = io::read_dtm(scratch / "u.tif", site);
    EXPECT_NEAR(read.height_m.at(10, 10), metres.height_m.at(10, 10), 1e-3) << name;
  }
}

TEST(Dtm, heights_in_a_unit_that_nobody_tells_are_refused_by_name) {
  const Scratch scratch;
  const SiteFrame site{utm33, rectangle(500200.0, 5539600.0, 500300.0, 5539700.0)};
  write_in_unit(scratch / "cm.tif", 100.0);
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_dtm(scratch / "cm.tif", site); }),
              testing::AllOf(HasSubstr("its heights go from 4"), HasSubstr("-a_scale 0.01")));
}

TEST(Dtm, pictures_are_no_terrain) {
  const Scratch scratch;
  const SiteFrame site{utm33, rectangle(500200.0, 5539600.0, 500300.0, 5539700.0)};
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  OGRSpatialReference reference;
  reference.importFromEPSG(32633);
  for (const int bands : {3, 4, 1}) {
    const fs::path path = scratch / "picture.tif";
    GDALDataset* file = driver->Create(path.c_str(), 60, 60, bands, GDT_Byte, nullptr);
    std::array<double, 6> transform{500000.0, 10.0, 0.0, 5540000.0, 0.0, -10.0};
    file->SetGeoTransform(transform.data());
    file->SetSpatialRef(&reference);
    if (bands == 1) file->GetRasterBand(1)->SetColorInterpretation(GCI_PaletteIndex);
    for (int b = 1; b <= bands; ++b) file->GetRasterBand(b)->Fill(120.0);
    GDALClose(file);
    EXPECT_THAT(message_of<InputError>([&] { (void)io::read_dtm(path, site); }), HasSubstr("is a picture")) << bands;
  }
}

TEST(Dtm, far_away_is_refused) {
  const Scratch scratch;
  io::write_dtm(scratch / "dtm.tif", tilted_plane({500000.0, 5540000.0, 5.0, 20, 20}));
  const SiteFrame site{utm33, rectangle(600000.0, 5539600.0, 600400.0, 5539900.0)};
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_dtm(scratch / "dtm.tif", site); }), HasSubstr("0.0 %"));
}

/// Hills of 40 m and a plain.
float hill(Vec2 p) {
  return static_cast<float>(250.0 + 20.0 * std::sin(0.01 * p.x) * std::cos(0.013 * p.y) + 0.02 * (p.x - 500000.0));
}

HeightGrid terrain_of(const GridFrame& frame, const std::function<float(Vec2)>& height) {
  HeightGrid grid{.crs = utm33, .frame = frame, .height_m = Raster<float>(frame.width, frame.height)};
  for (int row = 0; row < frame.height; ++row)
    for (int col = 0; col < frame.width; ++col) grid.height_m.at(col, row) = height(frame.center_of(col, row));
  return grid;
}

/// Two models of a site of 600 m: what they were read as, and what was found.
class TwoModels {
 public:
  TwoModels(const GridFrame& first, const std::function<float(Vec2)>& first_height, const GridFrame& second,
            const std::function<float(Vec2)>& second_height) {
    io::write_dtm(scratch_ / "first.tif", terrain_of(first, first_height));
    io::write_dtm(scratch_ / "second.tif", terrain_of(second, second_height));
    grids_ =
        io::read_dtms({scratch_ / "first.tif", scratch_ / "second.tif"}, site_, {.least_coverage = 0.5}, &findings_);
  }
  [[nodiscard]] std::string message(const std::string& code) const {
    for (const Finding& finding : findings_)
      if (finding.code == code) return finding.message;
    return {};
  }
  /// Largest difference of both from the truth.
  [[nodiscard]] double error_m(double above = 0.0) const {
    double worst = 0.0;
    for (const HeightGrid& grid : grids_)
      for (int row = 0; row < grid.frame.height; ++row)
        for (int col = 0; col < grid.frame.width; ++col) {
          const auto z = static_cast<double>(grid.height_m.at(col, row));
          if (std::isnan(z)) continue;
          worst = std::max(worst, std::abs(z - above - static_cast<double>(hill(grid.frame.center_of(col, row)))));
        }
    return worst;
  }

 private:
  Scratch scratch_;
  SiteFrame site_{utm33, rectangle(500000.0, 5539400.0, 500600.0, 5540000.0)};
  std::vector<HeightGrid> grids_;
  Findings findings_;
};

const GridFrame fine_west{499950.0, 5540050.0, 2.0, 175, 350}, coarse_all{499900.0, 5540100.0, 10.0, 80, 80},
    fine_east{500300.0, 5540050.0, 2.0, 175, 350};

TEST(TwoDtms, heights_over_the_ellipsoid_are_shifted_onto_those_over_the_sea) {
  const double sea_m = Geoid().height_m(15.0, 50.0);
  if (sea_m == 0.0) GTEST_SKIP() << "no grid of the geoid is installed";
  const auto ellipsoidal = [&](Vec2 p) { return hill(p) + static_cast<float>(sea_m); };
  for (const bool ellipsoidal_first : {true, false}) {
    const TwoModels both = ellipsoidal_first ? TwoModels(fine_west, ellipsoidal, coarse_all, hill)
                                             : TwoModels(fine_west, hill, coarse_all, ellipsoidal);
    EXPECT_LT(both.error_m(), 0.1);
    EXPECT_THAT(both.message("terrain.shifted"),
                testing::AllOf(HasSubstr(ellipsoidal_first ? "first.tif is 4" : "second.tif is 4"),
                               HasSubstr("m higher than"), HasSubstr("over the ellipsoid"), HasSubstr("lowered")));
  }
}

TEST(TwoDtms, a_constant_is_shifted_onto_the_better_model) {
  for (const float step_m : {2.3F, -1.0F, 12.0F}) {
    const TwoModels both(fine_west, hill, coarse_all, [&](Vec2 p) { return hill(p) + step_m; });
    EXPECT_LT(both.error_m(), 0.1);
    EXPECT_THAT(both.message("terrain.shifted"),
                HasSubstr(step_m > 0.0F ? "second.tif is lowered by that" : "second.tif is raised by that"));
  }
  const TwoModels same(fine_west, hill, coarse_all, [](Vec2 p) { return hill(p) + 0.2F; });
  EXPECT_EQ(same.message("terrain.shifted"), "");
  EXPECT_EQ(same.message("terrain.models_differ"), "");
}

TEST(TwoDtms, a_step_along_their_border_is_found_where_they_do_not_overlap) {
  const TwoModels stepped(fine_west, hill, fine_east, [](Vec2 p) { return hill(p) - 3.5F; });
  EXPECT_LT(stepped.error_m(), 0.1);
  EXPECT_THAT(stepped.message("terrain.shifted"),
              HasSubstr("first.tif is 3.50 m higher than second.tif where one ends and the other goes on"));
  const TwoModels smooth(fine_west, hill, fine_east, hill);
  EXPECT_EQ(smooth.message("terrain.shifted"), "");
  EXPECT_EQ(smooth.message("terrain.models_differ"), "");
  const TwoModels feet(fine_west, hill, fine_east, [](Vec2 p) { return hill(p) / 0.3048F; });
  EXPECT_LT(feet.error_m(), 0.1);
  EXPECT_THAT(feet.message("terrain.feet"), HasSubstr("second.tif is 3.28 times as high as first.tif"));
}

TEST(TwoDtms, feet_are_found_in_lowlands_by_their_relief) {
  const auto polder = [](Vec2 p) { return static_cast<float>(3.0 + 2.0 * std::sin(0.02 * p.x)); };
  const TwoModels feet(
      fine_west, [&](Vec2 p) { return polder(p) / 0.3048F; }, coarse_all, polder);
  EXPECT_THAT(feet.message("terrain.feet"), HasSubstr("first.tif is 3.28 times as high as second.tif"));
  // As far apart in the middle, but by a constant: no feet.
  const TwoModels datum(
      fine_west, [&](Vec2 p) { return polder(p) + 6.84F; }, coarse_all, polder);
  EXPECT_EQ(datum.message("terrain.feet"), "");
  EXPECT_THAT(datum.message("terrain.shifted"), HasSubstr("first.tif is 6.8"));
}

TEST(TwoDtms, what_is_no_constant_is_told_and_left) {
  // A surface model with woods of 10 to 30 m on two thirds of it.
  const auto surface = [](Vec2 p) {
    const double wood = std::sin(0.05 * p.x) + std::sin(0.04 * p.y);
    return hill(p) + static_cast<float>(wood > -0.5 ? 10.0 + 8.0 * (wood + 0.5) : 0.0);
  };
  const TwoModels both(fine_west, hill, coarse_all, surface);
  EXPECT_EQ(both.message("terrain.shifted"), "");
  EXPECT_THAT(both.message("terrain.models_differ"),
              testing::AllOf(HasSubstr("second.tif is 1"), HasSubstr("not by a constant")));
  // No datum lies a kilometre off.
  const TwoModels wrong(fine_west, hill, coarse_all, [](Vec2 p) { return hill(p) + 1000.0F; });
  EXPECT_EQ(wrong.message("terrain.shifted"), "");
  EXPECT_THAT(wrong.message("terrain.models_differ"), HasSubstr("1000.0"));
}

TEST(ThinArea, has_heights_where_no_pixel_has_its_middle_in_it) {
  const Scratch scratch;
  io::write_dtm(scratch / "dtm.tif", tilted_plane({500000.0, 5540000.0, 30.0, 40, 40}));
  for (const Polygon& thin :
       {rectangle(500100.0, 5539500.0, 500380.0, 5539508.0), rectangle(500100.0, 5539500.0, 500100.5, 5539800.0),
        Polygon{{{500100.0, 5539500.0}, {500400.0, 5539501.0}}, {}},
        rectangle(500107.0, 5539507.0, 500109.0, 5539509.0)}) {
    const SiteFrame site{utm33, thin};
    EXPECT_DOUBLE_EQ(io::coverage(io::read_dtms({scratch / "dtm.tif"}, site), site), 1.0);
    const SiteFrame half{utm33, moved(thin, {-100.0 - 0.5 * bounds_of(thin.outer).width(), 0.0})};
    if (bounds_of(thin.outer).width() < 100.0) continue;
    EXPECT_NEAR(io::coverage(io::read_dtms({scratch / "dtm.tif"}, half, {.least_coverage = 0.3}), half), 0.55, 0.06);
  }
}

TEST(RealDtm, kvarnbyn_is_covered_by_ten_metre_terrain_and_not_by_two_metre_terrain) {
  const fs::path folder = paths::in_source("../shared/data/kvarnbyn");
  if (!fs::exists(folder)) GTEST_SKIP() << "REAL DATA MISSING: " << folder;
  const SiteFrame site = lonlat_site(12.008, 57.6495, 12.044, 57.6625);
  const HeightGrid grid = io::read_dtm(folder / "dtm_10m_utm33.tif", site);
  EXPECT_DOUBLE_EQ(grid.frame.gsd_m, 10.0);
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_dtm(folder / "dtm_2m_west.tif", site); }),
              HasSubstr("% of the area only"));
  const std::vector<HeightGrid> both = io::read_dtms({folder / "dtm_2m_west.tif", folder / "dtm_10m_utm33.tif"}, site);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_NEAR(both[0].frame.gsd_m, 2.0, 0.01);
  EXPECT_GT(io::coverage(both, site), 0.99);
}

}  // namespace
}  // namespace orthodrive

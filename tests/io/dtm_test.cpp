// SPDX-License-Identifier: Apache-2.0
// Terrain models: own grid, warped, holes, cover.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "orthodrive/core/error.hpp"
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

TEST(Dtm, far_away_is_refused) {
  const Scratch scratch;
  io::write_dtm(scratch / "dtm.tif", tilted_plane({500000.0, 5540000.0, 5.0, 20, 20}));
  const SiteFrame site{utm33, rectangle(600000.0, 5539600.0, 600400.0, 5539900.0)};
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_dtm(scratch / "dtm.tif", site); }), HasSubstr("0.0 %"));
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

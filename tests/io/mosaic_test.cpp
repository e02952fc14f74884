// SPDX-License-Identifier: Apache-2.0
// Several photos as one: priority, hidden seams, and the same bytes in every window. Photos are painted from one scene,
// so that the truth of every pixel is known.

#include <gdal_priv.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/model/rasters/photo_mosaic.hpp"
#include "photo_window.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;
using Files = std::vector<fs::path>;

/// Fields of 24 m in 50..170 grey levels under waves of 11 m, each channel its own; metres from `origin`.
double scene_value(Vec2 p, int channel) {
  const auto field = static_cast<std::uint64_t>(std::floor(p.x / 24.0) + 1000.0) * 4096U +
                     static_cast<std::uint64_t>(std::floor(p.y / 24.0) + 1000.0);
  const double level = static_cast<double>(splitmix64(field * 3U + static_cast<std::uint64_t>(channel)) % 100U);
  return 60.0 + level + 10.0 * std::sin(p.x / 11.0 * 6.28) * std::cos(p.y / 11.0 * 6.28);
}

/// How a camera of another day sees the scene.
struct Look {
  double gain = 1.0;
  std::array<double, 3> cast{0.0, 0.0, 0.0};
};
double seen_value(Vec2 p, int channel, const Look& look) {
  return std::clamp(look.gain * scene_value(p, channel) + look.cast[static_cast<std::size_t>(channel)], 0.0, 255.0);
}

/// The scene between two corners, in metres from `origin`.
Photo paint(const Box2& box, double gsd_m, const Look& look = {}, const Crs& crs = utm33) {
  const CoordinateTransform crs_from_utm33(utm33, crs);
  std::vector<Vec2> corners;
  for (const Vec2 p :
       {Vec2{box.min_x, box.min_y}, Vec2{box.max_x, box.min_y}, Vec2{box.max_x, box.max_y}, Vec2{box.min_x, box.max_y}})
    corners.push_back(crs_from_utm33.target_from_source(origin + p));
  Photo photo{.crs = crs, .frame = covering_grid(bounds_of(corners), gsd_m)};
  photo.rgb = Raster<std::uint8_t>(photo.frame.width, photo.frame.height, 3);
  photo.valid = Raster<std::uint8_t>(photo.frame.width, photo.frame.height, 1, 1);
  for (int row = 0; row < photo.frame.height; ++row)
    for (int col = 0; col < photo.frame.width; ++col) {
      const Vec2 p = crs_from_utm33.source_from_target(photo.frame.center_of(col, row)) - origin;
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(col, row, c) = static_cast<std::uint8_t>(std::lround(seen_value(p, c, look)));
    }
  return photo;
}

SiteFrame site_of_box(double west, double south, double east, double north) {
  return {utm33, rectangle(origin.x + west, origin.y + south, origin.x + east, origin.y + north)};
}
const SiteFrame site = site_of_box(0.0, 0.0, 400.0, 300.0);
const Box2 west_part{-20.0, -20.0, 240.0, 320.0}, east_part{160.0, -20.0, 420.0, 320.0};
const Look other_day{.gain = 1.0 / 1.15, .cast = {12.0, 0.0, -9.0}};

Photo whole_of(const PhotoSource& source) {
  PhotoWindow all = source.read(pixels_of(source.frame));
  return {source.crs, source.frame, std::move(all.rgb), std::move(all.valid)};
}
Photo mosaic_of_files(const Files& files, Findings* findings = nullptr) {
  return whole_of(io::open_photo(files, site, {}, findings));
}

/// Photos one over the other without any blending.
Photo overlaid(const Files& files) {
  Photo top = io::read_photo(files.front(), site);
  for (std::size_t i = 1; i < files.size(); ++i) {
    const Photo below = io::read_photo(files[i], site, {.gsd_m = top.frame.gsd_m});
    for (std::size_t at = 0; at < top.valid.data.size(); ++at)
      if (!top.valid.data[at]) {
        top.valid.data[at] = below.valid.data[at];
        std::memcpy(&top.rgb.data[3 * at], &below.rgb.data[3 * at], 3);
      }
  }
  return top;
}

/// Mean of photo minus scene in a box, of the channel where it is largest.
double mean_error(const Photo& photo, const Box2& box, const Look& look = {}) {
  const Vec2 north_west = photo.frame.pixel_from_world(origin + Vec2{box.min_x, box.max_y}),
             south_east = photo.frame.pixel_from_world(origin + Vec2{box.max_x, box.min_y});
  std::array<double, 3> sums{};
  double pixels = 0.0;
  for (int row = std::max(0, static_cast<int>(north_west.y)); row < south_east.y && row < photo.frame.height; ++row)
    for (int col = std::max(0, static_cast<int>(north_west.x)); col < south_east.x && col < photo.frame.width; ++col) {
      if (!photo.valid.at(col, row)) continue;
      const Vec2 p = photo.frame.center_of(col, row) - origin;
      for (int c = 0; c < 3; ++c)
        sums[static_cast<std::size_t>(c)] += photo.rgb.at(col, row, c) - seen_value(p, c, look);
      pixels += 1.0;
    }
  return *std::ranges::max_element(sums, {}, [](double sum) { return std::abs(sum); }) / pixels;
}

/// Largest difference between neighbouring strips of `step_m` along x, with the scene taken out: what an eye sees as a
/// seam.
double largest_step(const Photo& photo, double step_m, double west, double east, const Look& look = {}) {
  double largest = 0.0, before = mean_error(photo, {west, 0.0, west + step_m, 300.0}, look);
  for (double x = west + step_m; x < east; x += step_m) {
    const double now = mean_error(photo, {x, 0.0, x + step_m, 300.0}, look);
    largest = std::max(largest, std::abs(now - before));
    before = now;
  }
  return largest;
}

void expect_same_photo(const Photo& photo, const Photo& wanted) {
  ASSERT_EQ(photo.frame, wanted.frame);
  EXPECT_EQ(photo.valid.data, wanted.valid.data);
  std::size_t different = 0;
  for (std::size_t at = 0; at < photo.valid.data.size(); ++at)
    different += photo.valid.data[at] && std::memcmp(&photo.rgb.data[3 * at], &wanted.rgb.data[3 * at], 3) != 0 ? 1 : 0;
  EXPECT_EQ(different, 0u);
}

TEST(PhotoMosaic, one_photo_and_two_equal_ones_give_the_bytes_of_one_alone) {
  const Scratch scratch;
  Photo photo = paint(west_part, 0.5);
  for (int row = 100; row < 140; ++row) std::fill_n(&photo.valid.at(80, row), 60, std::uint8_t{0});
  io::write_photo(scratch / "a.tif", photo);
  fs::copy(scratch / "a.tif", scratch / "b.tif");
  const Photo alone = io::read_photo(scratch / "a.tif", site);
  EXPECT_GT(std::ranges::count(alone.valid.data, 0), 1000);
  expect_same_photo(mosaic_of_files({scratch / "a.tif"}), alone);
  expect_same_photo(mosaic_of_files({scratch / "a.tif", scratch / "b.tif"}), alone);
  expect_same_photo(io::read_photo(Files{scratch / "a.tif", scratch / "b.tif"}, site), alone);
}

TEST(PhotoMosaic, seam_between_photos_of_other_exposure_and_colour_is_hidden) {
  const Scratch scratch;
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  io::write_photo(scratch / "east.tif", paint(east_part, 0.5, other_day));
  const Files files{scratch / "west.tif", scratch / "east.tif"};
  const Photo before = overlaid(files), after = mosaic_of_files(files);
  EXPECT_EQ(std::ranges::count(after.valid.data, 0), 0);
  const double step_before = largest_step(before, 4.0, 100.0, 400.0),
               step_after = largest_step(after, 4.0, 100.0, 400.0);
  EXPECT_GT(step_before, 20.0);
  EXPECT_LT(step_after, 1.0);
  EXPECT_GT(std::abs(mean_error(before, {240.0, 0.0, 300.0, 300.0})), 20.0);
  EXPECT_LT(std::abs(mean_error(after, {240.0, 0.0, 300.0, 300.0})), 1.0) << "beside the seam";
  EXPECT_LT(std::abs(mean_error(after, {340.0, 0.0, 400.0, 300.0})), 1.0) << "far from it";
  // The other way round the east keeps its colours and the west takes them.
  const Photo reversed = mosaic_of_files({files[1], files[0]});
  EXPECT_LT(largest_step(reversed, 4.0, 0.0, 300.0, other_day), 1.0);
}

TEST(PhotoMosaic, pure_gain_is_undone_everywhere) {
  const Scratch scratch;
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  io::write_photo(scratch / "east.tif", paint(east_part, 0.5, {.gain = 1.0 / 1.15}));
  const Photo mosaic = mosaic_of_files({scratch / "west.tif", scratch / "east.tif"});
  for (double x = 0.0; x < 400.0; x += 20.0)
    EXPECT_LT(std::abs(mean_error(mosaic, {x, 0.0, x + 20.0, 300.0})), 0.6) << x;
}

/// Adds what is given for a place in metres from `origin`, to all channels.
template <typename Value>
void add(Photo& photo, const Value& value) {
  for (int row = 0; row < photo.frame.height; ++row)
    for (int col = 0; col < photo.frame.width; ++col) {
      const double more = value(photo.frame.center_of(col, row) - origin);
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(col, row, c) = static_cast<std::uint8_t>(std::lround(photo.rgb.at(col, row, c) + more));
    }
}

TEST(PhotoMosaic, difference_that_changes_along_the_seam_is_hidden_near_it_and_left_far_from_it) {
  const Scratch scratch;
  Photo east = paint(east_part, 0.5);
  add(east, [](Vec2 p) { return p.y / 10.0 - 15.0; });  // as vignetting: -15 in the south, +15 in the north
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  io::write_photo(scratch / "east.tif", east);
  const Photo mosaic = mosaic_of_files({scratch / "west.tif", scratch / "east.tif"});
  for (const double south : {0.0, 75.0, 150.0, 225.0}) {
    const double before = mean_error(east, {240.0, south, 260.0, south + 75.0}),
                 after = mean_error(mosaic, {240.0, south, 260.0, south + 75.0}),
                 far = mean_error(mosaic, {395.0, south, 400.0, south + 75.0});
    EXPECT_LT(std::abs(after), 3.0) << south << "; without the local match it is up to 11";
    EXPECT_NEAR(far, before, 2.0) << south;
  }
}

TEST(PhotoMosaic, photo_fades_within_15_m_of_its_rim) {
  const Scratch scratch;
  // A chequerboard of 1 m: in the mean it is nothing, and tells how much of the second photo is seen.
  const auto chequer = [](Vec2 p) {
    return (static_cast<int>(std::floor(p.x)) + static_cast<int>(std::floor(p.y))) % 2 == 0 ? 20.0 : -20.0;
  };
  Photo east = paint(east_part, 0.5);
  add(east, chequer);
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  io::write_photo(scratch / "east.tif", east);
  const Photo mosaic = mosaic_of_files({scratch / "west.tif", scratch / "east.tif"});
  const auto share_of_east = [&](double from_rim_m) {
    double sum = 0.0, pixels = 0.0;
    for (double y = 0.25; y < 300.0; y += 0.5) {
      const Vec2 p{240.0 - from_rim_m - 0.25, y};
      const Vec2 at = mosaic.frame.pixel_from_world(origin + p);
      const double value = mosaic.rgb.at(static_cast<int>(at.x), static_cast<int>(at.y), 1);
      sum += (value - scene_value(p, 1)) / chequer(p), pixels += 1.0;
    }
    return sum / pixels;
  };
  EXPECT_GT(share_of_east(0.0), 0.95) << "at the rim nothing of the west is left";
  double last = 1.0;
  for (double from_rim_m = 0.0; from_rim_m < 40.0; from_rim_m += 1.0) {
    const double share = share_of_east(from_rim_m);
    EXPECT_LT(share, last + 0.02) << from_rim_m;
    EXPECT_GT(share, last - 0.15) << from_rim_m;
    last = share;
  }
  EXPECT_NEAR(share_of_east(12.0), 0.5, 0.3);
  EXPECT_NEAR(share_of_east(25.0), 0.0, 0.02) << "15 m and the cells in which a rim is known";
}

/// White squares tell photos of one look apart.
void mark(Photo& photo, const Box2& box, std::uint8_t value) {
  for (int row = 0; row < photo.frame.height; ++row)
    for (int col = 0; col < photo.frame.width; ++col) {
      const Vec2 p = photo.frame.center_of(col, row) - origin;
      if (p.x >= box.min_x && p.x < box.max_x && p.y >= box.min_y && p.y < box.max_y)
        for (int c = 0; c < 3; ++c) photo.rgb.at(col, row, c) = value;
    }
}
void cut_hole(Photo& photo, const Box2& box) {
  for (int row = 0; row < photo.frame.height; ++row)
    for (int col = 0; col < photo.frame.width; ++col) {
      const Vec2 p = photo.frame.center_of(col, row) - origin;
      if (p.x >= box.min_x && p.x < box.max_x && p.y >= box.min_y && p.y < box.max_y) photo.valid.at(col, row) = 0;
    }
}

TEST(PhotoMosaic, first_photo_is_seen_where_it_has_data_and_the_next_where_it_has_none) {
  const Scratch scratch;
  const Box2 marked{180.0, 100.0, 190.0, 110.0}, hole{60.0, 60.0, 120.0, 140.0}, pixel{100.0, 200.0, 100.5, 200.5};
  Photo west = paint(west_part, 0.5), all = paint({-20.0, -20.0, 420.0, 320.0}, 0.5, other_day),
        last = paint({-20.0, -20.0, 420.0, 320.0}, 0.5, {.gain = 0.8});
  cut_hole(west, hole), cut_hole(west, pixel);
  mark(all, marked, 250);
  cut_hole(all, {70.0, 70.0, 100.0, 130.0});
  io::write_photo(scratch / "west.tif", west);
  io::write_photo(scratch / "all.tif", all);
  io::write_photo(scratch / "last.tif", last);
  const Photo alone = io::read_photo(scratch / "west.tif", site);
  const Photo two = mosaic_of_files({scratch / "west.tif", scratch / "all.tif"}),
              three = mosaic_of_files({scratch / "west.tif", scratch / "all.tif", scratch / "last.tif"});
  const auto pixel_at = [&](const Photo& photo, double x, double y) {
    const Vec2 at = photo.frame.pixel_from_world(origin + Vec2{x, y});
    const int col = static_cast<int>(at.x), row = static_cast<int>(at.y);
    return photo.valid.at(col, row) ? static_cast<int>(photo.rgb.at(col, row, 1)) : -1;
  };
  std::size_t different = 0;  // the west's own ground, far from its rims
  for (double x = 150.25; x < 210.0; x += 0.5)
    for (double y = 30.25; y < 270.0; y += 0.5) different += pixel_at(two, x, y) != pixel_at(alone, x, y) ? 1 : 0;
  EXPECT_EQ(different, 0u) << "what the first photo shows stays as it is, also where the second has something else";
  EXPECT_EQ(pixel_at(alone, 100.25, 200.25), -1);
  EXPECT_NEAR(pixel_at(two, 100.25, 200.25), scene_value({100.25, 200.25}, 1), 12.0) << "a hole of one pixel";
  EXPECT_EQ(pixel_at(two, 100.75, 201.25), pixel_at(alone, 100.75, 201.25)) << "does not fade its surroundings";
  EXPECT_EQ(pixel_at(two, 85.25, 100.25), -1) << "neither of both";
  EXPECT_EQ(std::ranges::count(three.valid.data, 0), 0);
  EXPECT_LT(std::abs(mean_error(three, {70.0, 70.0, 100.0, 130.0})), 3.0);
  EXPECT_LT(std::abs(mean_error(two, {102.0, 60.0, 120.0, 140.0})), 3.0);
  EXPECT_LT(largest_step(three, 4.0, 0.0, 400.0), 2.0);
}

TEST(PhotoMosaic, any_window_has_the_bytes_of_the_whole_whoever_reads_it) {
  const Scratch scratch;
  Photo west = paint({-20.0, 20.0, 240.0, 320.0}, 0.5);
  cut_hole(west, {60.0, 60.0, 120.0, 140.0});
  io::write_photo(scratch / "west.tif", west);
  io::write_photo(scratch / "east.tif", paint(east_part, 0.7, other_day, Crs{"EPSG:32632"}));
  io::write_photo(scratch / "all.tif", paint({-20.0, -20.0, 420.0, 280.0}, 1.3, {.gain = 0.8}));
  const Files files{scratch / "west.tif", scratch / "east.tif", scratch / "all.tif"};
  SiteFrame skew = site;
  skew.area.outer[2].x -= 37.3;
  const Photo whole = whole_of(io::open_photo(files, skew, {.threads = 1}));
  EXPECT_GT(std::ranges::count(whole.valid.data, 0), 1000) << "outside the area";
  const PhotoSource source = io::open_photo(files, skew, {.threads = 3});
  std::vector<PixelBox> boxes{{-100, -50, 300, 200}, {479, 126, 5, 4}, {470, 0, 1, 600}, {5000, 5000, 9, 9}};
  for (int row = -37; row < whole.frame.height; row += 97)
    for (int col = -11; col < whole.frame.width; col += 133) boxes.push_back({col, row, 133, 97});
  parallel_for(boxes.size(), 4, [&](std::size_t i) { expect_window_of(whole, boxes[i], source.read(boxes[i])); });
}

TEST(PhotoMosaic, takes_the_gsd_of_the_first_and_photos_in_any_crs) {
  const Scratch scratch;
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  const Crs utm32{"EPSG:32632"};
  for (const double gsd_m : {0.2, 2.0}) {
    io::write_photo(scratch / "east.tif", paint(east_part, gsd_m, other_day, utm32));
    const Photo mosaic = mosaic_of_files({scratch / "west.tif", scratch / "east.tif"});
    EXPECT_EQ(mosaic.frame.gsd_m, 0.5);
    EXPECT_EQ(std::ranges::count(mosaic.valid.data, 0), 0);
    EXPECT_LT(largest_step(mosaic, 12.0, 100.0, 400.0), 2.0) << gsd_m;
    EXPECT_EQ(mosaic_of_files({scratch / "east.tif", scratch / "west.tif"}).frame.gsd_m, gsd_m);
  }
}

/// One band, or a palette of grey levels.
void write_grey(const fs::path& path, const Photo& photo, bool palette) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const std::unique_ptr<GDALDataset> file(
      driver->Create(path.c_str(), photo.frame.width, photo.frame.height, 1, GDT_Byte, nullptr));
  double place[6] = {photo.frame.west_m, photo.frame.gsd_m, 0.0, photo.frame.north_m, 0.0, -photo.frame.gsd_m};
  file->SetGeoTransform(place);
  OGRSpatialReference reference;
  reference.importFromEPSG(32633);
  file->SetSpatialRef(&reference);
  if (palette) {
    GDALColorTable colors;
    for (short i = 0; i < 256; ++i) {
      const GDALColorEntry entry{i, i, i, 255};
      colors.SetColorEntry(i, &entry);
    }
    file->GetRasterBand(1)->SetColorTable(&colors);
  }
  std::vector<std::uint8_t> row_of_green(static_cast<std::size_t>(photo.frame.width));
  for (int row = 0; row < photo.frame.height; ++row) {
    for (int col = 0; col < photo.frame.width; ++col)
      row_of_green[static_cast<std::size_t>(col)] = photo.rgb.at(col, row, 1);
    ASSERT_EQ(file->GetRasterBand(1)->RasterIO(GF_Write, 0, row, photo.frame.width, 1, row_of_green.data(),
                                               photo.frame.width, 1, GDT_Byte, 0, 0, nullptr),
              CE_None);
  }
}

TEST(PhotoMosaic, grey_and_palette_photos_are_taken_as_one_alone_is) {
  const Scratch scratch;
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  for (const bool palette : {false, true}) {
    write_grey(scratch / "east.tif", paint(east_part, 0.5), palette);
    const Photo mosaic = mosaic_of_files({scratch / "west.tif", scratch / "east.tif"});
    EXPECT_EQ(std::ranges::count(mosaic.valid.data, 0), 0);
    const std::uint8_t* corner = &mosaic.rgb.at(mosaic.frame.width - 10, 10);
    const double truth = scene_value(mosaic.frame.center_of(mosaic.frame.width - 10, 10) - origin, 1);
    EXPECT_NEAR(corner[1], truth, 6.0) << palette;
  }
}

TEST(PhotoMosaic, photo_of_somewhere_else_is_a_finding_unless_all_are) {
  const Scratch scratch;
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  io::write_photo(scratch / "far.tif", paint({9000.0, 0.0, 9100.0, 100.0}, 0.1));
  Photo blank = paint(east_part, 0.5);
  std::ranges::fill(blank.valid.data, std::uint8_t{0});
  io::write_photo(scratch / "blank.tif", blank);
  Findings findings;
  const Photo mosaic = mosaic_of_files({scratch / "far.tif", scratch / "west.tif", scratch / "blank.tif"}, &findings);
  expect_same_photo(mosaic, io::read_photo(scratch / "west.tif", site));
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].code, "photo.elsewhere");
  EXPECT_EQ(findings[0].message, "far.tif shows nothing of the area and is left out");
  EXPECT_EQ(findings[1].message, "blank.tif shows nothing of the area and is left out");
  fs::copy(scratch / "far.tif", scratch / "farther.tif");
  EXPECT_THAT(message_of<InputError>([&] {
                (void)mosaic_of_files({scratch / "far.tif", scratch / "farther.tif"});
              }),
              HasSubstr("far.tif: shows nothing of the area, and neither do the 1 photos after it"));
  EXPECT_THAT(message_of<InputError>([&] {
                (void)mosaic_of_files({scratch / "west.tif", scratch / "none.tif"});
              }),
              HasSubstr("none.tif"));
  EXPECT_THROW((void)mosaic_of_files({}), OptionError);
}

TEST(PhotoMosaic, damage_in_a_lower_photo_is_told_by_its_name) {
  const Scratch scratch;
  io::write_photo(scratch / "west.tif", paint(west_part, 0.5));
  io::write_photo(scratch / "east.tif", paint(east_part, 0.5));
  truncate_to(scratch / "east.tif", 0.5);
  EXPECT_THAT(message_of<InputError>([&] {
                (void)mosaic_of_files({scratch / "west.tif", scratch / "east.tif"});
              }),
              HasSubstr("east.tif: is truncated"));
}

TEST(PhotoMosaic, overviews_have_few_cells_whatever_the_site) {
  for (const std::size_t photos : {1u, 2u, 50u})
    for (const double side_m : {300.0, 5000.0, 50000.0}) {
      const GridFrame cells =
          mosaic_overview_frame(covering_grid({0.0, 0.0, side_m, side_m}, 0.2), std::vector(photos, 0.2));
      EXPECT_GE(cells.gsd_m, 4.0);
      EXPECT_LT(static_cast<double>(photos) * cells.width * cells.height, 2.6e6) << side_m;
    }
  EXPECT_EQ(mosaic_overview_frame(covering_grid({0.0, 0.0, 3000.0, 3000.0}, 0.2), std::vector{0.2, 10.0}).gsd_m, 10.0);
}

}  // namespace
}  // namespace orthodrive

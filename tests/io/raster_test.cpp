// SPDX-License-Identifier: Apache-2.0
// Rasters: what is written comes back; what is broken is refused with a remedy.

#include <fmt/format.h>
#include <gdal_priv.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/hash.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "orthodrive/model/rasters/class_table_json.hpp"
#include "paths.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;
namespace fs = std::filesystem;

/// Smooth in space, so that resampling has a right answer: r grows eastwards, g northwards.
Photo painted_photo(int width, int height, double gsd_m) {
  Photo photo{.crs = utm33, .frame = {500000.0, 5540000.0, gsd_m, width, height}};
  photo.rgb = Raster<std::uint8_t>(width, height, 3);
  photo.valid = Raster<std::uint8_t>(width, height, 1, 1);
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col) {
      photo.rgb.at(col, row, 0) = static_cast<std::uint8_t>(20 + 200 * col / width);
      photo.rgb.at(col, row, 1) = static_cast<std::uint8_t>(220 - 200 * row / height);
      photo.rgb.at(col, row, 2) = 77;
    }
  return photo;
}

/// Compresses badly, so that a file has a size worth truncating.
Photo noisy_photo(int size) {
  Photo photo = painted_photo(size, size, 0.5);
  Random random(7);
  for (std::uint8_t& value : photo.rgb.data) value = static_cast<std::uint8_t>(random.below(256));
  return photo;
}

LabelMap small_labels() {
  LabelMap map{.crs = utm33,
               .frame = {500000.0, 5540000.0, 0.5, 40, 30},
               .labels = Raster<std::uint8_t>(40, 30),
               .classes = default_class_table()};
  for (int i = 0; i < 40 * 30; ++i) map.labels.data[i] = static_cast<std::uint8_t>(i % 8);
  map.labels.at(3, 4) = label_nodata;
  return map;
}

TEST(Labels, come_back_as_written_with_their_class_table) {
  const Scratch scratch;
  const LabelMap map = small_labels();
  io::write_labels(scratch / "labels.tif", map);
  const LabelMap back = io::read_labels(scratch / "labels.tif");
  EXPECT_EQ(back.crs, map.crs);
  EXPECT_EQ(back.frame, map.frame);
  EXPECT_EQ(back.labels.data, map.labels.data);
  ASSERT_EQ(back.classes.classes.size(), 8u);
  EXPECT_EQ(back.classes.name, map.classes.name);
  EXPECT_EQ(back.classes.classes[1].role, Role::road);
  EXPECT_EQ(back.classes.classes[3].color, map.classes.classes[3].color);
  EXPECT_DOUBLE_EQ(back.classes.classes[4].cost_false_negative, map.classes.classes[4].cost_false_negative);
  EXPECT_EQ(scratch.file_count(), 1) << "no side-car files";
  const LabelSource source = io::open_labels(scratch / "labels.tif");
  EXPECT_EQ(source.frame, back.frame);
  const PixelBox box{1, 1, back.frame.width - 2, back.frame.height - 1};
  const Raster<std::uint8_t> part = source.read(box);
  for (int row = 0; row < box.height; ++row)
    for (int col = 0; col < box.width; ++col) EXPECT_EQ(part.at(col, row), back.labels.at(col + 1, row + 1));
}

TEST(Labels, file_is_a_palette_geotiff_that_others_can_open) {
  const Scratch scratch;
  io::write_labels(scratch / "labels.tif", small_labels());
  const auto dataset = GDALDataset::FromHandle(GDALOpen((scratch / "labels.tif").c_str(), GA_ReadOnly));
  ASSERT_NE(dataset, nullptr);
  EXPECT_EQ(dataset->GetRasterBand(1)->GetNoDataValue(), 255.0);
  const GDALColorTable* colors = dataset->GetRasterBand(1)->GetColorTable();
  ASSERT_NE(colors, nullptr);
  EXPECT_EQ(colors->GetColorEntry(1)->c1, default_class_table().classes[1].color[0]);
  EXPECT_STREQ(dataset->GetMetadataItem("LAYOUT", "IMAGE_STRUCTURE"), "COG");
  GDALClose(dataset);
}

TEST(Labels, class_table_that_is_too_short_is_refused) {
  const Scratch scratch;
  const LabelMap map = small_labels();
  io::write_confidence(scratch / "labels.tif", {map.crs, map.frame, map.labels});  // labels as another tool writes them
  ClassTable two{"two", {{"other"}, {"road"}}};
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_labels(scratch / "labels.tif", two); }),
              HasSubstr("'two' has only 2 classes"));
}

TEST(Labels, raster_without_class_table_is_refused) {
  const Scratch scratch;
  const LabelMap map = small_labels();
  io::write_confidence(scratch / "grey.tif", {map.crs, map.frame, map.labels});
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_labels(scratch / "grey.tif"); }),
              HasSubstr("ORTHODRIVE_CLASSES"));
  EXPECT_EQ(io::read_labels(scratch / "grey.tif", default_class_table()).labels.data, map.labels.data);
}

TEST(ClassTable, json_round_trip_and_rubbish) {
  const ClassTable back = class_table_from_json(class_table_to_json(default_class_table()));
  EXPECT_EQ(class_table_to_json(back), class_table_to_json(default_class_table()));
  for (
      const char* rubbish :
      {"", "[]", R"({"name":"x"})", R"({"name":"x","classes":[]})",
       R"({"name":"x","classes":[{"name":"a","color":[1,2,5e126],"role":"road","cost_false_positive":0,"cost_false_negative":0}]})",
       R"({"name":"x","classes":[{"name":"a","color":[1,2,256],"role":"road","cost_false_positive":0,"cost_false_negative":0}]})",
       R"({"name":"x","classes":[{"name":"a","color":[1,2,3],"role":"rod","cost_false_positive":0,"cost_false_negative":0}]})"})
    EXPECT_THROW((void)class_table_from_json(rubbish), Error) << rubbish;
}

TEST(Photo, lossless_round_trip_keeps_pixels_and_validity) {
  const Scratch scratch;
  Photo photo = noisy_photo(150);
  photo.valid.at(10, 20) = 0;
  io::write_photo(scratch / "photo.tif", photo);
  const Photo back = io::read_photo_native(scratch / "photo.tif");
  EXPECT_EQ(back.frame, photo.frame);
  EXPECT_EQ(back.crs, photo.crs);
  EXPECT_EQ(back.rgb.data, photo.rgb.data);
  EXPECT_EQ(back.valid.data, photo.valid.data);
}

TEST(Photo, windows_of_its_own_grid_are_cut_out_of_the_whole) {
  const Scratch scratch;
  Photo photo = noisy_photo(150);
  photo.valid.at(10, 20) = photo.valid.at(149, 149) = 0;
  io::write_photo(scratch / "photo.tif", photo);
  const PhotoSource windows = io::open_photo_native(scratch / "photo.tif");
  EXPECT_EQ(windows.frame, photo.frame);
  EXPECT_EQ(windows.crs, photo.crs);
  // Inside, all of it, over every edge, over a corner, beside it, and one pixel.
  for (const PixelBox box : {PixelBox{20, 10, 40, 30}, PixelBox{0, 0, 150, 150}, PixelBox{-7, -5, 170, 160},
                             PixelBox{140, 140, 30, 20}, PixelBox{150, 0, 10, 10}, PixelBox{10, 20, 1, 1}}) {
    const PhotoWindow window = windows.read(box), expected = source_of(photo).read(box);
    EXPECT_EQ(window.valid.data, expected.valid.data);
    EXPECT_EQ(window.rgb.data, expected.rgb.data);
  }
}

TEST(Photo, jpeg_keeps_validity_exactly_and_colours_nearly) {
  const Scratch scratch;
  Photo photo = painted_photo(300, 200, 0.5);
  photo.valid.at(100, 50) = 0;
  io::write_photo(scratch / "photo.tif", photo, {.jpeg_quality = 90});
  const Photo back = io::read_photo_native(scratch / "photo.tif");
  EXPECT_EQ(back.valid.data, photo.valid.data);
  for (int row = 5; row < 195; row += 10)
    for (int col = 5; col < 295; col += 10) EXPECT_NEAR(back.rgb.at(col, row, 0), photo.rgb.at(col, row, 0), 6);
}

TEST(Photo, reading_on_its_own_grid_changes_nothing) {
  const Scratch scratch;
  const Photo photo = noisy_photo(120);
  io::write_photo(scratch / "photo.tif", photo);
  const Box2 b = photo.frame.bounds();
  const Photo back = io::read_photo(scratch / "photo.tif", {utm33, rectangle(b.min_x, b.min_y, b.max_x, b.max_y)});
  EXPECT_EQ(back.frame, photo.frame);
  EXPECT_EQ(back.rgb.data, photo.rgb.data);
}

TEST(Photo, warp_puts_colours_where_they_belong) {
  const Scratch scratch;
  const Photo photo = painted_photo(400, 400, 0.5);  // 200 m x 200 m
  io::write_photo(scratch / "photo.tif", photo);
  for (const double gsd_m : {0.3, 1.7}) {  // finer: cubic; much coarser: average
    const Photo back = io::read_photo(scratch / "photo.tif",
                                      {utm33, rectangle(500050.0, 5539850.0, 500150.0, 5539950.0)}, {.gsd_m = gsd_m});
    EXPECT_DOUBLE_EQ(back.frame.gsd_m, gsd_m);
    for (int row = 3; row < back.frame.height - 3; row += 7)
      for (int col = 3; col < back.frame.width - 3; col += 7) {
        const Vec2 p = back.frame.center_of(col, row);
        EXPECT_NEAR(back.rgb.at(col, row, 0), 20.0 + (p.x - 500000.0), 1.5) << gsd_m;
        EXPECT_NEAR(back.rgb.at(col, row, 1), 220.0 - (5540000.0 - p.y), 1.5) << gsd_m;
      }
  }
}

TEST(Photo, validity_ends_with_the_photo_and_with_the_area) {
  const Scratch scratch;
  io::write_photo(scratch / "photo.tif", painted_photo(100, 100, 1.0));
  // The eastern half of the area lies beyond the photo; the area is a triangle.
  const Polygon area{{{500050.0, 5539900.0}, {500150.0, 5539900.0}, {500050.0, 5540000.0}}, {}};
  const Photo back = io::read_photo(scratch / "photo.tif", {utm33, area});
  ASSERT_EQ(back.frame.width, 100);
  EXPECT_EQ(back.valid.at(10, 95), 1);
  EXPECT_EQ(back.valid.at(60, 95), 0) << "beyond the photo";
  EXPECT_EQ(back.valid.at(40, 10), 0) << "outside the area";
}

TEST(Photo, grey_and_palette_sources_become_rgb) {
  const Scratch scratch;
  const LabelMap labels = small_labels();
  io::write_labels(scratch / "palette.tif", labels);
  io::write_confidence(scratch / "grey.tif", {labels.crs, labels.frame, labels.labels});
  const Photo palette = io::read_photo_native(scratch / "palette.tif"),
              grey = io::read_photo_native(scratch / "grey.tif");
  EXPECT_EQ(palette.rgb.at(1, 0, 2), default_class_table().classes[1].color[2]);
  EXPECT_EQ(grey.rgb.at(5, 0, 2), 5);
}

TEST(Photo, nodata_of_all_bands_is_invalid) {
  const Scratch scratch;
  Photo photo = painted_photo(60, 60, 1.0);
  for (int channel = 0; channel < 3; ++channel) photo.rgb.at(30, 30, channel) = 0;
  photo.rgb.at(40, 40, 0) = 0;  // black in one band only is a colour
  io::write_photo(scratch / "photo.tif", photo);
  auto dataset = GDALDataset::FromHandle(GDALOpen((scratch / "photo.tif").c_str(), GA_Update));
  for (int b = 1; b <= 3; ++b) dataset->GetRasterBand(b)->SetNoDataValue(0);
  GDALClose(dataset);
  const Photo native = io::read_photo_native(scratch / "photo.tif");
  EXPECT_EQ(native.valid.at(30, 30), 0);
  EXPECT_EQ(native.valid.at(40, 40), 1);
  const Photo warped =
      io::read_photo(scratch / "photo.tif", {utm33, rectangle(500000.0, 5539940.0, 500060.0, 5540000.0)});
  EXPECT_EQ(warped.valid.at(30, 30), 0);
  EXPECT_EQ(warped.valid.at(40, 40), 1);
}

TEST(Photo, one_thread_equals_many) {
  const Scratch scratch;
  io::write_photo(scratch / "photo.tif", noisy_photo(700));
  const SiteFrame site{Crs{"EPSG:3857"}, rectangle(1669800.0, 6448800.0, 1671000.0, 6450000.0)};
  const Box2 lonlat = bounds_of(io::raster_info(scratch / "photo.tif").outline_lonlat.outer);
  const CoordinateTransform mercator(Crs{"EPSG:4326"}, site.crs);
  const Vec2 a = mercator.target_from_source({lonlat.min_x, lonlat.min_y}),
             b = mercator.target_from_source({lonlat.max_x, lonlat.max_y});
  const SiteFrame around{site.crs, rectangle(a.x, a.y, b.x, b.y)};
  const Photo one = io::read_photo(scratch / "photo.tif", around, {.threads = 1});
  const Photo four = io::read_photo(scratch / "photo.tif", around, {.threads = 4});
  EXPECT_EQ(one.rgb.data, four.rgb.data);
  EXPECT_EQ(one.valid.data, four.valid.data);
}

TEST(Photo, same_photo_same_bytes) {
  const Scratch scratch;
  for (const char* name : {"a.tif", "b.tif"}) io::write_photo(scratch / name, noisy_photo(300), {.jpeg_quality = 85});
  EXPECT_EQ(bytes_of(scratch / "a.tif"), bytes_of(scratch / "b.tif"));
}

/// Each test is a process of its own under CTest: this is the first JPEG of its process.
TEST(Photo, the_first_jpegs_may_be_encoded_by_many_threads_at_once) {
  constexpr int threads = 8;
  Raster<std::uint8_t> image(16, 16, 3);
  std::atomic<int> waiting{threads}, failed{0};
  std::vector<std::jthread> encoders;
  for (int i = 0; i < threads; ++i)
    encoders.emplace_back([&] {
      --waiting;
      while (waiting > 0) {
      }
      try {
        (void)io::encode_jpeg(image);
      } catch (const Error&) {
        ++failed;
      }
    });
  encoders.clear();
  EXPECT_EQ(failed, 0);
}

TEST(BadRaster, missing_file) {
  EXPECT_THAT(message_of<InputError>([] { (void)io::raster_info("/nowhere/photo.tif"); }),
              HasSubstr("/nowhere/photo.tif: no such file"));
}

TEST(BadRaster, not_a_raster) {
  const Scratch scratch;
  write_bytes(scratch / "photo.tif", "this is text");
  EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(scratch / "photo.tif"); }), HasSubstr("not a raster"));
}

TEST(BadRaster, format_in_which_no_geodata_comes) {
  const Scratch scratch;
  std::string grid = "CTABLE V2" + std::string(151, '\0');  // of PROJ: 4 x 4 nodes
  const double place[4] = {0.2, 0.8, 0.01, 0.01};
  std::memcpy(grid.data() + 96, place, sizeof place);
  grid[128] = grid[132] = 4;
  grid += std::string(4 * 4 * 8, '\0');
  write_bytes(scratch / "grid.ct2", grid);
  EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(scratch / "grid.ct2"); }),
              HasSubstr("not a raster of a format that is read here"));
}

TEST(BadRaster, truncated_geotiff_at_any_length) {
  const Scratch scratch;
  const Photo photo = noisy_photo(600);
  const SiteFrame site{utm33, rectangle(500010.0, 5539800.0, 500200.0, 5539990.0)};
  for (const double share : {0.999, 0.7, 0.2, 0.01}) {
    io::write_photo(scratch / "photo.tif", photo);
    truncate_to(scratch / "photo.tif", share);
    EXPECT_THAT(message_of<InputError>([&] { (void)io::read_photo(scratch / "photo.tif", site); }),
                HasSubstr("truncated"))
        << share;
    EXPECT_THAT(message_of<InputError>([&] { (void)io::read_photo_native(scratch / "photo.tif"); }),
                HasSubstr("truncated"))
        << share;
    EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(scratch / "photo.tif"); }), HasSubstr("truncated"))
        << share;
  }
}

TEST(BadRaster, blocks_that_its_bytes_cannot_hold) {
  const Scratch scratch;
  GDALRegister_GTiff();
  const std::string path = (scratch / "bands.tif").string();
  const char* const options[] = {
      "TILED=YES", "BLOCKXSIZE=1024", "BLOCKYSIZE=1024", "INTERLEAVE=PIXEL", "COMPRESS=DEFLATE", "SPARSE_OK=TRUE",
      nullptr};
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALClose(driver->Create(path.c_str(), 64, 64, 600, GDT_Byte, options));
  EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(path); }),
              HasSubstr("600 bands lie in blocks of 629 MB"));
  GDALClose(driver->Create(path.c_str(), 64, 64, 200, GDT_Byte, options));
  EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(path); }), HasSubstr("no georeferencing"));
}

TEST(BadRaster, truncated_jpeg) {
  const Scratch scratch;
  const Photo photo = noisy_photo(300);
  const std::vector<std::uint8_t> jpeg = io::encode_jpeg(photo.rgb);
  write_bytes(scratch / "photo.jpg", {jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() / 2)});
  EXPECT_THROW((void)io::read_image(scratch / "photo.jpg"), InputError);
}

TEST(BadRaster, photo_without_georeferencing_says_the_remedy) {
  const Scratch scratch;
  io::write_png(scratch / "photo.png", noisy_photo(20).rgb);
  EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(scratch / "photo.png"); }),
              HasSubstr("gdal_translate -a_srs"));
}

TEST(BadRaster, world_file_that_places_it_nowhere) {
  const Scratch scratch;
  io::write_png(scratch / "photo.png", noisy_photo(20).rgb);
  for (const char* place : {"0.5 0 0 -0.5 nan 5540000", "1e300 0 0 -0.5 500000 5540000", "0.5 0.5 0.5 0.5 500000 0"}) {
    std::string lines = place;
    std::replace(lines.begin(), lines.end(), ' ', '\n');
    write_bytes(scratch / "photo.pgw", lines + "\n");
    EXPECT_THAT(message_of<InputError>([&] { (void)io::raster_info(scratch / "photo.png"); }),
                HasSubstr("its georeferencing places it nowhere"))
        << place;
  }
}

TEST(BadRaster, photo_of_somewhere_else_says_where) {
  const Scratch scratch;
  io::write_photo(scratch / "photo.tif", painted_photo(50, 50, 1.0));
  const SiteFrame site{utm33, rectangle(510000.0, 5539000.0, 510100.0, 5539100.0)};
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_photo(scratch / "photo.tif", site); }),
              HasSubstr("longitude 15.00000"));
}

TEST(BadRaster, sixteen_bit_photo_says_how_to_convert) {
  const Scratch scratch;
  io::write_dtm(scratch / "float.tif", {utm33, {500000.0, 5540000.0, 1.0, 20, 20}, Raster<float>(20, 20), ""});
  EXPECT_THAT(message_of<InputError>([&] { (void)io::read_photo_native(scratch / "float.tif"); }),
              HasSubstr("-ot Byte"));
}

TEST(BadRaster, full_disk_leaves_the_earlier_file_and_nothing_else) {
  const Scratch scratch;
  const Photo photo = noisy_photo(600);  // 1 MB
  for (const rlim_t limit : {2000, 300000, 1000000}) {
    write_bytes(scratch / "photo.tif", "earlier");
    {
      const FileSizeLimit full(limit);
      EXPECT_THAT(message_of<Error>([&] { io::write_photo(scratch / "photo.tif", photo); }), HasSubstr("disk full"))
          << limit;
    }
    EXPECT_EQ(bytes_of(scratch / "photo.tif"), "earlier");
    EXPECT_EQ(scratch.file_count(), 1) << limit;
  }
}

class Kvarnbyn : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(folder)) GTEST_SKIP() << "REAL DATA MISSING: " << folder;
    site = lonlat_site(12.008, 57.6495, 12.044, 57.6625);
  }
  const fs::path folder = paths::in_source("../shared/data/kvarnbyn");
  SiteFrame site;
};

TEST_F(Kvarnbyn, jpeg_with_world_file_is_understood) {
  const io::RasterInfo info = io::raster_info(folder / "ortho.jpg");
  EXPECT_EQ(info.crs.definition, "EPSG:4326");
  EXPECT_EQ(info.width, 4096);
  EXPECT_EQ(info.height, 2764);
  EXPECT_NEAR(info.gsd_m, 0.523, 0.002);
  const Box2 box = bounds_of(info.outline_lonlat.outer);
  EXPECT_NEAR(box.min_x, 12.008, 1e-7);
  EXPECT_NEAR(box.max_y, 57.6625, 1e-7);
}

TEST_F(Kvarnbyn, photo_fills_the_area) {
  const Photo photo = io::read_photo(folder / "ortho.jpg", site);
  EXPECT_DOUBLE_EQ(photo.frame.gsd_m, 0.52);
  std::size_t valid = 0;
  for (const std::uint8_t v : photo.valid.data) valid += v;
  EXPECT_NEAR(static_cast<double>(valid) * 0.52 * 0.52, area_m2(site.area), 0.002 * area_m2(site.area));
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
// Photos read and labels written window by window: the same as all at once, and nothing left behind.

#include <fmt/format.h>
#include <gdal_priv.h>
#include <gmock/gmock.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/raster/raster_io.hpp"
#include "photo_window.hpp"
#include "places.hpp"
#include "scratch.hpp"

namespace orthodrive {
namespace {
using testing::HasSubstr;

Photo noisy_picture(int width, int height) {
  Photo photo{.crs = utm33, .frame = {500000.0, 5540000.0, 0.5, width, height}};
  photo.rgb = Raster<std::uint8_t>(width, height, 3);
  photo.valid = Raster<std::uint8_t>(width, height, 1, 1);
  Random random(7);
  for (std::uint8_t& value : photo.rgb.data) value = static_cast<std::uint8_t>(random.below(256));
  for (int i = 0; i < width; ++i) photo.valid.at(i, (3 * i) % height) = 0;
  return photo;
}

/// A skew area in another zone: the grids are turned against each other, and the area has slanted edges.
SiteFrame skew_site(const std::filesystem::path& photo) {
  const Crs utm32{"EPSG:32632"};
  const CoordinateTransform site_from_lonlat({"EPSG:4326"}, utm32);
  SiteFrame site{utm32, {}};
  for (const Vec2 p : io::raster_info(photo).outline_lonlat.outer) {
    const Vec2 q = site_from_lonlat.target_from_source(p);
    const double north_m = site.area.outer.empty() ? q.y : site.area.outer.front().y;
    site.area.outer.push_back({q.x + 0.2 * (q.y - north_m), q.y});
  }
  return site;
}

TEST(PhotoStream, any_window_has_the_bytes_of_the_whole_whoever_reads_it) {
  const Scratch scratch;
  for (const int jpeg_quality : {0, 90}) {
    io::write_photo(scratch / "photo.tif", noisy_picture(900, 700), {.jpeg_quality = jpeg_quality});
    const SiteFrame site = skew_site(scratch / "photo.tif");
    const Photo whole = io::read_photo(scratch / "photo.tif", site);
    ASSERT_GT(whole.frame.width, 900);  // several of the blocks that GDAL warps at once
    EXPECT_GT(std::count(whole.valid.data.begin(), whole.valid.data.end(), 0), 10000) << "corners outside the area";
    const PhotoSource source = io::open_photo(scratch / "photo.tif", site, {.threads = 1});
    ASSERT_EQ(source.frame, whole.frame);
    std::vector<PixelBox> boxes{{-100, -50, 300, 200}, {509, 126, 5, 4}, {511, 0, 1, 900}, {5000, 5000, 9, 9}};
    for (int row = -37; row < whole.frame.height; row += 171)
      for (int col = -11; col < whole.frame.width; col += 233) boxes.push_back({col, row, 233, 171});
    parallel_for(boxes.size(), 4, [&](std::size_t i) { expect_window_of(whole, boxes[i], source.read(boxes[i])); });
  }
}

TEST(PhotoStream, photo_of_somewhere_else_is_told_when_it_is_opened) {
  const Scratch scratch;
  io::write_photo(scratch / "photo.tif", noisy_picture(50, 50));
  const SiteFrame site{utm33, rectangle(510000.0, 5539000.0, 510100.0, 5539100.0)};
  EXPECT_THAT(message_of<InputError>([&] { (void)io::open_photo(scratch / "photo.tif", site); }),
              HasSubstr("photo.tif: shows nothing of the area"));
}

TEST(PhotoStream, damage_inside_a_tile_is_told_when_it_is_read) {
  const Scratch scratch;
  Photo photo = noisy_picture(600, 600);
  io::write_photo(scratch / "photo.tif", photo);
  std::string bytes = bytes_of(scratch / "photo.tif");
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2),
            bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2 + 20000), '\x55');
  write_bytes(scratch / "photo.tif", bytes);
  const Box2 b = photo.frame.bounds();
  const SiteFrame site{utm33, rectangle(b.min_x, b.min_y, b.max_x, b.max_y)};
  const PhotoSource source = io::open_photo(scratch / "photo.tif", site);
  EXPECT_THAT(message_of<InputError>([&] { (void)source.read(pixels_of(source.frame)); }),
              HasSubstr("photo.tif: cannot be read to its end"));
}

/// Blobs, as labels are, over several tiles of the file.
LabelMap blobs(int width, int height) {
  LabelMap map{
      utm33, {500000.0, 5540000.0, 0.5, width, height}, Raster<std::uint8_t>(width, height), default_class_table()};
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col)
      map.labels.at(col, row) =
          static_cast<std::uint8_t>((col / 37 + row / 23) % 9 == 8 ? label_nodata : (col / 37 + row / 23) % 8);
  return map;
}

template <typename T>
Raster<T> cut(const Raster<T>& whole, const PixelBox& box) {
  Raster<T> part(box.width, box.height, whole.channels);
  for (int row = 0; row < box.height; ++row)
    for (int col = 0; col < box.width; ++col)
      for (int c = 0; c < whole.channels; ++c)
        part.at(col, row, c) = whole.at(static_cast<int>(box.col) + col, static_cast<int>(box.row) + row, c);
  return part;
}

/// Boxes of a width that is no divisor of the file's tiles, in an order that comes back to tiles long left.
std::vector<PixelBox> shuffled_boxes(const GridFrame& frame, int step) {
  std::vector<PixelBox> boxes;
  for (int row = 0; row < frame.height; row += step)
    for (int col = 0; col < frame.width; col += step)
      boxes.push_back({col, row, std::min(step, frame.width - col), std::min(step, frame.height - row)});
  Random random(3);
  for (std::size_t i = boxes.size(); i > 1; --i) std::swap(boxes[i - 1], boxes[random.below(i)]);
  return boxes;
}

TEST(RasterStream, file_is_the_one_that_is_written_at_once) {
  const Scratch scratch;
  const LabelMap map = blobs(5300, 4700);  // 11 x 10 tiles: more than wait in memory
  io::write_labels(scratch / "once.tif", map);
  io::RasterStream stream = io::stream_labels(scratch / "boxes.tif", map.crs, map.frame, map.classes);
  for (const PixelBox& box : shuffled_boxes(map.frame, 300)) stream.write(box, cut(map.labels, box));
  EXPECT_EQ(scratch.file_count(), 1) << "a run killed now leaves nothing";
  stream.finish();
  EXPECT_EQ(io::read_labels(scratch / "boxes.tif").labels.data, map.labels.data);
  EXPECT_TRUE(bytes_of(scratch / "boxes.tif") == bytes_of(scratch / "once.tif"));
  EXPECT_EQ(scratch.file_count(), 2);

  io::write_confidence(scratch / "once.tif", {map.crs, map.frame, map.labels});
  io::RasterStream confidence = io::stream_confidence(scratch / "boxes.tif", map.crs, map.frame);
  for (const PixelBox& box : shuffled_boxes(map.frame, 1111)) confidence.write(box, cut(map.labels, box));
  confidence.finish();
  EXPECT_TRUE(bytes_of(scratch / "boxes.tif") == bytes_of(scratch / "once.tif"));
}

TEST(RasterStream, photo_and_terrain_are_the_ones_that_are_written_at_once) {
  const Scratch scratch;
  Photo photo = noisy_picture(1300, 900);
  std::fill(photo.valid.data.begin(), photo.valid.data.end(), std::uint8_t{1});
  for (const int jpeg_quality : {0, 85}) {
    io::write_photo(scratch / "once.tif", photo, {.jpeg_quality = jpeg_quality});
    io::RasterStream stream =
        io::stream_photo(scratch / "boxes.tif", photo.crs, photo.frame, {.jpeg_quality = jpeg_quality});
    for (const PixelBox& box : shuffled_boxes(photo.frame, 300)) stream.write(box, cut(photo.rgb, box));
    stream.finish();
    EXPECT_TRUE(bytes_of(scratch / "boxes.tif") == bytes_of(scratch / "once.tif")) << jpeg_quality;
  }
  HeightGrid heights{photo.crs, photo.frame, Raster<float>(1300, 900), ""};
  Random random(8);
  for (float& z : heights.height_m.data) z = static_cast<float>(random.uniform(200.0, 300.0));
  io::write_dtm(scratch / "once.tif", heights);
  io::RasterStream stream = io::stream_dtm(scratch / "boxes.tif", heights.crs, heights.frame);
  for (const PixelBox& box : shuffled_boxes(heights.frame, 300)) stream.write(box, cut(heights.height_m, box));
  stream.finish();
  EXPECT_TRUE(bytes_of(scratch / "boxes.tif") == bytes_of(scratch / "once.tif"));
}

TEST(RasterStream, what_was_not_written_is_nodata) {
  const Scratch scratch;
  const LabelMap map = blobs(700, 100);
  io::RasterStream stream = io::stream_labels(scratch / "labels.tif", map.crs, map.frame, map.classes);
  stream.write({10, 20, 30, 40}, cut(map.labels, {10, 20, 30, 40}));
  stream.finish();
  const LabelMap back = io::read_labels(scratch / "labels.tif");
  EXPECT_EQ(back.labels.at(12, 25), map.labels.at(12, 25));
  EXPECT_EQ(back.labels.at(50, 25), label_nodata);
  EXPECT_EQ(back.labels.at(690, 90), label_nodata);
}

TEST(RasterStream, unfinished_leaves_the_earlier_file_and_nothing_else) {
  const Scratch scratch;
  write_bytes(scratch / "labels.tif", "earlier");
  const LabelMap map = blobs(700, 600);
  {
    io::RasterStream stream = io::stream_labels(scratch / "labels.tif", map.crs, map.frame, map.classes);
    stream.write(pixels_of(map.frame), map.labels);
  }
  EXPECT_EQ(bytes_of(scratch / "labels.tif"), "earlier");
  EXPECT_EQ(scratch.file_count(), 1);
}

TEST(RasterStream, full_disk_and_a_folder_that_cannot_be_are_told_by_the_name_of_the_file) {
  const Scratch scratch;
  const Photo noise = noisy_picture(1400, 1400);
  Raster<std::uint8_t> confidence(1400, 1400);
  std::copy_n(noise.rgb.data.begin(), confidence.data.size(), confidence.data.begin());
  write_bytes(scratch / "confidence.tif", "earlier");
  for (const rlim_t limit : {2000, 300000, 1970000}) {  // in the waiting file; in the end
    const FileSizeLimit full(limit);
    EXPECT_THAT(message_of<Error>([&] {
                  io::RasterStream stream = io::stream_confidence(scratch / "confidence.tif", utm33, noise.frame);
                  stream.write(pixels_of(noise.frame), confidence);
                  stream.finish();
                }),
                HasSubstr("confidence.tif: cannot be written"))
        << limit;
    EXPECT_EQ(bytes_of(scratch / "confidence.tif"), "earlier");
    EXPECT_EQ(scratch.file_count(), 1);
  }
  EXPECT_THAT(message_of<Error>([&] {
                (void)io::stream_confidence(scratch / "confidence.tif" / "sub" / "c.tif", utm33, noise.frame);
              }),
              HasSubstr("cannot be created"));
}

}  // namespace
}  // namespace orthodrive

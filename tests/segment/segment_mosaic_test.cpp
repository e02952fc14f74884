// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/segment_mosaic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "nets/shipped_model.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/model_metadata.hpp"
#include "orthodrive/nets/net_surgery.hpp"
#include "orthodrive/segment/ordered_delivery.hpp"
#include "orthodrive/segment/resample_photo.hpp"

namespace orthodrive {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Grass with a grey road from west to east, a red roof, and noise on everything.
Photo painted_photo(int width, int height, double gsd_m) {
  Photo photo{{"EPSG:32633"},
              {500000.0, 6400000.0, gsd_m, width, height},
              Raster<std::uint8_t>(width, height, 3),
              Raster<std::uint8_t>(width, height, 1, 1)};
  Random random(5);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      const double x_m = col * gsd_m, y_m = row * gsd_m;
      const bool road = std::abs(y_m - 60.0 - 5.0 * std::sin(x_m / 30.0))<4.0, roof = x_m> 40.0 && x_m < 60.0 &&
                        y_m > 80.0 && y_m < 95.0;
      const int base[3] = {road ? 115 : roof ? 170 : 90, road ? 115 : roof ? 90 : 115, road ? 118 : roof ? 75 : 70};
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(col, row, c) = static_cast<std::uint8_t>(std::clamp(base[c] + 4.0 * random.normal(), 0.0, 255.0));
    }
  }
  return photo;
}

double share_of_different(const Raster<std::uint8_t>& a, const Raster<std::uint8_t>& b) {
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) different += a.data[i] != b.data[i] ? 1 : 0;
  return static_cast<double>(different) / static_cast<double>(a.data.size());
}

TEST(SegmentMosaic, outcome_does_not_depend_on_window_size) {
  const Photo photo = painted_photo(600, 40, 0.5);  // long, so that 512 needs two windows and 67 many
  constexpr int whole_px = 1 << 20;
  const SegmentResult one = segment_mosaic(photo, shipped_model(), {.window_px = whole_px});
  for (const int window_px : {512, 67}) {
    const SegmentResult many = segment_mosaic(photo, shipped_model(), {.window_px = window_px});
    EXPECT_EQ(one.labels.labels.data, many.labels.labels.data) << window_px;
    EXPECT_EQ(one.confidence.confidence.data, many.confidence.confidence.data) << window_px;
    EXPECT_EQ(one.road_probability.confidence.data, many.road_probability.confidence.data) << window_px;
  }
}

TEST(SegmentMosaic, boxes_come_in_order_and_cover_the_frame_once) {
  Photo photo = painted_photo(700, 260, 0.5);
  for (int row = 0; row < 260; ++row)
    for (int col = 30; col < 700; ++col) photo.valid.at(col, row) = 0;  // most windows are done at once
  Raster<std::uint8_t> seen(700, 260);
  PixelBox before{-1, 0, 0, 0};
  const SegmentSummary summary = segment_mosaic(
      source_of(photo), shipped_model(),
      [&](const PixelBox& box, const LabelledPixels& pixels) {
        EXPECT_TRUE(box.row > before.row || (box.row == before.row && box.col > before.col));
        before = box;
        ASSERT_EQ(std::pair(pixels.labels.width, pixels.labels.height), std::pair(box.width, box.height));
        ASSERT_EQ(pixels.confidence.data.size(), pixels.labels.data.size());
        for (std::size_t i = 0; i < pixels.labels.data.size(); ++i) {
          const int label = pixels.labels.data[i], road = pixels.road_probability.data[i],
                    sure = pixels.confidence.data[i];
          ASSERT_TRUE(label == label_nodata ? road == 0
                      : label == 1          ? road == sure
                                            : road + sure <= 256)
              << "both are rounded";
        }
        for (int row = 0; row < box.height; ++row)
          for (int col = 0; col < box.width; ++col)
            ++seen.at(static_cast<int>(box.col) + col, static_cast<int>(box.row) + row);
      },
      {.window_px = 66, .threads = 4});
  EXPECT_TRUE(std::all_of(seen.data.begin(), seen.data.end(), [](int times) { return times == 1; }));
  EXPECT_EQ(summary.frame, photo.frame);
  EXPECT_EQ(summary.labelled_pixels, 30 * 260);
}

TEST(SegmentMosaic, what_fails_in_reading_or_writing_ends_the_run_whatever_waits) {
  const Photo photo = painted_photo(400, 200, 0.5);
  const LabelSink full_disk = [](const PixelBox& box, const LabelledPixels&) {
    if (box.col > 0) throw Error("labels.tif: disk full");
  };
  const SegmentOptions options{.window_px = 66, .threads = 3};
  EXPECT_THAT([&] { (void)segment_mosaic(source_of(photo), shipped_model(), full_disk, options); },
              ThrowsMessage<Error>(HasSubstr("disk full")));
  PhotoSource damaged = source_of(photo);
  damaged.read = [](const PixelBox&) -> PhotoWindow { throw InputError("photo.tif", "truncated"); };
  EXPECT_THAT([&] { (void)segment_mosaic(damaged, shipped_model(), full_disk, options); },
              ThrowsMessage<InputError>(HasSubstr("photo.tif: truncated")));
}

/// A road along the painted one, three metres off.
MapLines map_of_painted_photo() {
  RoadLine line{.half_width = 4.0};
  for (int i = 0; i <= 12; ++i) line.points.push_back({500000.0 + 20.0 * i, 6400000.0 - 63.0});
  return MapLines({line});
}

TEST(SegmentMosaic, windows_made_elsewhere_are_taken_as_they_would_be_made_here) {
  const Photo photo = painted_photo(300, 200, 0.5);
  const MapLines map = map_of_painted_photo();
  std::vector<Vec2> places;
  for (int i = 1; i < 70; ++i) places.push_back({500000.0 + 2.0 * i, 6400000.0 - 63.0});
  SegmentOptions options{.window_px = 90, .threads = 2, .map = &map, .places = places};
  const auto segment = [&] {
    Raster<std::uint8_t> labels(photo.frame.width, photo.frame.height);
    const SegmentSummary summary = segment_mosaic(
        source_of(photo), shipped_model(),
        [&](const PixelBox& box, const LabelledPixels& pixels) {
          for (int row = 0; row < box.height; ++row)
            for (int col = 0; col < box.width; ++col)
              labels.at(static_cast<int>(box.col) + col, static_cast<int>(box.row) + row) = pixels.labels.at(col, row);
        },
        options);
    return std::pair(labels, summary);
  };
  const auto [labels, summary] = segment();
  ASSERT_TRUE(std::ranges::any_of(summary.alignments, [](const PlaceAlignment& a) { return a.sigma_m > 0.0; }));

  // Two workers share the windows but for the last, which is left for segment_mosaic() to make.
  std::vector<std::string> made(12);
  for (const std::size_t worker : {0U, 1U}) {
    std::atomic<std::size_t> asked{worker};
    const auto next = [&](std::size_t count) {
      EXPECT_EQ(count, made.size());
      const std::size_t window = asked.fetch_add(2);
      return window + 1 < count ? std::optional(window) : std::nullopt;
    };
    segment_windows(
        source_of(photo), shipped_model(), next,
        [&](std::size_t window, const std::string& bytes) { made[window] = bytes; }, options);
  }
  std::atomic<int> taken{0};
  options.made = [&](std::size_t window) -> std::optional<std::string> {
    if (made[window].empty()) return std::nullopt;
    ++taken;
    return made[window];
  };
  const auto [labels_of_made, summary_of_made] = segment();
  EXPECT_EQ(taken, 11);
  EXPECT_EQ(labels_of_made.data, labels.data);
  EXPECT_EQ(summary_of_made.labelled_pixels, summary.labelled_pixels);
  ASSERT_EQ(summary_of_made.alignments.size(), summary.alignments.size());
  for (std::size_t i = 0; i < summary.alignments.size(); ++i) {
    EXPECT_EQ(summary_of_made.alignments[i].displacement_m, summary.alignments[i].displacement_m) << i;
    EXPECT_EQ(summary_of_made.alignments[i].sigma_m, summary.alignments[i].sigma_m) << i;
  }

  made[3].pop_back();
  EXPECT_THAT(segment, ThrowsMessage<InputError>(HasSubstr("window 3")));
  made[3] = made[11 - 1];  // a window of another size
  EXPECT_THAT(segment, ThrowsMessage<InputError>(HasSubstr("window 3")));
}

TEST(OrderedDelivery, any_order_of_finishing_is_delivered_by_index_and_few_wait) {
  constexpr std::size_t count = 500, ahead = 6;
  std::vector<std::size_t> delivered;
  std::atomic<std::size_t> started{0};
  std::size_t most_waiting = 0;
  OrderedDelivery<std::size_t> delivery(ahead, [&](std::size_t index, const std::size_t& item) {
    EXPECT_EQ(item, 3 * index);
    most_waiting = std::max(most_waiting, started.load() - delivered.size());
    delivered.push_back(index);
  });
  parallel_for(count, 4, [&](std::size_t i) {
    ASSERT_TRUE(delivery.wait_for_room(i));
    ++started;
    if (i % 7 == 0) std::this_thread::sleep_for(std::chrono::microseconds(300));  // the others overtake it
    delivery.hand_over(i, 3 * i);
  });
  ASSERT_EQ(delivered.size(), count);
  EXPECT_TRUE(std::is_sorted(delivered.begin(), delivered.end()));
  EXPECT_LE(most_waiting, ahead);
}

/// The CRF connects every pixel with every other: windows see the same but for what is far away, and what differs does
/// not gather along their borders.
TEST(SegmentMosaic, crf_changes_labels_and_hardly_depends_on_windows) {
  const Photo photo = painted_photo(420, 350, 0.5);
  const CrfModel crf = reference_crf(8);
  constexpr int window_px = 70, near_px = 7;  // a fifth of a row's pixels, twice: 36 % lie near a border
  const SegmentResult whole = segment_mosaic(photo, shipped_model(), {.window_px = 1200, .crf = crf});
  const SegmentResult windows = segment_mosaic(photo, shipped_model(), {.window_px = window_px, .crf = crf});
  double near = 0.0, far = 0.0, near_pixels = 0.0, far_pixels = 0.0;
  for (int row = 0; row < photo.frame.height; ++row)
    for (int col = 0; col < photo.frame.width; ++col) {
      const auto from_border = [](int at) { return std::min(at % window_px, window_px - 1 - at % window_px); };
      const bool border = std::min(from_border(row), from_border(col)) < near_px;
      const double differs = whole.labels.labels.at(col, row) != windows.labels.labels.at(col, row) ? 1.0 : 0.0;
      (border ? near : far) += differs;
      (border ? near_pixels : far_pixels) += 1.0;
    }
  EXPECT_LE((near + far) / (near_pixels + far_pixels), 1e-3);
  EXPECT_LE(near / near_pixels, 2.0 * far / far_pixels + 2e-4)
      << near << " of " << near_pixels << ", " << far << " of " << far_pixels;
  const SegmentResult without = segment_mosaic(photo, shipped_model(), {.window_px = 1200});
  EXPECT_GT(share_of_different(whole.labels.labels, without.labels.labels), 1e-3);
  EXPECT_THROW(static_cast<void>(segment_mosaic(photo, shipped_model(), {.crf = reference_crf(5)})), OptionError);
}

TEST(SegmentMosaic, same_bytes_for_one_and_two_threads) {
  const Photo photo = painted_photo(280, 130, 0.5);
  const SegmentResult one = segment_mosaic(photo, shipped_model(), {.window_px = 98, .threads = 1});
  const SegmentResult two = segment_mosaic(photo, shipped_model(), {.window_px = 98, .threads = 2});
  EXPECT_EQ(one.labels.labels.data, two.labels.labels.data);
  EXPECT_EQ(one.confidence.confidence.data, two.confidence.confidence.data);
}

/// A grid of the model's scale, or half of its finest where the photo can tell.
TEST(SegmentMosaic, labels_lie_on_their_grid_and_skip_missing_photo) {
  for (const auto& [photo_gsd, label_gsd] : {std::pair{0.2, 0.5 * shipped_model().finest_gsd_m}, std::pair{0.4, 0.5}}) {
    Photo photo = painted_photo(400, 300, photo_gsd);
    for (int row = 0; row < 300; ++row)
      for (int col = 0; col < 100; ++col) photo.valid.at(col, row) = 0;
    const SegmentResult result = segment_mosaic(photo, shipped_model());
    const auto cells = [&](int pixels) { return static_cast<int>(std::lround(pixels * photo_gsd / label_gsd)); };
    EXPECT_EQ(result.labels.frame, (GridFrame{500000.0, 6400000.0, label_gsd, cells(400), cells(300)}));
    EXPECT_EQ(label_frame(photo.frame, shipped_model()), result.labels.frame);
    EXPECT_EQ(result.labels.classes.classes.size(), 8u);
    EXPECT_EQ(result.labels.labels.at(cells(100) - 1, 60), label_nodata);
    EXPECT_EQ(result.confidence.confidence.at(cells(100) - 1, 60), 0);
    EXPECT_LT(result.labels.labels.at(cells(100) + 1, 60), 8);
    EXPECT_TRUE(result.findings.empty());
  }
}

TEST(SegmentMosaic, finer_labels_depend_on_no_window_either) {
  const Photo photo = painted_photo(700, 500, 0.2);
  const SegmentResult one = segment_mosaic(photo, shipped_model(), {.window_px = 1200});
  const SegmentResult many = segment_mosaic(photo, shipped_model(), {.window_px = 170});
  EXPECT_LE(share_of_different(one.labels.labels, many.labels.labels), 1e-5);
}

TEST(SegmentMosaic, finds_a_plain_road) {
  const SegmentResult result = segment_mosaic(painted_photo(300, 250, 0.5), shipped_model());
  int hits = 0;
  for (int col = 20; col < 280; ++col) {
    const double row = 2.0 * (60.0 + 5.0 * std::sin(0.5 * col / 30.0));
    hits += result.labels.labels.at(col, static_cast<int>(row)) == 1 ? 1 : 0;
  }
  EXPECT_GT(hits, 240) << "of 260 places on the centre line";
}

TEST(SegmentMosaic, empty_and_coarse_photos) {
  Photo nothing = painted_photo(40, 30, 0.5);
  std::fill(nothing.valid.data.begin(), nothing.valid.data.end(), std::uint8_t{0});
  const SegmentResult result = segment_mosaic(nothing, shipped_model());
  EXPECT_TRUE(std::all_of(result.labels.labels.data.begin(), result.labels.labels.data.end(),
                          [](int label) { return label == label_nodata; }));
  ASSERT_EQ(result.findings.size(), 1u);
  EXPECT_EQ(result.findings[0].code, "segment.no_photo");
  const SegmentResult coarse = segment_mosaic(painted_photo(20, 15, 2.0), shipped_model());
  ASSERT_EQ(coarse.findings.size(), 1u);
  EXPECT_EQ(coarse.findings[0].code, "segment.coarse_photo");
}

TEST(SegmentMosaic, refuses_windows_without_pixels) {
  EXPECT_THAT([] { (void)segment_mosaic(painted_photo(20, 20, 0.5), shipped_model(), {.window_px = -1}); },
              ThrowsMessage<OptionError>(HasSubstr("window of -1 px")));
}

TEST(LoadModel, class_table_that_does_not_match_the_weights) {
  TensorFile file = shipped_tensors();
  std::string& table = file.metadata.at("classes");
  table.replace(table.find("{\"color\""), table.find("},{") + 2 - table.find("{\"color\""), "");  // one class less
  EXPECT_THAT([&] { static_cast<void>(load_model(file, "m.safetensors")); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("m.safetensors: class table 'orthodrive-8' has 7 classes but the weights score 8"))));
}

TEST(LoadModel, damaged_files_are_input_errors) {
  TensorFile no_table = shipped_tensors();
  no_table.metadata.clear();
  EXPECT_THROW(static_cast<void>(load_model(no_table, "m")), InputError);
  TensorFile other = shipped_tensors();
  other.metadata["architecture"] = "vgg16";
  EXPECT_THROW(static_cast<void>(load_model(other, "m")), InputError);
  TensorFile missing = shipped_tensors();
  missing.tensors.erase("block_4_project/kernel");
  EXPECT_THAT([&] { static_cast<void>(load_model(missing, "m")); },
              ThrowsMessage<InputError>(HasSubstr("tensor 'block_4_project/kernel' is missing")));
  TensorFile reshaped = shipped_tensors();
  reshaped.tensors.at("head/bias") = {{4}, {0, 0, 0, 0}, TensorType::f32};
  EXPECT_THROW(static_cast<void>(load_model(reshaped, "m")), InputError);
}

TEST(ResamplePhoto, averages_when_coarser_and_keeps_constant_colours) {
  Photo photo{{"EPSG:32633"},
              {0.0, 10.0, 0.2, 50, 50},
              Raster<std::uint8_t>(50, 50, 3, 100),
              Raster<std::uint8_t>(50, 50, 1, 1)};
  for (int row = 0; row < 50; ++row) photo.rgb.at(0, row, 0) = 200;  // a fifth and a fifth of the first pixel of 0.5 m
  const Photo half = resample_photo(photo, 0.5);
  EXPECT_EQ(half.frame, (GridFrame{0.0, 10.0, 0.5, 20, 20}));
  EXPECT_EQ(half.rgb.at(0, 7, 0), 140);
  EXPECT_EQ(half.rgb.at(0, 7, 1), 100);
  EXPECT_EQ(half.rgb.at(19, 19, 2), 100);
  const Photo same = resample_photo(photo, 0.2);
  EXPECT_EQ(same.rgb.data, photo.rgb.data);
}

TEST(ResamplePhoto, bilinear_reproduces_a_ramp) {
  Photo photo{{"EPSG:32633"},
              {0.0, 52.0, 0.52, 100, 100},
              Raster<std::uint8_t>(100, 100, 3),
              Raster<std::uint8_t>(100, 100, 1, 1)};
  for (int row = 0; row < 100; ++row) {
    for (int col = 0; col < 100; ++col) photo.rgb.at(col, row, 0) = static_cast<std::uint8_t>(2 * col);
  }
  const Photo out = resample_photo(photo, 0.5);
  for (int col = 2; col < 100; ++col) {
    const double expected = 2.0 * ((col + 0.5) * 0.5 / 0.52 - 0.5);
    EXPECT_NEAR(out.rgb.at(col, 50, 0), expected, 0.51) << col;
  }
}

TEST(ResamplePhoto, any_window_has_the_bytes_of_the_whole) {
  for (const double gsd_m : {0.1, 0.2, 0.43, 0.5, 0.52, 1.0}) {
    SCOPED_TRACE(gsd_m);
    Photo photo = painted_photo(331, 217, gsd_m);
    photo.frame.west_m += 0.37;  // the grids do not meet
    Random random(9);
    for (int hole = 0; hole < 4000; ++hole)
      photo.valid.at(static_cast<int>(random.below(331)), static_cast<int>(random.below(217))) = 0;
    const Photo whole = resample_photo(photo, 0.5);
    const PhotoSource source = resample_source(source_of(photo), 0.5);
    ASSERT_EQ(source.frame, whole.frame);
    for (const PixelBox box :
         {PixelBox{-20, -30, 70, 60}, PixelBox{13, 7, 31, 1}, PixelBox{17, 11, 1000, 900}, PixelBox{-5, 20, 3, 3}}) {
      const PhotoWindow window = source.read(box);
      int different = 0;
      for (int row = 0; row < box.height; ++row)
        for (int col = 0; col < box.width; ++col) {
          const int at_col = static_cast<int>(box.col) + col, at_row = static_cast<int>(box.row) + row;
          const bool inside = whole.valid.inside(at_col, at_row);
          different += window.valid.at(col, row) != (inside ? whole.valid.at(at_col, at_row) : 0) ? 1 : 0;
          for (int c = 0; c < 3; ++c)
            different +=
                window.rgb.at(col, row, c) != (inside ? whole.rgb.at(at_col, at_row, c) : no_photo_value) ? 1 : 0;
        }
      EXPECT_EQ(different, 0) << box.col << ' ' << box.row;
    }
  }
}

TEST(ResamplePhoto, pixels_without_photo_do_not_colour_their_neighbours) {
  Photo photo{{"EPSG:32633"},
              {0.0, 10.0, 0.2, 50, 50},
              Raster<std::uint8_t>(50, 50, 3, 100),
              Raster<std::uint8_t>(50, 50, 1, 1)};
  for (int row = 0; row < 50; ++row)
    for (int col = 0; col < 21; ++col) photo.valid.at(col, row) = 0, photo.rgb.at(col, row, 1) = 255;
  const Photo half = resample_photo(photo, 0.5);  // column 8 is 4.0-4.5 m: the invalid 0.2 of it are 40 %
  EXPECT_EQ(half.valid.at(7, 10), 0);
  EXPECT_EQ(half.rgb.at(7, 10, 1), no_photo_value);
  EXPECT_EQ(half.valid.at(8, 10), 1);
  EXPECT_EQ(half.rgb.at(8, 10, 1), 100);
}

/// A network that sees the map, with random weights where the map and the alignment come in.
SegmentModel model_that_sees_the_map() {
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2-map", 8);
  TensorFile file = start_weights(graph, {}, 3).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)
    if (name.starts_with("head") || name.starts_with("align_out") || name.starts_with("classes_out"))
      for (float& v : tensor.values) v = static_cast<float>(0.1 * random.normal());
  file.metadata = format_model_metadata({graph.architecture, default_class_table(), 0.5, 0.4});
  return load_model(file, "random");
}

TEST(SegmentMosaic, alignments_do_not_depend_on_windows_or_threads) {
  const Photo photo = painted_photo(300, 200, 0.5);
  const SegmentModel model = model_that_sees_the_map();
  const Polyline line{{500000.0, 6399940.0}, {500070.0, 6399930.0}, {500150.0, 6399945.0}};
  const MapLines map({{line, 4.0}});
  std::vector<Vec2> places;
  for (const double s : places_along(length_m(line))) places.push_back(point_at(line, s));
  places.push_back({500300.0, 6399940.0});  // beside the photo
  const auto run = [&](int window_px, int threads, const MapLines* seen) {
    return segment_mosaic(source_of(photo), model, [](const PixelBox&, const LabelledPixels&) {},
                          {.window_px = window_px, .threads = threads, .map = seen, .places = places})
        .alignments;
  };
  const MapLines elsewhere({{{{500000.0, 6399900.0}, {500150.0, 6399890.0}}, 4.0}});
  const auto one = run(1 << 20, 1, &map), many = run(61, 2, &map), other = run(1 << 20, 1, &elsewhere);
  ASSERT_EQ(one.size(), places.size());
  EXPECT_TRUE(run(1 << 20, 1, nullptr).empty());
  double changed_m = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_NEAR(one[i].displacement_m.x, many[i].displacement_m.x, 0.0011) << i;
    EXPECT_NEAR(one[i].displacement_m.y, many[i].displacement_m.y, 0.0011) << i;
    EXPECT_NEAR(one[i].half_width_m, many[i].half_width_m, 0.0011) << i;
    changed_m = std::max(changed_m, length(one[i].displacement_m - other[i].displacement_m));
  }
  EXPECT_GT(changed_m, 0.01);  // the map is seen
  EXPECT_GT(one.front().sigma_m, 0.0);
  EXPECT_EQ(one.back().sigma_m, 0.0);  // no photo, nothing said
}

/// The map adds to the classes near its roads; an empty one is no map, and labels are then those of the network without
/// the branch that reads it.
TEST(SegmentMosaic, labels_see_the_map_and_without_one_are_those_of_the_network_without_it) {
  const Photo photo = painted_photo(300, 200, 0.5);
  const SegmentModel model = model_that_sees_the_map();
  SegmentModel plain = model;
  plain.network = model.without_map, plain.sees_map = false;
  const MapLines map({{{{500000.0, 6399990.0}, {500150.0, 6399985.0}}, 4.0}}), empty;
  const auto probabilities = [&](const SegmentModel& of, const MapLines* seen, int window_px) {
    return segment_mosaic(photo, of, {.window_px = window_px, .map = seen}).road_probability.confidence.data;
  };
  const auto without = probabilities(plain, nullptr, 1 << 20);
  EXPECT_EQ(probabilities(model, nullptr, 1 << 20), without);
  EXPECT_EQ(probabilities(model, &empty, 1 << 20), without);
  const auto with = probabilities(model, &map, 1 << 20), in_windows = probabilities(model, &map, 61);
  EXPECT_NE(with, without);
  for (std::size_t i = 0; i < with.size(); ++i) ASSERT_NEAR(with[i], in_windows[i], 1) << i;
}

TEST(SegmentMosaic, a_model_without_a_map_tells_no_alignments) {
  const Photo photo = painted_photo(100, 60, 0.5);
  const std::vector<Vec2> places{{500010.0, 6399980.0}};
  const SegmentSummary summary = segment_mosaic(source_of(photo), shipped_model(),
                                                [](const PixelBox&, const LabelledPixels&) {}, {.places = places});
  EXPECT_TRUE(summary.alignments.empty());
}

}  // namespace
}  // namespace orthodrive

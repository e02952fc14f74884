// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/adapt_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "nets/shipped_model.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/io/models/safetensors.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/net_surgery.hpp"
#include "orthodrive/segment/segment_mosaic.hpp"

namespace orthodrive {
namespace {

constexpr int town_px = 480, street_label = 1;
constexpr ClassSet anything_but_road = 0xff & ~only(street_label);

/// To the nearest of some winding streets, in pixels.
double to_street_px(double x, double y) {
  double least = 1e9;
  for (const double at : {40.0, 121.0, 215.0, 290.0, 401.0}) {
    const double across = at + 14.0 * std::sin(y / 47.0 + at), down = at + 11.0 * std::sin(x / 61.0 + 2.0 * at);
    least = std::min({least, std::abs(x - across), std::abs(y - down)});
  }
  return least;
}
bool is_street(double x, double y) { return to_street_px(x, y) < 6.0; }

/// Green streets through purple fields: as no place looks that the network has seen.
Photo strange_town() {
  Photo photo{Crs{"EPSG:32633"},
              {460000.0, 5270000.0, 0.5, town_px, town_px},
              Raster<std::uint8_t>(town_px, town_px, 3),
              Raster<std::uint8_t>(town_px, town_px, 1, 1)};
  Random random(3);
  for (int row = 0; row < town_px; ++row)
    for (int col = 0; col < town_px; ++col) {
      const bool street = is_street(col + 0.5, row + 0.5);
      const double rgb[] = {street ? 70.0 : 170.0, street ? 190.0 : 60.0, street ? 90.0 : 150.0};
      for (int c = 0; c < 3; ++c)
        photo.rgb.at(col, row, c) = static_cast<std::uint8_t>(rgb[c] + 20.0 * random.uniform());
    }
  return photo;
}

/// What a map of the town says that lies some pixels beside it. Nothing is said near the edges of streets.
WeakLabels map_of_town(const Photo& photo, double east_px = 0.0, double south_px = 0.0) {
  const GridFrame whole = photo.frame;
  return [=](const GridFrame& frame, MapEdges edges) {
    Raster<ClassSet> allowed(frame.width, frame.height, 1, unknown_class);
    for (int row = 0; row < frame.height; ++row)
      for (int col = 0; col < frame.width; ++col) {
        const Vec2 p = whole.pixel_from_world(frame.center_of(col, row));
        const double d = to_street_px(p.x - east_px, p.y - south_px);
        const double band = edges == MapEdges::sharp ? 0.0 : 3.0;
        if (d < 6.0 - band) allowed.at(col, row) = only(street_label);
        if (d >= 6.0 + band) allowed.at(col, row) = anything_but_road;
      }
    return allowed;
  };
}

/// Its streets, some pixels beside where they are.
std::vector<RoadLine> streets_of_town(const Photo& photo, double east_px, double south_px) {
  std::vector<RoadLine> lines;
  for (const double at : {40.0, 121.0, 215.0, 290.0, 401.0}) {
    RoadLine &across = lines.emplace_back(RoadLine{{}, 3.0}), down{{}, 3.0};
    for (double t = 0.0; t <= town_px; t += 8.0) {
      const double x = at + 14.0 * std::sin(t / 47.0 + at), y = at + 11.0 * std::sin(t / 61.0 + 2.0 * at);
      across.points.push_back(photo.frame.world_from_pixel(x + east_px, t + south_px));
      down.points.push_back(photo.frame.world_from_pixel(t + east_px, y + south_px));
    }
    lines.push_back(std::move(down));
  }
  return lines;
}

AdaptOptions small_options() {
  return {.cell_px = 96, .most_cells = 25, .steps = 60, .batch = 2, .learning_rate = 3e-3, .threads = 2};
}

double true_road_iou(const Photo& photo, const TensorFile& model, const MapLines* map = nullptr) {
  const SegmentResult result = segment_mosaic(photo, load_model(model, "model"), {.threads = 2, .map = map});
  double both = 0, either = 0;
  for (int row = 0; row < town_px; ++row)
    for (int col = 0; col < town_px; ++col) {
      const bool is = is_street(col + 0.5, row + 0.5), said = result.labels.labels.at(col, row) == street_label;
      both += is && said, either += is || said;
    }
  return both / either;
}

TEST(AdaptModel, learns_the_streets_of_a_place_as_it_has_never_seen_one) {
  const Photo photo = strange_town();
  const AdaptedModel adapted =
      adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo), {}, small_options());
  EXPECT_TRUE(adapted.report.kept) << adapted.report.why_not;
  EXPECT_EQ(adapted.report.learned_cells, 20);
  EXPECT_EQ(adapted.report.held_back_cells, 5);
  EXPECT_LT(adapted.report.before.kappa, 0.5);
  EXPECT_GT(adapted.report.after.kappa, 0.8);
  const double before = true_road_iou(photo, shipped_tensors()), after = true_road_iou(photo, adapted.file);
  EXPECT_GT(after, 0.75) << "also at the edges, of which the map says nothing";
  EXPECT_GT(after, before + 0.2);
  EXPECT_EQ(adapted.file.metadata, shipped_tensors().metadata);
  EXPECT_EQ(adapted.file.tensors.at("Conv1/kernel").values, shipped_tensors().tensors.at("Conv1/kernel").values)
      << "the trunk's weights stay";
  EXPECT_EQ(adapted.file.tensors.at("align_out/kernel").values, shipped_tensors().tensors.at("align_out/kernel").values)
      << "and the branch's for the map";
}

TEST(AdaptModel, has_the_same_bytes_with_any_number_of_threads) {
  const Photo photo = strange_town();
  AdaptOptions options = small_options();
  options.steps = 4, options.least_gain = -2.0, options.least_kappa = -2.0;
  const auto bytes = [&](int threads) {
    options.threads = threads;
    const AdaptedModel adapted =
        adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo), {}, options);
    EXPECT_TRUE(adapted.report.kept);
    return format_safetensors(adapted.file);
  };
  const std::string one = bytes(1);
  EXPECT_TRUE(bytes(3) == one);
  EXPECT_FALSE(one == format_safetensors(shipped_tensors()));
}

TEST(AdaptModel, is_dropped_where_the_map_lies_wrong) {
  const Photo photo = strange_town();
  const AdaptedModel adapted =
      adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo, 57.0, 38.0), {}, small_options());
  EXPECT_FALSE(adapted.report.kept);
  EXPECT_THAT(adapted.report.why_not, testing::HasSubstr("is it the map of this place?"));
  EXPECT_TRUE(format_safetensors(adapted.file) == format_safetensors(shipped_tensors()));
}

// What is used sees the map: that is what learns and what is judged.
TEST(AdaptModel, learns_beside_a_map_without_copying_it) {
  const Photo photo = strange_town();
  const MapLines map(streets_of_town(photo, 2.0, -2.0));
  const AdaptedModel adapted =
      adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo, 2.0, -2.0), map, small_options());
  EXPECT_TRUE(adapted.report.kept) << adapted.report.why_not;
  EXPECT_GT(adapted.report.alone.kappa, 0.6);
  const double before = true_road_iou(photo, shipped_tensors(), &map), after = true_road_iou(photo, adapted.file, &map);
  EXPECT_GT(after, before + 0.1) << "before " << before;
  EXPECT_GT(after, 0.6);
  EXPECT_EQ(adapted.file.tensors.at("align_out/kernel").values, shipped_tensors().tensors.at("align_out/kernel").values)
      << "the branch for the map stays";
}

TEST(AdaptModel, is_dropped_where_only_the_map_that_it_sees_agrees_with_the_map) {
  const Photo photo = strange_town();
  const AdaptedModel adapted =
      adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo, 57.0, 38.0),
                  MapLines(streets_of_town(photo, 57.0, 38.0)), small_options());
  EXPECT_FALSE(adapted.report.kept) << adapted.report.alone.kappa;
}

TEST(AdaptModel, is_dropped_where_nothing_is_gained) {
  const Photo photo = strange_town();
  AdaptOptions options = small_options();
  options.steps = 1, options.learning_rate = 0.0, options.least_kappa = -2.0;
  const AdaptedModel adapted =
      adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo), {}, options);
  EXPECT_EQ(adapted.report.before.kappa, adapted.report.after.kappa);
  options.least_gain = 1.0;
  const AdaptedModel asked_for_more =
      adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo), {}, options);
  EXPECT_FALSE(asked_for_more.report.kept);
  EXPECT_THAT(asked_for_more.report.why_not, testing::HasSubstr("no gain on the cells held back"));
}

TEST(AdaptModel, says_when_there_is_too_little_to_learn_from) {
  const Photo photo = strange_town();
  AdaptOptions options = small_options();
  options.cell_px = 224;  // four of them
  const AdaptedModel few = adapt_model(shipped_tensors(), "default", source_of(photo), map_of_town(photo), {}, options);
  EXPECT_FALSE(few.report.kept);
  EXPECT_THAT(few.report.why_not, testing::StartsWith("3 cells with roads to learn from and 1 to judge by"));
  const WeakLabels empty_map = [](const GridFrame& frame, MapEdges) {
    return Raster<ClassSet>(frame.width, frame.height, 1, anything_but_road);
  };
  const AdaptedModel none = adapt_model(shipped_tensors(), "default", source_of(photo), empty_map, {}, small_options());
  EXPECT_FALSE(none.report.kept);
  EXPECT_THAT(none.report.why_not, testing::StartsWith("0 cells with roads"));
}

TEST(AdaptModel, refuses_networks_that_it_cannot_adapt) {
  SegmentModel model = shipped_model();
  model.name = "vgg16-8s";
  EXPECT_THAT([&] { require_adaptable(model, "vgg"); },
              testing::ThrowsMessage<OptionError>(testing::HasSubstr("only mobilenetv2 models adapt")));
}

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/fcn.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nets/shipped_model.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/map_alignment.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/net_surgery.hpp"
#include "orthodrive/nets/padded_parts.hpp"

namespace orthodrive {
namespace {

std::vector<std::uint8_t> random_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * width * height));
  for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(255.0 * random.uniform());
  return rgb;
}

std::vector<std::uint8_t> random_map(int width, int height, std::uint64_t seed) {
  std::vector<std::uint8_t> map = random_image(width, height, seed);
  map.resize(static_cast<std::size_t>(map_raster_channels * width * height), 7);
  return map;
}

NetworkParams random_params(const NetworkGraph& graph) {
  TensorFile file = start_weights(graph, {}, 3).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)  // scores start at zero: give them something to say
    if (name.starts_with("score") || name.starts_with("head") || name.starts_with("align_out"))
      for (float& v : tensor.values) v = static_cast<float>(0.05 * random.normal());
  return params_from_file(graph, file, "random");
}

/// Padded at a border far away, a window without any padding sees the same: GoogLeNet has every kind of layer.
TEST(Forward, without_padding_equals_the_inside_of_a_padded_image) {
  for (const char* name :
       {"googlenet-8s", "mobilenetv2-s16-fpn2", "mobilenetv2-s32-fpn2", "mobilenetv2-s32-fpn2-map"}) {
    const NetworkGraph graph = make_network(name, 4);
    NetworkParams params = random_params(graph);
    const int margin = receptive_field(graph).margin_px(),
              size = 32 * ((2 * margin + 64) / 32 + 1) + graph.size_remainder;
    const std::vector<std::uint8_t> rgb = random_image(size, size, 1);
    const std::vector<std::uint8_t> map = random_map(size, size, 2);
    const InputTensors image = input_tensors(graph, {rgb.data(), map.data()}, 1, size, size);
    const at::NoGradGuard no_grad;
    const Scores padded = forward_padded(graph, params, image, {});
    const CellRange rows{margin + 3, margin + 40}, cols{margin + 8, margin + 21};
    const at::Tensor exact = forward_exact(graph, params, image, {{0, size - 1}, {0, size - 1}, rows, cols});
    const at::Tensor expected = padded.values.narrow(2, rows.first - padded.row_px.first, rows.size())
                                    .narrow(3, cols.first - padded.col_px.first, cols.size());
    EXPECT_LT((exact - expected).abs().max().item<double>(), 1e-4 * expected.abs().max().item<double>()) << name;
    EXPECT_GT(expected.std().item<double>(), 0.0) << name;
  }
}

TEST(Forward, in_two_parts_is_the_whole_and_gives_back_what_later_layers_do_not_read) {
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 4);
  NetworkParams params = random_params(graph);
  const std::vector<std::uint8_t> rgb = random_image(96, 96, 1);
  const InputTensors image = input_tensors(graph, {rgb.data()}, 1, 96, 96);
  const at::NoGradGuard no_grad;
  const Scores whole = forward_padded(graph, params, image, {});
  const auto context = std::find_if(graph.layers.begin(), graph.layers.end(),
                                    [](const Layer& layer) { return layer.name == "context_32_depthwise"; });
  const auto first = static_cast<std::size_t>(context - graph.layers.begin());
  const std::vector<at::Tensor> before = forward_padded_before(graph, params, image, first);
  EXPECT_EQ(std::count_if(before.begin(), before.end(), [](const at::Tensor& t) { return t.defined(); }), 5)
      << "the last features of strides 2, 4, 8, 16, 32";
  const Scores parts = forward_padded_from(graph, params, before, first, 96);
  EXPECT_TRUE(at::equal(parts.values, whole.values));
  EXPECT_EQ(parts.row_px, whole.row_px);
}

TEST(InferenceNetwork, a_core_is_the_same_wherever_it_is_cut_from) {
  const NetworkGraph graph = make_network("googlenet-8s", 4);
  const InferenceNetwork network(graph, random_params(graph));
  const int margin = network.margin_px();
  const auto part = [&](std::int64_t col, std::int64_t row, int width, int height) {
    std::vector<std::uint8_t> rgb;  // a mosaic without end: every pixel from its own seed
    for (std::int64_t y = row - margin; y < row + height + margin; ++y)
      for (std::int64_t x = col - margin; x < col + width + margin; ++x)
        for (int c = 0; c < 3; ++c)
          rgb.push_back(static_cast<std::uint8_t>(
              derive_seed(derive_seed(static_cast<std::uint64_t>(y + 10000), static_cast<std::uint64_t>(x + 10000)),
                          static_cast<std::uint64_t>(c)) >>
              56));
    std::vector<float> scores(static_cast<std::size_t>(width * height * 4));
    network.predict({.rgb = rgb.data()}, {col, row, width, height}, 1, scores.data());
    return scores;
  };
  const std::vector<float> whole = part(-5, 100001, 40, 30), inner = part(12, 100010, 9, 7);
  double largest = 0.0, magnitude = 0.0;
  for (const float score : whole) magnitude = std::max(magnitude, std::abs(static_cast<double>(score)));
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x)
      for (int c = 0; c < 4; ++c)
        largest = std::max(
            largest, std::abs(static_cast<double>(whole[static_cast<std::size_t>(((y + 9) * 40 + x + 17) * 4 + c)]) -
                              inner[static_cast<std::size_t>((y * 9 + x) * 4 + c)]));
  // Sums of single precision: their order differs between the kernels that processors have.
  EXPECT_LT(largest, 1e-6 * magnitude) << magnitude;
}

/// Pixels beyond the margin change nothing, those within it do.
TEST(InferenceNetwork, shipped_model_sees_as_far_as_its_margin) {
  const TensorFile file = shipped_tensors();
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 8);
  const InferenceNetwork network(graph, params_from_file(graph, file, "default"));
  const int margin = network.margin_px(), size = 16 + 2 * margin;
  const PixelBox core{1600, 3200, 16, 16};
  std::vector<std::uint8_t> rgb = random_image(size, size, 2);
  const auto predict = [&] {
    std::vector<float> p(16 * 16 * 8);
    network.predict({.rgb = rgb.data()}, core, 1, p.data());
    return p;
  };
  const std::vector<float> before = predict();
  const auto disturb = [&](int ring) {  // the square ring that far outside the core
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const int outside = std::max({margin - x, margin - y, x - margin - 15, y - margin - 15});
        if (outside == ring)
          for (int c = 0; c < 3; ++c) rgb[static_cast<std::size_t>(3 * (y * size + x) + c)] ^= 0xFF;
      }
  };
  for (int ring = 40; ring <= 60; ++ring) disturb(ring);
  EXPECT_NE(predict(), before);
}

/// At twice the resolution a network of either kind gives its scores in between.
TEST(InferenceNetwork, finer_scores_are_interpolated) {
  for (const char* name : {"googlenet-8s", "mobilenetv2-s16-fpn2", "mobilenetv2-s32-fpn2"}) {
    const NetworkGraph graph = make_network(name, 4);
    const InferenceNetwork network(graph, random_params(graph));
    const int margin = network.margin_px(), rows = 7, cols = 12;
    const PixelBox core{33, 18, cols, rows}, around = core.grown(1);
    const int width = cols + 2 + 2 * margin, height = rows + 2 + 2 * margin;
    const std::vector<std::uint8_t> rgb = random_image(width, height, 5);
    std::vector<std::uint8_t> inner;
    for (int y = 1; y < height - 1; ++y)
      inner.insert(inner.end(), rgb.begin() + 3 * (y * width + 1), rgb.begin() + 3 * ((y + 1) * width - 1));
    std::vector<float> coarse(static_cast<std::size_t>(around.width * around.height * 4)),
        fine(static_cast<std::size_t>(4 * rows * cols * 4));
    network.predict({.rgb = rgb.data()}, around, 1, coarse.data());
    network.predict({.rgb = inner.data()}, core, 2, fine.data());
    double mean = 0.0;  // four fine pixels around a coarse one average to nearly it, whatever is interpolated
    for (int y = 0; y < 2 * rows; ++y)
      for (int x = 0; x < 2 * cols; ++x)
        for (int c = 0; c < 4; ++c) {
          const auto at = [&](int row, int col) {
            return coarse[static_cast<std::size_t>((row * around.width + col) * 4 + c)];
          };
          const int row = (y + 1) / 2, col = (x + 1) / 2;  // the coarse pixel before, with the ring
          const float vertical = y % 2 == 0 ? 0.75F : 0.25F, horizontal = x % 2 == 0 ? 0.75F : 0.25F;
          const float upper = at(row, col) + horizontal * (at(row, col + 1) - at(row, col)),
                      lower = at(row + 1, col) + horizontal * (at(row + 1, col + 1) - at(row + 1, col));
          const float difference =
              fine[static_cast<std::size_t>((y * 2 * cols + x) * 4 + c)] - (upper + vertical * (lower - upper));
          if (std::string(name) == "googlenet-8s") {
            EXPECT_NEAR(difference, 0.0, 1e-4);
          }
          mean += std::abs(difference);
        }
    float largest = 0.0F;
    for (const float v : coarse) largest = std::max(largest, std::abs(v));
    EXPECT_LT(mean / static_cast<double>(fine.size()), 0.05 * largest) << name;
  }
}

/// A network that sees a map begins as the one whose weights it takes: whatever the map shows, the class scores are
/// those.
TEST(InferenceNetwork, with_a_map_begins_as_the_one_without) {
  const NetworkGraph plain = make_network("mobilenetv2-s32-fpn2", 4),
                     mapped = make_network("mobilenetv2-s32-fpn2-map", 4);
  const NetworkParams params = random_params(plain);
  const WeightsSource source{"plain", file_from_params(plain, params, TensorType::f32)};
  const TensorFile start = start_weights(mapped, {&source, 1}, 5).file;  // it says nothing about the map yet
  const InferenceNetwork first(plain, params), second(mapped, params_from_file(mapped, start, "start"));
  const int margin = second.margin_px();
  ASSERT_GE(margin, first.margin_px());
  const PixelBox core{64, 32, 40, 24}, seen = core.grown(margin - first.margin_px());  // what the first decides of it
  const int width = core.width + 2 * margin, height = core.height + 2 * margin;
  const std::vector<std::uint8_t> rgb = random_image(width, height, 6), map = random_map(width, height, 7);
  std::vector<float> a(static_cast<std::size_t>(seen.width * seen.height * first.output_channels())),
      b(static_cast<std::size_t>(core.width * core.height * second.output_channels())), c(b.size());
  first.predict({.rgb = rgb.data()}, seen, 1, a.data());
  second.predict({rgb.data(), map.data()}, core, 1, b.data());
  second.predict({.rgb = rgb.data()}, core, 1, c.data());
  EXPECT_EQ(second.output_channels(), 4 + alignment_channels);
  for (std::size_t i = 0; i < static_cast<std::size_t>(core.width * core.height); ++i) {
    const auto width = static_cast<std::size_t>(core.width), more = static_cast<std::size_t>(core.col - seen.col);
    const std::size_t same = (i / width + more) * static_cast<std::size_t>(seen.width) + i % width + more;
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(b[(4 + alignment_channels) * i + k], a[4 * same + k], 1e-4);
      EXPECT_NEAR(c[(4 + alignment_channels) * i + k], a[4 * same + k], 1e-4);
    }
    for (std::size_t k = 4; k < 4 + alignment_channels; ++k) EXPECT_EQ(c[(4 + alignment_channels) * i + k], 0.0F);
  }
}

}  // namespace
}  // namespace orthodrive

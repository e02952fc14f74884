// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/inference_network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nets/random_network.hpp"
#include "nets/shipped_model.hpp"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/net_surgery.hpp"

namespace orthodrive {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

InferenceNetwork network_of(const NetworkGraph& graph, const TensorFile& file, LayerFusion fusion = LayerFusion::all) {
  return {graph, fold_batch_norm(graph, file, "random"), fusion};
}

TEST(InferenceNetwork, a_core_is_the_same_wherever_it_is_cut_from) {
  const NetworkGraph graph = make_network("googlenet-8s", 4);
  const InferenceNetwork network = network_of(graph, random_weights(graph));
  const int margin = network.margin_px();
  CellMemory memory;
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
    network.predict({.rgb = rgb.data()}, {col, row, width, height}, 1, scores.data(), memory);
    return scores;
  };
  const std::vector<float> whole = part(-5, 100001, 40, 30), inner = part(12, 100010, 9, 7);
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x)
      for (int c = 0; c < 4; ++c)
        ASSERT_EQ(whole[static_cast<std::size_t>(((y + 9) * 40 + x + 17) * 4 + c)],
                  inner[static_cast<std::size_t>((y * 9 + x) * 4 + c)]);
}

/// Pixels beyond the margin change nothing, those within it do.
TEST(InferenceNetwork, shipped_model_sees_as_far_as_its_margin) {
  const TensorFile file = shipped_tensors();
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 8);
  const InferenceNetwork network = network_of(graph, file);
  const int margin = network.margin_px(), size = 16 + 2 * margin;
  const PixelBox core{1600, 3200, 16, 16};
  CellMemory memory;
  std::vector<std::uint8_t> rgb = random_image(size, size, 2);
  const auto predict = [&] {
    std::vector<float> p(16 * 16 * 8);
    network.predict({.rgb = rgb.data()}, core, 1, p.data(), memory);
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
    const InferenceNetwork network = network_of(graph, random_weights(graph));
    const int margin = network.margin_px(), rows = 7, cols = 12;
    const PixelBox core{33, 18, cols, rows}, around = core.grown(1);
    const int width = cols + 2 + 2 * margin, height = rows + 2 + 2 * margin;
    const std::vector<std::uint8_t> rgb = random_image(width, height, 5);
    std::vector<std::uint8_t> inner;
    for (int y = 1; y < height - 1; ++y)
      inner.insert(inner.end(), rgb.begin() + 3 * (y * width + 1), rgb.begin() + 3 * ((y + 1) * width - 1));
    std::vector<float> coarse(static_cast<std::size_t>(around.width * around.height * 4)),
        fine(static_cast<std::size_t>(4 * rows * cols * 4));
    CellMemory memory;
    network.predict({.rgb = rgb.data()}, around, 1, coarse.data(), memory);
    network.predict({.rgb = inner.data()}, core, 2, fine.data(), memory);
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
  const WeightsSource source{"plain", random_weights(plain)};
  const TensorFile start = start_weights(mapped, {&source, 1}, 5).file;  // it says nothing about the map yet
  const InferenceNetwork first = network_of(plain, source.file), second = network_of(mapped, start);
  const int margin = second.margin_px();
  ASSERT_GE(margin, first.margin_px());
  const PixelBox core{64, 32, 40, 24}, seen = core.grown(margin - first.margin_px());  // what the first decides of it
  const int width = core.width + 2 * margin, height = core.height + 2 * margin;
  const std::vector<std::uint8_t> rgb = random_image(width, height, 6), map = random_map(width, height, 7);
  std::vector<float> a(static_cast<std::size_t>(seen.width * seen.height * first.output_channels())),
      b(static_cast<std::size_t>(core.width * core.height * second.output_channels())), c(b.size());
  CellMemory memory;
  first.predict({.rgb = rgb.data()}, seen, 1, a.data(), memory);
  second.predict({rgb.data(), map.data()}, core, 1, b.data(), memory);
  second.predict({.rgb = rgb.data()}, core, 1, c.data(), memory);
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

/// With layers of widths that are no whole vectors, too.
TEST(InferenceNetwork, fused_layers_give_what_the_layers_give_one_by_one) {
  for (const char* name : {"mobilenetv2-s16-fpn2", "mobilenetv2-s32-fpn2-map"}) {
    const NetworkGraph graph = make_network(name, 5);
    const TensorFile file = random_weights(graph);
    const InferenceNetwork fused = network_of(graph, file), single = network_of(graph, file, LayerFusion::none);
    const int margin = fused.margin_px();
    for (const PixelBox& core : {PixelBox{0, 0, 300, 37}, PixelBox{11, 5, 1, 1}, PixelBox{3, 14, 18, 290}}) {
      const int width = core.width + 2 * margin, height = core.height + 2 * margin;
      const std::vector<std::uint8_t> rgb = random_image(width, height, 1), map = random_map(width, height, 2);
      const NetworkInput input{rgb.data(), map.data()};
      std::vector<float> a(static_cast<std::size_t>(core.width * core.height * fused.output_channels())), b(a.size());
      CellMemory memory;
      fused.predict(input, core, 1, a.data(), memory);
      single.predict(input, core, 1, b.data(), memory);
      float largest = 0.0F, difference = 0.0F;
      for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, std::abs(a[i]));
        difference = std::max(difference, std::abs(a[i] - b[i]));
      }
      EXPECT_LT(difference, 2e-5F * largest) << name;
      EXPECT_GT(largest, 0.1F) << name;
    }
  }
}

TEST(InferenceNetwork, refuses_weights_of_another_network) {
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 4);
  TensorFile file = random_weights(graph);
  EXPECT_THAT([&] { (void)fold_batch_norm(make_network("mobilenetv2-s32-fpn2", 5), file, "four.safetensors"); },
              ThrowsMessage<InputError>(HasSubstr("four.safetensors: tensor 'head/kernel' has shape")));
  file.tensors.erase("bn_Conv1/gamma");
  EXPECT_THAT([&] { (void)fold_batch_norm(graph, file, "cut.safetensors"); },
              ThrowsMessage<InputError>(HasSubstr("cut.safetensors: tensor 'bn_Conv1/gamma' is missing")));
}

}  // namespace
}  // namespace orthodrive

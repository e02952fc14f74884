// SPDX-License-Identifier: Apache-2.0
// libtorch is the peer of our own prediction: both run the same weights.
#include "orthodrive/train/padded_network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "nets/random_network.hpp"
#include "orthodrive/train/padded_parts.hpp"

namespace orthodrive {
namespace {

/// Padded at a border far away, a window without any padding sees the same: GoogLeNet has every kind of layer.
TEST(PaddedNetwork, gives_inside_of_an_image_what_prediction_gives) {
  for (const char* name :
       {"googlenet-8s", "googlenet-32s", "mobilenetv2-s16-fpn2", "mobilenetv2-s32-fpn2", "mobilenetv2-s32-fpn2-map"}) {
    const NetworkGraph graph = make_network(name, 4);
    const TensorFile file = random_weights(graph);
    NetworkParams params = params_from_file(graph, file, "random");
    const InferenceNetwork network(graph, fold_batch_norm(graph, file, "random"));
    const int margin = network.margin_px(), size = 32 * ((2 * margin + 64) / 32 + 1) + graph.size_remainder;
    const std::vector<std::uint8_t> rgb = random_image(size, size, 1), map = random_map(size, size, 2);
    const at::NoGradGuard no_grad;
    const Scores padded =
        forward_padded(graph, params, input_tensors(graph, {rgb.data(), map.data()}, 1, size, size), {});
    // The core begins where the image's own margin ends.
    const int width = size - 2 * margin, height = size - 2 * margin, channels = graph.output_channels();
    std::vector<float> scores(static_cast<std::size_t>(width * height * channels));
    CellMemory memory;
    network.predict({rgb.data(), map.data()}, {margin, margin, width, height}, 1, scores.data(), memory);
    const at::Tensor expected = padded.values[0]
                                    .narrow(1, margin - padded.row_px.first, height)
                                    .narrow(2, margin - padded.col_px.first, width)
                                    .permute({1, 2, 0})
                                    .contiguous();
    const at::Tensor exact = at::from_blob(scores.data(), {height, width, channels}, at::kFloat);
    EXPECT_LT((exact - expected).abs().max().item<double>(), 1e-4 * expected.abs().max().item<double>()) << name;
    EXPECT_GT(expected.std().item<double>(), 0.0) << name;
  }
}

TEST(PaddedNetwork, in_two_parts_is_the_whole_and_gives_back_what_later_layers_do_not_read) {
  const NetworkGraph graph = make_network("mobilenetv2-s32-fpn2", 4);
  NetworkParams params = params_from_file(graph, random_weights(graph), "random");
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

}  // namespace
}  // namespace orthodrive

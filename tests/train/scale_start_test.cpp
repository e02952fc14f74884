// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/scale_start.hpp"

#include <gtest/gtest.h>

#include "nets/random_network.hpp"
#include "orthodrive/train/padded_parts.hpp"

namespace orthodrive {
namespace {

double mean_square(const at::Tensor& values) { return values.square().mean().item<double>(); }

TEST(ScaleStart, every_feature_of_random_layers_has_unit_size_and_scores_stay_zero) {
  const NetworkGraph graph = make_network("googlenet-8s", 4);
  NetworkParams params = params_from_file(graph, start_weights(graph, {}, 1).file, "random");
  const int size = 96 + graph.size_remainder;
  const std::vector<std::uint8_t> rgb = random_image(size, size, 2);
  const InputTensors input = input_tensors(graph, {rgb.data()}, 1, size, size);
  const at::NoGradGuard no_grad;
  EXPECT_GT(mean_square(forward_padded_before(graph, params, input, 1)[0]), 1000.0) << "bytes as they are";
  scale_to_unit_output(graph, params, input);
  int layers = 0;
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    if (graph.layers[i].kind != LayerKind::convolution || graph.layers[i].score) continue;
    EXPECT_NEAR(mean_square(forward_padded_before(graph, params, input, i + 1)[i]), 1.0, 1e-3) << graph.layers[i].name;
    ++layers;
  }
  EXPECT_EQ(layers, 57);
  EXPECT_EQ(mean_square(forward_padded(graph, params, input, {}).values), 0.0);
}

TEST(ScaleStart, weights_taken_from_elsewhere_compute_the_same_but_for_a_factor) {
  NetworkGraph graph = make_network("vgg16-32s", 4);
  while (graph.layers.back().name != "conv3_3") graph.layers.pop_back();
  TensorFile file = random_weights(graph);
  for (auto& [name, tensor] : file.tensors)
    if (name.ends_with("bias"))
      for (float& v : tensor.values) v *= 100.0F;  // biases that matter beside bytes
  NetworkParams params = params_from_file(graph, file, "random");
  const std::vector<std::uint8_t> rgb = random_image(66, 66, 2), other = random_image(66, 66, 5);
  const at::NoGradGuard no_grad;
  const InputTensors seen = input_tensors(graph, {rgb.data()}, 1, 66, 66);
  const InputTensors unseen = input_tensors(graph, {other.data()}, 1, 66, 66);
  const at::Tensor before = forward_padded_before(graph, params, unseen, graph.layers.size()).back();
  scale_to_unit_output(graph, params, seen);
  const at::Tensor after = forward_padded_before(graph, params, unseen, graph.layers.size()).back();
  const double factor = after.max().item<double>() / before.max().item<double>();
  EXPECT_LT(factor, 0.1);
  EXPECT_LT((after - factor * before).abs().max().item<double>(), 1e-4 * after.max().item<double>());
}

}  // namespace
}  // namespace orthodrive

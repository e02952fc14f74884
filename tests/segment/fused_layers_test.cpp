#include "orthodrive/segment/fused_layers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/segment/make_network.hpp"
#include "orthodrive/segment/net_surgery.hpp"

namespace orthodrive {
namespace {

std::vector<float> random_values(std::size_t count, Random& random) {
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.normal());
  return values;
}

struct Folded {
  NetworkGraph graph;
  NetworkParams params;
};
Folded folded_network(int seed) {
  NetworkGraph graph = make_network("mobilenetv2-s16-fpn2", 5);
  TensorFile file = start_weights(graph, {}, static_cast<std::uint64_t>(seed)).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)  // batch norms and scores start as nothing
    if (name.ends_with("/bias") || name.ends_with("/beta") || name.ends_with("/moving_mean") || name.starts_with("head"))
      for (float& v : tensor.values) v = static_cast<float>(0.2 * random.normal());
  NetworkParams params = fold_batch_norm(graph, params_from_file(graph, file, "random"));
  return {std::move(graph), std::move(params)};
}

TEST(FusedLayers, give_what_the_layers_give_one_by_one) {
  Folded net = folded_network(3);
  const FusionPlan plan = fuse_layers(net.graph, net.params);
  const int margin = receptive_field(net.graph).margin_px();
  Random random(1);
  for (const auto& [row, col, height, width] : {std::array{0, 0, 37, 300}, std::array{5, 11, 1, 1}, std::array{14, 3, 290, 18}}) {
    const int rows = height + 2 * margin, cols = width + 2 * margin;
    std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * rows * cols));
    for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(255.0 * random.uniform());
    const at::Tensor image = image_tensor(net.graph.input, rgb.data(), 1, cols, rows);
    const ExactWindow window{{row - margin, row + height - 1 + margin}, {col - margin, col + width - 1 + margin},
                             {row, row + height - 1}, {col, col + width - 1}};
    const at::NoGradGuard no_grad;
    const at::Tensor one_by_one = forward_exact(net.graph, net.params, image, window),
                     fused = forward_exact(net.graph, net.params, image, window, &plan);
    EXPECT_LT((one_by_one - fused).abs().max().item<double>(), 2e-5 * one_by_one.abs().max().item<double>());
    EXPECT_GT(one_by_one.abs().max().item<double>(), 0.1);
  }
}

TEST(FusedLayers, cover_all_of_the_default_network_but_its_scores) {
  const Folded net = folded_network(3);
  const FusionPlan plan = fuse_layers(net.graph, net.params);
  for (std::size_t i = 0; i < net.graph.layers.size(); ++i) {
    const bool score = net.graph.layers[i].name == "head" || net.graph.layers[i].score;
    EXPECT_EQ(plan.step[i] == FusionPlan::plain, score) << net.graph.layers[i].name;
  }
}

TEST(FusedLayers, do_not_touch_networks_without_depthwise_layers) {
  for (const char* name : {"vgg16-8s", "googlenet-8s"}) {
    const NetworkGraph graph = make_network(name, 2);
    NetworkParams params(graph.layers.size());
    EXPECT_TRUE(fuse_layers(graph, params).fused.empty()) << name;
  }
}

/// A sum in double precision, for every family of processors that this one can run.
TEST(LayerKernels, multiply_as_written) {
  Random random(2);
  for (const LayerKernels* kernels : available_layer_kernels())
    for (const int out : {8, 16, 24, 32, 48, 56, 144})
      for (const std::size_t rows : {1U, 3U, 8U, 13U}) {
        const int in = 27;
        const std::size_t value_stride = 31, result_stride = static_cast<std::size_t>(out) + 8;
        const std::vector<float> values = random_values(rows * value_stride, random), matrix = random_values(static_cast<std::size_t>(in * out), random),
                                 bias = random_values(static_cast<std::size_t>(out), random), add = random_values(rows * static_cast<std::size_t>(out), random);
        std::vector<float> packed;
        for (int first = 0; first < out; first += 16)
          for (int i = 0; i < in; ++i)
            for (int k = first; k < std::min(first + 16, out); ++k) packed.push_back(matrix[static_cast<std::size_t>(i * out + k)]);
        std::vector<float> result(rows * result_stride, 99.0F);
        kernels->product({rows, in, out, values.data(), value_stride, packed.data(), bias.data(), add.data(),
                          static_cast<std::size_t>(out), {-3.0F, 4.0F}, result.data(), result_stride});
        for (std::size_t r = 0; r < rows; ++r)
          for (std::size_t k = 0; k < result_stride; ++k) {
            if (k >= static_cast<std::size_t>(out)) {
              EXPECT_EQ(result[r * result_stride + k], 99.0F);
              continue;
            }
            double sum = bias[k] + add[r * static_cast<std::size_t>(out) + k];
            for (int i = 0; i < in; ++i)
              sum += static_cast<double>(values[r * value_stride + static_cast<std::size_t>(i)]) *
                     matrix[static_cast<std::size_t>(i) * static_cast<std::size_t>(out) + k];
            EXPECT_NEAR(result[r * result_stride + k], std::clamp(sum, -3.0, 4.0), 1e-5);
          }
      }
}

TEST(LayerKernels, filter_each_channel_by_itself) {
  Random random(2);
  for (const LayerKernels* kernels : available_layer_kernels())
    for (const int channels : {8, 16, 24, 96})
      for (const int stride : {1, 2}) {
        constexpr std::size_t cells = 5;
        const auto n = static_cast<std::size_t>(channels);
        const std::size_t width = cells * static_cast<std::size_t>(stride) + 2;
        const std::vector<float> values = random_values(3 * width * n, random), weights = random_values(9 * n, random), bias = random_values(n, random);
        std::vector<float> result(cells * n);
        kernels->depthwise({cells, channels, stride, {values.data(), &values[width * n], &values[2 * width * n]},
                            weights.data(), bias.data(), {0.0F, 6.0F}, result.data()});
        for (std::size_t o = 0; o < cells; ++o)
          for (std::size_t c = 0; c < n; ++c) {
            double sum = bias[c];
            for (std::size_t i = 0; i < 3; ++i)
              for (std::size_t j = 0; j < 3; ++j)
                sum += static_cast<double>(weights[(3 * i + j) * n + c]) * values[(i * width + o * static_cast<std::size_t>(stride) + j) * n + c];
            EXPECT_NEAR(result[o * n + c], std::clamp(sum, 0.0, 6.0), 1e-5);
          }
      }
}

}  // namespace
}  // namespace orthodrive

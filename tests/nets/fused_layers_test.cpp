// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/fused_layers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/net_surgery.hpp"

namespace orthodrive {
namespace {

struct Folded {
  NetworkGraph graph;
  NetworkParams params;
};
Folded folded_network(int seed) {
  NetworkGraph graph = make_network("mobilenetv2-s16-fpn2", 5);
  TensorFile file = start_weights(graph, {}, static_cast<std::uint64_t>(seed)).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors)  // batch norms and scores start as nothing
    if (name.ends_with("/bias") || name.ends_with("/beta") || name.ends_with("/moving_mean") ||
        name.starts_with("head"))
      for (float& v : tensor.values) v = static_cast<float>(0.2 * random.normal());
  NetworkParams params = fold_batch_norm(graph, params_from_file(graph, file, "random"));
  return {std::move(graph), std::move(params)};
}

TEST(FusedLayers, give_what_the_layers_give_one_by_one) {
  Folded net = folded_network(3);
  const FusionPlan plan = fuse_layers(net.graph, net.params);
  const int margin = receptive_field(net.graph).margin_px();
  Random random(1);
  for (const auto& [row, col, height, width] :
       {std::array{0, 0, 37, 300}, std::array{5, 11, 1, 1}, std::array{14, 3, 290, 18}}) {
    const int rows = height + 2 * margin, cols = width + 2 * margin;
    std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * rows * cols));
    for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(255.0 * random.uniform());
    const InputTensors image = input_tensors(net.graph, {rgb.data(), nullptr}, 1, cols, rows);
    const ExactWindow window{{row - margin, row + height - 1 + margin},
                             {col - margin, col + width - 1 + margin},
                             {row, row + height - 1},
                             {col, col + width - 1}};
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

}  // namespace
}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/fused_layers.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "nets/random_network.hpp"

namespace orthodrive {
namespace {

TEST(FusedLayers, cover_all_of_the_default_network_but_its_scores) {
  const NetworkGraph graph = make_network("mobilenetv2-s16-fpn2", 5);
  const FusionPlan plan = fuse_layers(graph, fold_batch_norm(graph, random_weights(graph), "random"));
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const bool score = graph.layers[i].name == "head" || graph.layers[i].score;
    EXPECT_EQ(plan.step[i] == FusionPlan::plain, score) << graph.layers[i].name;
  }
}

TEST(FusedLayers, do_not_touch_networks_without_depthwise_layers) {
  for (const char* name : {"vgg16-8s", "googlenet-8s"}) {
    const NetworkGraph graph = make_network(name, 2);
    const std::vector<LayerWeights> weights(graph.layers.size());
    EXPECT_TRUE(fuse_layers(graph, weights).fused.empty()) << name;
  }
}

}  // namespace
}  // namespace orthodrive

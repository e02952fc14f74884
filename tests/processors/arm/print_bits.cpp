// SPDX-License-Identifier: Apache-2.0
// Prints hashes of what networks and the dense CRF compute from a seed: two processors that print the same lines
// compute the same bits. All inputs come from whole numbers.

#include <bit>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/crf/dense_crf.hpp"
#include "orthodrive/nets/class_probabilities.hpp"
#include "orthodrive/nets/inference_network.hpp"
#include "orthodrive/nets/make_network.hpp"

namespace orthodrive {
namespace {

std::uint64_t hash_of(const std::vector<float>& values) {
  std::uint64_t hash = 0;
  for (const float v : values) hash = derive_seed(hash, std::bit_cast<std::uint32_t>(v));
  return hash;
}

std::vector<std::uint8_t> bytes(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> result(count);
  for (std::uint8_t& b : result) b = static_cast<std::uint8_t>(random.below(256));
  return result;
}

/// Weights that keep the sums of a layer as large as what it reads.
std::vector<LayerWeights> weights_of(const NetworkGraph& graph) {
  Random random(11);
  std::vector<LayerWeights> weights;
  for (const Layer& layer : graph.layers) {
    LayerWeights& w = weights.emplace_back();
    if (layer.kernel_tensor.empty()) continue;
    const int fan_in = layer.kernel * layer.kernel * (layer.depthwise ? 1 : layer.in);
    std::size_t count = 1;
    for (const std::int64_t n : kernel_file_shape(layer)) count *= static_cast<std::size_t>(n);
    for (std::size_t i = 0; i < count; ++i)
      w.kernel.push_back(static_cast<float>(random.uniform(-1.0, 1.0) * 4.0 / (3.0 + fan_in)));
    for (int c = 0; c < layer.out; ++c) w.bias.push_back(static_cast<float>(random.uniform(-0.2, 0.2)));
  }
  return weights;
}

void print_network(const char* architecture) {
  const NetworkGraph graph = make_network(architecture, 8);
  const InferenceNetwork network(graph, weights_of(graph));
  const int margin = network.margin_px(), width = 24, height = 16;
  const auto pixels = static_cast<std::size_t>((width + 2 * margin) * (height + 2 * margin));
  const std::vector<std::uint8_t> rgb = bytes(3 * pixels, 1), map = bytes(4 * pixels, 2);
  std::vector<float> scores(static_cast<std::size_t>(4 * width * height * network.output_channels()));
  CellMemory memory;
  network.predict({rgb.data(), map.data()}, {7, 12, width, height}, 2, scores.data(), memory);
  std::printf("%s scores %016llx\n", architecture, static_cast<unsigned long long>(hash_of(scores)));
  softmax_of_scores(scores.data(), scores.size() / static_cast<std::size_t>(network.output_channels()),
                    network.output_channels());
  std::printf("%s softmax %016llx\n", architecture, static_cast<unsigned long long>(hash_of(scores)));
}

void print_crf() {
  constexpr int width = 60, height = 40, classes = 11;
  const std::vector<std::uint8_t> rgb = bytes(std::size_t{3} * width * height, 3);
  std::vector<float> unary, marginals(std::size_t{width} * height * classes);
  for (const std::uint8_t b : bytes(marginals.size(), 4)) unary.push_back(static_cast<float>(b) / 50.0F);
  const DenseCrf crf({width, height, 0, 0, rgb.data(), nullptr}, {});
  crf.infer(potts_crf(classes, 3.0F, 1.5F), unary, marginals);
  std::printf("crf marginals %016llx\n", static_cast<unsigned long long>(hash_of(marginals)));
}

}  // namespace
}  // namespace orthodrive

/// Arguments: architectures of networks.
int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) orthodrive::print_network(argv[i]);
  orthodrive::print_crf();
  return 0;
}

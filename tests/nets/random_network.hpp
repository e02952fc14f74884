// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images, maps and weights without meaning, for tests of networks.

#include <cstdint>
#include <vector>

#include "orthodrive/core/random.hpp"
#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/net_surgery.hpp"

namespace orthodrive {

inline std::vector<std::uint8_t> random_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(3 * width * height));
  for (std::uint8_t& v : rgb) v = static_cast<std::uint8_t>(255.0 * random.uniform());
  return rgb;
}

inline std::vector<std::uint8_t> random_map(int width, int height, std::uint64_t seed) {
  std::vector<std::uint8_t> map = random_image(width, height, seed);
  map.resize(static_cast<std::size_t>(map_raster_channels * width * height), 7);
  return map;
}

/// Biases, batch norms and scores start as nothing: these say something.
inline TensorFile random_weights(const NetworkGraph& graph) {
  TensorFile file = start_weights(graph, {}, 3).file;
  Random random(4);
  for (auto& [name, tensor] : file.tensors) {
    const bool shift = name.ends_with("/bias") || name.ends_with("/beta") || name.ends_with("/moving_mean");
    if (shift || name.starts_with("score") || name.starts_with("head") || name.starts_with("align_out"))
      for (float& v : tensor.values) v = static_cast<float>((shift ? 0.2 : 0.05) * random.normal());
  }
  return file;
}

}  // namespace orthodrive

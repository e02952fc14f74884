// SPDX-License-Identifier: Apache-2.0
#pragma once
// Prediction: runs a network on windows of a mosaic. No padding: every layer computes exactly the cells that the wanted
// output depends on, so the scores are the same wherever a window begins and ends. They are the same bits on every
// processor, too (core/kernel_family.hpp).

#include <cstdint>
#include <vector>

#include "orthodrive/geo/pixel_box.hpp"
#include "orthodrive/nets/cell_memory.hpp"
#include "orthodrive/nets/fused_layers.hpp"
#include "orthodrive/nets/layer_weights.hpp"
#include "orthodrive/nets/network_graph.hpp"
#include "orthodrive/nets/plain_layers.hpp"

namespace orthodrive {

/// Bytes that a network sees, H x W x channels each. Without a map (null) a network that knows one sees none.
struct NetworkInput {
  const std::uint8_t* rgb = nullptr;
  const std::uint8_t* map = nullptr;  ///< map_raster_channels, as map_alignment.hpp encodes them
};

/// What a byte of each channel means to the network, in the channel's place among its inputs.
struct InputScale {
  float zero = 0.0F, scale = 1.0F;
  int channel = 0;  ///< of the bytes
};
[[nodiscard]] std::vector<InputScale> photo_scales(const NetworkGraph& graph);
[[nodiscard]] std::vector<InputScale> map_scales();
/// (byte - zero) * scale: `pixels` x channels, dense.
void scale_input(const std::uint8_t* bytes, std::size_t pixels, const std::vector<InputScale>& scales, float* values);

/// Whether runs of layers are computed together (fused_layers.hpp). `none` is slow and gives the same scores, but for
/// the order of sums.
enum class LayerFusion { all, none };

/// Safe from several threads.
class InferenceNetwork {
 public:
  /// `folded`: from fold_batch_norm().
  InferenceNetwork(NetworkGraph graph, const std::vector<LayerWeights>& folded, LayerFusion fusion = LayerFusion::all);
  /// `bytes` cover `core` grown by margin_px() on every side. Writes what the last layer gives for the core, (factor
  /// height) x (factor width) x output_channels(): class scores, then the alignment, at `factor` times the resolution,
  /// bilinear. It does not depend on how a mosaic is cut into cores. `memory`: of this thread.
  void predict(const NetworkInput& bytes, const PixelBox& core, int factor, float* scores, CellMemory& memory) const;
  [[nodiscard]] int class_count() const { return graph_.class_count; }
  [[nodiscard]] bool sees_map() const { return graph_.map_channels > 0; }
  [[nodiscard]] int output_channels() const { return graph_.output_channels(); }
  [[nodiscard]] int margin_px() const { return margin_px_; }
  /// The most that is held at once while it predicts, in bytes per pixel of the image.
  [[nodiscard]] double peak_bytes_per_pixel() const { return peak_bytes_per_pixel_; }
  [[nodiscard]] const NetworkGraph& graph() const { return graph_; }

 private:
  NetworkGraph graph_;
  FusionPlan plan_;
  std::vector<PlainLayer> layers_;  ///< of those that are not fused
  int margin_px_ = 0;
  double peak_bytes_per_pixel_ = 0.0;
};

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// A fully convolutional network as a list of layers, and what follows from it without running it: which pixels a score
// depends on, hence the margin a window needs. Nothing here knows tensors.
//
// Cells of a layer have absolute indices along each axis: cell 0 of the image is its pixel 0, cell o of a convolution
// sees the input cells o * stride - padding ... + kernel - 1. So a part of a mosaic gives the same scores as the whole.

#include <array>
#include <string>
#include <vector>

namespace orthodrive {

enum class LayerKind { convolution, deconvolution, max_pool, local_response_norm, add, concat, upsample_2x };
enum class Activation { none, relu, relu6 };

struct Layer {
  std::string name;
  LayerKind kind = LayerKind::convolution;
  std::vector<int> inputs;  ///< indices of earlier layers, image_input for the photo, map_input for the map
  std::vector<int> shifts;  ///< of `add`: output cell o takes cell o + shift of that input (cropping, in other words)
  int in = 0, out = 0;      ///< channels
  int kernel = 1, stride = 1, padding = 0;
  bool depthwise = false;
  std::string kernel_tensor;  ///< name in model files; empty: the layer has no weights
  std::string norm_tensors;   ///< prefix of a batch norm's tensors; empty: a bias instead
  Activation activation = Activation::none;
  double dropout = 0.0;      ///< share of channels' cells zeroed in training, after the activation
  bool pretrained = false;   ///< ImageNet weights exist for it (the trunk)
  bool score = false;        ///< its channels are classes
  bool of_map = false;       ///< reads the map, or what was read of it
  bool starts_zero = false;  ///< in training from other weights: adds nothing to what those give
};
constexpr int image_input = -1, map_input = -2;

/// How RGB bytes become the network's input: (value - mean) * scale, mean in RGB order.
struct InputNormalisation {
  std::array<float, 3> mean_rgb{127.5F, 127.5F, 127.5F};
  float scale = 1.0F / 127.5F;
  bool bgr = false;  ///< channels in this order (networks trained with Caffe)
};

struct NetworkGraph {
  std::string architecture;   ///< such as "vgg16-8s"
  std::vector<Layer> layers;  ///< in order of evaluation; the last gives class scores at full size
  InputNormalisation input;
  int map_channels = 0;  ///< of the map beside the photo (map_alignment.hpp); 0: it sees the photo alone
  int class_count = 0;
  int alignment_channels = 0;  ///< behind the classes in the last layer (map_alignment.hpp)
  int stride_px = 32;          ///< of the coarsest layer
  int size_remainder = 0;      ///< input sizes that the layers divide without rest: multiples of stride_px plus this
  int output_shift = 0;        ///< cell o of the last layer belongs to pixel o + output_shift
  [[nodiscard]] int output_channels() const { return class_count + alignment_channels; }
};

/// Cells first ... last of a layer along one axis.
struct CellRange {
  int first = 0, last = -1;
  [[nodiscard]] int size() const { return last - first + 1; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};
[[nodiscard]] CellRange hull(CellRange a, CellRange b);  ///< an empty range does not count

/// The cells of its input number `input` that these cells of a layer are computed from, without any padding.
[[nodiscard]] CellRange input_range(const Layer& layer, std::size_t input, CellRange cells);

/// What every layer must compute, and the pixels the image must have, for those pixels of the output.
struct NeededRanges {
  std::vector<CellRange> layers;
  CellRange image;
};
[[nodiscard]] NeededRanges needed_ranges(const NetworkGraph& graph, CellRange output_pixels);

/// Cells of every layer when an image of that size is padded as the layers say (the reference's way, for training).
/// Throws OptionError when a layer would be empty.
[[nodiscard]] std::vector<CellRange> padded_ranges(const NetworkGraph& graph, int image_size_px);

/// What an output pixel sees, at worst over the positions within a stride.
struct ReceptiveField {
  int size_px = 0;                  ///< edge
  int before_px = 0, after_px = 0;  ///< farthest pixel that counts, to both sides
  [[nodiscard]] int margin_px() const { return before_px > after_px ? before_px : after_px; }
};
[[nodiscard]] ReceptiveField receptive_field(const NetworkGraph& graph);

/// Cells of each layer per pixel of the image.
[[nodiscard]] std::vector<double> cells_per_pixel(const NetworkGraph& graph);

}  // namespace orthodrive

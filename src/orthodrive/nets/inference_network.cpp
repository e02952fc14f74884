// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/inference_network.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "orthodrive/model/rasters/map_alignment.hpp"
#include "orthodrive/nets/class_probabilities.hpp"

namespace orthodrive {
namespace {

/// The last layer only doubles the size.
bool half_resolution(const NetworkGraph& graph) { return graph.layers.back().kind == LayerKind::upsample_2x; }

/// The layer where this one ends up: fused layers give their result at the last of them.
std::size_t ends_at(const FusionPlan& plan, std::size_t layer) {
  while (plan.step[layer] == FusionPlan::inside) ++layer;
  return layer;
}

/// Which outputs, the photo and the map among them, are used for the last time by each layer, so that memory can go
/// back.
std::vector<std::vector<int>> last_uses(const NetworkGraph& graph, const FusionPlan& plan) {
  std::vector<std::size_t> last(graph.layers.size(), 0);
  std::size_t photo = 0, map = 0;
  for (std::size_t i = 0; i < graph.layers.size(); ++i)
    for (const int input : graph.layers[i].inputs) {
      std::size_t& use = input == image_input ? photo
                         : input == map_input ? map
                                              : last[static_cast<std::size_t>(input)];
      use = std::max(use, ends_at(plan, i));
    }
  std::vector<std::vector<int>> released(graph.layers.size());
  released[photo].push_back(image_input);
  if (graph.map_channels > 0) released[map].push_back(map_input);
  for (std::size_t i = 0; i + 1 < graph.layers.size(); ++i) released[last[i]].push_back(static_cast<int>(i));
  return released;
}

/// Bytes that are alive at once, per pixel of the image.
double peak_bytes(const NetworkGraph& graph, const FusionPlan& plan) {
  const std::vector<double> cells = cells_per_pixel(graph);
  const std::vector<std::vector<int>> released = last_uses(graph, plan);
  const auto bytes = [&](int i) {
    if (i == image_input) return 3.0 * sizeof(float);
    if (i == map_input) return static_cast<double>(sizeof(float)) * graph.map_channels;
    const auto layer = static_cast<std::size_t>(i);
    return plan.step[layer] == FusionPlan::inside
               ? 0.0
               : sizeof(float) * cells[layer] * cell_stride_of(graph.layers[layer].out);
  };
  double alive = bytes(image_input) + bytes(map_input), peak = alive;
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    if (plan.step[i] == FusionPlan::inside) continue;
    alive += bytes(static_cast<int>(i));
    peak = std::max(peak, alive);
    for (const int k : released[i]) alive -= bytes(k);
  }
  return peak;
}

/// A window on its way through the layers.
class Run {
 public:
  Run(const NetworkGraph& graph, const FusionPlan& plan, const std::vector<PlainLayer>& layers, CellRange rows,
      CellRange cols, CellMemory& memory)
      : graph_(graph),
        plan_(plan),
        layers_(layers),
        rows_(needed_ranges(graph, rows).layers),
        cols_(needed_ranges(graph, cols).layers),
        outputs_(graph.layers.size()),
        memory_(memory) {}

  void see(const NetworkInput& bytes, CellRange rows, CellRange cols) {
    const auto scaled = [&](const std::uint8_t* from, const std::vector<InputScale>& scales) {
      Cells cells{{}, rows, cols, static_cast<int>(scales.size()), static_cast<int>(scales.size())};
      const auto pixels = static_cast<std::size_t>(rows.size()) * static_cast<std::size_t>(cols.size());
      cells.values = memory_.take(pixels * scales.size());
      if (from)
        scale_input(from, pixels, scales, cells.values.data());
      else
        std::fill_n(cells.values.data(), pixels * scales.size(), 0.0F);
      return cells;
    };
    photo_ = scaled(bytes.rgb, photo_scales(graph_));
    if (graph_.map_channels > 0) map_ = scaled(bytes.map, map_scales());
  }

  /// What the layer before `end` gives.
  Cells up_to(std::size_t end) {
    const std::vector<std::vector<int>> released = last_uses(graph_, plan_);
    for (std::size_t i = 0; i < end; ++i) {
      if (plan_.step[i] == FusionPlan::inside) continue;
      compute(i);
      for (const int k : released[i]) memory_.give_back(std::exchange(output_of(k).values, {}));
    }
    return std::move(outputs_[end - 1]);
  }
  void finish(Cells cells) { memory_.give_back(std::move(cells.values)); }

 private:
  Cells& output_of(int layer) {
    return layer == image_input ? photo_ : layer == map_input ? map_ : outputs_[static_cast<std::size_t>(layer)];
  }

  void compute(std::size_t i) {
    const Layer& layer = graph_.layers[i];
    Cells output{{}, rows_[i], cols_[i], layer.out, cell_stride_of(layer.out)};
    output.values = memory_.take(static_cast<std::size_t>(output.rows.size()) * output.row_floats());
    if (plan_.step[i] == FusionPlan::plain) {
      std::vector<CellView> inputs;
      inputs.reserve(layer.inputs.size());
      for (const int input : layer.inputs) inputs.push_back(output_of(input).view());
      run_plain(layer, layers_[i], inputs, output);
    } else {
      const FusedLayers& fused = plan_.fused[static_cast<std::size_t>(plan_.step[i])];
      run_fused(fused, output_of(fused.source).view(),
                fused.upsampled == FusedLayers::none ? CellView{} : output_of(fused.upsampled).view(), output.rows,
                output.cols, output.values.data());
    }
    outputs_[i] = std::move(output);
  }

  const NetworkGraph& graph_;
  const FusionPlan& plan_;
  const std::vector<PlainLayer>& layers_;
  std::vector<CellRange> rows_, cols_;
  Cells photo_, map_;
  std::vector<Cells> outputs_;
  CellMemory& memory_;
};

}  // namespace

std::vector<InputScale> photo_scales(const NetworkGraph& graph) {
  const InputNormalisation& n = graph.input;
  std::vector<InputScale> scales;
  for (int c = 0; c < 3; ++c) {
    const int byte = n.bgr ? 2 - c : c;
    scales.push_back({n.mean_rgb[static_cast<std::size_t>(byte)], n.scale, byte});
  }
  return scales;
}

std::vector<InputScale> map_scales() {
  constexpr float whole = 1.0F / 255.0F, half = 1.0F / 128.0F;
  static_assert(map_raster_channels == 4);
  return {{128.0F, half, 0}, {128.0F, half, 1}, {0.0F, whole, 2}, {0.0F, whole, 3}};
}

void scale_input(const std::uint8_t* bytes, std::size_t pixels, const std::vector<InputScale>& scales, float* values) {
  const std::size_t channels = scales.size();
  std::vector<std::array<float, 256>> tables(channels);
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t byte = 0; byte < 256; ++byte)
      tables[c][byte] = (static_cast<float>(byte) - scales[c].zero) * scales[c].scale;
  for (std::size_t i = 0; i < pixels; ++i, bytes += channels)
    for (std::size_t c = 0; c < channels; ++c) *values++ = tables[c][bytes[scales[c].channel]];
}

InferenceNetwork::InferenceNetwork(NetworkGraph graph, const std::vector<LayerWeights>& folded, LayerFusion fusion)
    : graph_(std::move(graph)),
      plan_(fusion == LayerFusion::all ? fuse_layers(graph_, folded) : no_fusion(graph_)),
      margin_px_(receptive_field(graph_).margin_px() + (half_resolution(graph_) ? 0 : 1)),
      peak_bytes_per_pixel_(peak_bytes(graph_, plan_)) {
  for (std::size_t i = 0; i < graph_.layers.size(); ++i)
    layers_.push_back(plan_.step[i] == FusionPlan::plain ? make_plain_layer(graph_.layers[i], folded[i])
                                                         : PlainLayer{});
}

void InferenceNetwork::predict(const NetworkInput& bytes, const PixelBox& core, int factor, float* scores,
                               CellMemory& memory) const {
  // The layers count cells from a multiple of the stride near the core, so that indices stay small in any mosaic.
  const auto local = [&](std::int64_t px) {
    return static_cast<int>(((px % graph_.stride_px) + graph_.stride_px) % graph_.stride_px);
  };
  const int row = local(core.row), col = local(core.col);
  // The last doubling is done here, together with that to a finer grid; the latter needs the cells around the core.
  const bool half = half_resolution(graph_);
  const int around = half || factor == 1 ? 0 : 1;
  const CellRange rows{row - around, row + core.height - 1 + around}, cols{col - around, col + core.width - 1 + around};
  Run run(graph_, plan_, layers_, rows, cols, memory);
  run.see(bytes, {row - margin_px_, row + core.height - 1 + margin_px_},
          {col - margin_px_, col + core.width - 1 + margin_px_});
  Cells cells = run.up_to(graph_.layers.size() - (half ? 1 : 0));
  const ScoreGrid grid{cells.values.data(), cells.cols.size(), cells.rows.size(), graph_.output_channels(),
                       cells.cell_stride};
  const auto axis = [&](CellRange pixels, int first, int count) {
    const int first_cell = half ? input_range(graph_.layers.back(), 0, pixels).first : pixels.first;
    return UpsampledAxis{factor * first, first_cell, factor * count, half ? 2 * factor : factor};
  };
  upsample_scores(grid, axis(rows, row, core.height), axis(cols, col, core.width), scores);
  run.finish(std::move(cells));
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/network_graph.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

int floor_div(int a, int b) { return a >= 0 ? a / b : -((-a + b - 1) / b); }
int ceil_div(int a, int b) { return -floor_div(-a, b); }

/// Cells that a padded input of these cells gives.
CellRange padded_output(const Layer& layer, CellRange in) {
  const int k = layer.kernel, s = layer.stride, p = layer.padding;
  switch (layer.kind) {
    case LayerKind::convolution:
      return {ceil_div(in.first, s), floor_div(in.last + 2 * p - k + 1, s)};
    case LayerKind::max_pool:  // Caffe rounds up: the last cell may see less
      return {ceil_div(in.first, s), ceil_div(in.last + 2 * p - k + 1, s)};
    case LayerKind::deconvolution:
      return {in.first * s, in.last * s - 2 * p + k - 1};
    case LayerKind::upsample_2x:
      return {2 * in.first, 2 * in.last + 1};
    default:
      return in;
  }
}

}  // namespace

CellRange hull(CellRange a, CellRange b) {
  if (a.size() <= 0) return b;
  if (b.size() <= 0) return a;
  return {std::min(a.first, b.first), std::max(a.last, b.last)};
}

CellRange input_range(const Layer& layer, std::size_t input, CellRange cells) {
  const int k = layer.kernel, s = layer.stride, p = layer.padding;
  switch (layer.kind) {
    case LayerKind::convolution:
    case LayerKind::max_pool:
      return {cells.first * s - p, cells.last * s - p + k - 1};
    case LayerKind::deconvolution:  // input i reaches the outputs i * s - p ... + k - 1
      return {ceil_div(cells.first + p - k + 1, s), floor_div(cells.last + p, s)};
    case LayerKind::upsample_2x:  // output o lies at (2 o - 1) / 4, between two cells
      return {floor_div(cells.first - 1, 2), floor_div(cells.last + 1, 2)};
    case LayerKind::add:
      return {cells.first + layer.shifts[input], cells.last + layer.shifts[input]};
    case LayerKind::local_response_norm:
    case LayerKind::concat:
      break;
  }
  return cells;
}

NeededRanges needed_ranges(const NetworkGraph& graph, CellRange output_pixels) {
  NeededRanges needed{std::vector<CellRange>(graph.layers.size()), {}};
  needed.layers.back() = {output_pixels.first - graph.output_shift, output_pixels.last - graph.output_shift};
  for (std::size_t i = graph.layers.size(); i-- > 0;) {
    const Layer& layer = graph.layers[i];
    for (std::size_t k = 0; k < layer.inputs.size(); ++k) {
      CellRange& input = layer.inputs[k] < 0 ? needed.image : needed.layers[static_cast<std::size_t>(layer.inputs[k])];
      input = hull(input, input_range(layer, k, needed.layers[i]));
    }
  }
  return needed;
}

std::vector<CellRange> padded_ranges(const NetworkGraph& graph, int image_size_px) {
  std::vector<CellRange> ranges;
  for (const Layer& layer : graph.layers) {
    CellRange out{};
    for (std::size_t k = 0; k < layer.inputs.size(); ++k) {
      const CellRange in =
          layer.inputs[k] < 0 ? CellRange{0, image_size_px - 1} : ranges[static_cast<std::size_t>(layer.inputs[k])];
      CellRange own = padded_output(layer, in);
      if (layer.kind == LayerKind::add) own = {in.first - layer.shifts[k], in.last - layer.shifts[k]};
      out = k == 0 ? own : CellRange{std::max(out.first, own.first), std::min(out.last, own.last)};
    }
    if (out.size() <= 0) {
      throw OptionError(fmt::format("network {}: layer '{}' has no cells for an image of {} px: use a larger crop",
                                    graph.architecture, layer.name, image_size_px));
    }
    ranges.push_back(out);
  }
  return ranges;
}

ReceptiveField receptive_field(const NetworkGraph& graph) {
  ReceptiveField field;
  for (int px = 0; px < graph.stride_px; ++px) {
    const CellRange seen = needed_ranges(graph, {px, px}).image;
    field.size_px = std::max(field.size_px, seen.size());
    field.before_px = std::max(field.before_px, px - seen.first);
    field.after_px = std::max(field.after_px, seen.last - px);
  }
  return field;
}

std::vector<double> cells_per_pixel(const NetworkGraph& graph) {
  std::vector<double> spacing, cells;  // pixels between cells
  for (const Layer& layer : graph.layers) {
    double input_spacing = 1.0;
    for (const int input : layer.inputs)
      if (input >= 0) input_spacing = spacing[static_cast<std::size_t>(input)];
    const bool finer = layer.kind == LayerKind::deconvolution || layer.kind == LayerKind::upsample_2x;
    const double factor = layer.kind == LayerKind::upsample_2x ? 2.0 : layer.stride;
    spacing.push_back(finer ? input_spacing / factor : input_spacing * factor);
    cells.push_back(1.0 / (spacing.back() * spacing.back()));
  }
  return cells;
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/nets/fcn.hpp"

#include <ATen/core/grad_mode.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "orthodrive/core/error.hpp"
#include "orthodrive/model/map_alignment.hpp"
#include "orthodrive/nets/class_probabilities.hpp"
#include "orthodrive/nets/fused_layers.hpp"
#include "orthodrive/nets/padded_parts.hpp"

namespace orthodrive {
namespace {

constexpr double batch_norm_eps = 1e-3;       // of the Keras weights
constexpr double batch_norm_momentum = 0.02;  // share of the newest batch in the running statistics
// Local response normalisation across 5 channels, Krizhevsky et al., 2012, section 3.3; appendix B of the thesis.
constexpr int lrn_size = 5;
constexpr double lrn_alpha = 1e-4, lrn_beta = 0.75;

/// A layer's output and the cells it holds.
struct Cells {
  at::Tensor values;
  CellRange rows, cols;
};

Cells narrowed(const Cells& cells, CellRange rows, CellRange cols) {
  at::Tensor values = cells.values;
  if (rows != cells.rows) values = values.narrow(2, rows.first - cells.rows.first, rows.size());
  if (cols != cells.cols) values = values.narrow(3, cols.first - cells.cols.first, cols.size());
  return {values, rows, cols};
}

at::Tensor normalise_across_channels(const at::Tensor& x) {
  const std::int64_t channels = x.size(1), side = lrn_size / 2;
  const at::Tensor squares = at::constant_pad_nd(x * x, {0, 0, 0, 0, side, side});
  at::Tensor sum = squares.narrow(1, 0, channels);
  for (std::int64_t i = 1; i < lrn_size; ++i) sum = sum + squares.narrow(1, i, channels);
  return x / (1.0 + (lrn_alpha / lrn_size) * sum).pow(lrn_beta);
}

at::Tensor activate(const Layer& layer, const at::Tensor& x) {
  if (layer.activation == Activation::none) return x;
  // The derivative of hardtanh takes a tenth of the time of clamp's, which was a third of a training step.
  if (x.requires_grad()) return layer.activation == Activation::relu ? at::relu(x) : at::hardtanh(x, 0.0, 6.0);
  at::Tensor in_place = x;
  return layer.activation == Activation::relu ? at::relu_(in_place) : in_place.clamp_(0.0, 6.0);
}

const at::Tensor& read_by(const InputTensors& input, int layer_input) {
  return layer_input == map_input ? input.map : input.photo;
}

/// The layer on tensors that already have the right cells. `padding` is 0 where nothing is padded.
at::Tensor evaluate(const Layer& layer, LayerParams& p, const std::vector<Cells>& inputs, int padding,
                    TrainingMode mode) {
  const at::Tensor& x = inputs.front().values;
  const std::int64_t k = layer.kernel, s = layer.stride;
  switch (layer.kind) {
    case LayerKind::convolution: {
      at::Tensor y = at::conv2d(x, p.kernel, p.bias, s, padding, 1, layer.depthwise ? layer.in : 1);
      if (p.gamma.defined()) {
        y = at::batch_norm(y, p.gamma, p.beta, p.mean, p.variance,
                           mode.update_batch_statistics && (layer.of_map || !mode.of_map_only), batch_norm_momentum,
                           batch_norm_eps, false);
      }
      y = activate(layer, y);
      return layer.dropout > 0.0 && mode.dropout ? at::dropout(y, layer.dropout, true) : y;
    }
    case LayerKind::deconvolution:
      return at::conv_transpose2d(x, p.kernel, p.bias, s, padding);
    case LayerKind::max_pool:
      return at::max_pool2d(x, {k, k}, {s, s}, {padding, padding}, {1, 1}, true);
    case LayerKind::local_response_norm:
      return normalise_across_channels(x);
    case LayerKind::upsample_2x:
      return at::upsample_bilinear2d(x, {2 * x.size(2), 2 * x.size(3)}, false);
    case LayerKind::concat: {
      std::vector<at::Tensor> parts;
      for (const Cells& input : inputs) parts.push_back(input.values);
      return at::cat(parts, 1);
    }
    case LayerKind::add:
      break;
  }
  return x + inputs.at(1).values;
}

/// Which outputs are used for the last time by each layer, so that memory can go back. What is used inside of fused
/// layers is used where they end.
std::vector<std::vector<std::size_t>> last_uses(const NetworkGraph& graph, const FusionPlan* plan = nullptr) {
  std::vector<std::size_t> last(graph.layers.size(), 0);
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    std::size_t user = i;
    while (plan && plan->step[user] == FusionPlan::inside) ++user;
    for (const int input : graph.layers[i].inputs)
      if (input >= 0) last[static_cast<std::size_t>(input)] = std::max(user, last[static_cast<std::size_t>(input)]);
  }
  std::vector<std::vector<std::size_t>> released(graph.layers.size());
  for (std::size_t i = 0; i + 1 < graph.layers.size(); ++i) released[last[i]].push_back(i);
  return released;
}

CellView view_of(const Cells& cells) {
  return {cells.values.data_ptr<float>(), cells.rows, cells.cols, static_cast<std::size_t>(cells.values.size(1)),
          static_cast<std::size_t>(cells.values.size(1) * cells.values.size(3))};
}

Cells evaluate_fused(const FusedLayers& layers, const Cells& source, const Cells* upsampled, CellRange rows,
                     CellRange cols) {
  const auto dense = [](const Cells& cells) {
    return Cells{cells.values.contiguous(at::MemoryFormat::ChannelsLast), cells.rows, cells.cols};
  };
  const Cells from = dense(source), up = upsampled ? dense(*upsampled) : Cells{};
  Cells result{at::empty({1, layers.projection.out, rows.size(), cols.size()},
                         at::TensorOptions().dtype(at::kFloat).memory_format(at::MemoryFormat::ChannelsLast)),
               rows, cols};
  run_fused(layers, view_of(from), upsampled ? view_of(up) : CellView{}, rows, cols, result.values.data_ptr<float>());
  return result;
}

/// The last layer only doubles the size.
bool half_resolution(const NetworkGraph& graph) { return graph.layers.back().kind == LayerKind::upsample_2x; }

/// The last layer that reads the photo or the map, 0 where none does; fused layers read where they end.
std::size_t last_reader(const NetworkGraph& graph, const FusionPlan* plan, int input) {
  std::size_t last = 0;
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const std::vector<int>& inputs = graph.layers[i].inputs;
    if (std::find(inputs.begin(), inputs.end(), input) == inputs.end()) continue;
    last = i;
    while (plan && plan->step[last] == FusionPlan::inside) ++last;
  }
  return last;
}

/// Bytes that are alive at once, per pixel of the image.
double peak_bytes(const NetworkGraph& graph, const FusionPlan& plan) {
  const std::vector<double> cells = cells_per_pixel(graph);
  const std::vector<std::vector<std::size_t>> released = last_uses(graph, &plan);
  const auto bytes = [&](std::size_t i) { return sizeof(float) * cells[i] * graph.layers[i].out; };
  const double photo = sizeof(float) * 3.0, map = static_cast<double>(sizeof(float)) * graph.map_channels;
  const std::size_t photo_read = last_reader(graph, &plan, image_input),
                    map_read = last_reader(graph, &plan, map_input);
  double alive = photo + map, peak = alive;
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    if (plan.step[i] == FusionPlan::inside) continue;
    alive += bytes(i);
    peak = std::max(peak, alive);
    if (i == photo_read) alive -= photo;
    if (i == map_read) alive -= map;
    for (const std::size_t k : released[i])
      if (plan.step[k] != FusionPlan::inside) alive -= bytes(k);
  }
  return peak;
}

NamedTensor named_from(const at::Tensor& tensor, TensorType stored_as) {
  const at::Tensor flat = tensor.detach().to(at::kCPU).contiguous();
  const float* data = flat.data_ptr<float>();
  return {flat.sizes().vec(), std::vector<float>(data, data + flat.numel()), stored_as};
}

at::Tensor file_order_from_kernel(const Layer& layer, const at::Tensor& kernel) {
  if (layer.depthwise || layer.kind == LayerKind::deconvolution) return kernel.permute({2, 3, 0, 1});
  return kernel.permute({2, 3, 1, 0});
}

at::Tensor find_tensor(const NetworkGraph& graph, const TensorFile& file, const std::string& source,
                       const std::string& name, const std::vector<std::int64_t>& shape) {
  const auto it = file.tensors.find(name);
  if (it == file.tensors.end())
    throw InputError(source, fmt::format("tensor '{}' is missing, it is no {} model", name, graph.architecture));
  if (it->second.shape != shape) {
    throw InputError(source, fmt::format("tensor '{}' has shape [{}], need [{}]", name,
                                         fmt::join(it->second.shape, ","), fmt::join(shape, ",")));
  }
  return tensor_from(it->second);
}

/// Layers `first` to `end` - 1 with their padding. `outputs`: of all layers before, where they are still needed, and
/// then of those that layers from `end` on read.
void run_padded(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input,
                const std::vector<CellRange>& rows, const std::vector<CellRange>& cols, std::size_t first,
                std::size_t end, TrainingMode mode, std::vector<at::Tensor>& outputs) {
  const std::vector<std::vector<std::size_t>> released = last_uses(graph);
  for (std::size_t i = first; i < end; ++i) {
    const Layer& layer = graph.layers[i];
    std::vector<Cells> inputs;
    for (std::size_t k = 0; k < layer.inputs.size(); ++k) {
      const auto from = static_cast<std::size_t>(layer.inputs[k]);
      const Cells cells = layer.inputs[k] < 0 ? Cells{read_by(input, layer.inputs[k]),
                                                      {0, static_cast<int>(input.photo.size(2)) - 1},
                                                      {0, static_cast<int>(input.photo.size(3)) - 1}}
                                              : Cells{outputs[from], rows[from], cols[from]};
      inputs.push_back(layer.kind == LayerKind::add
                           ? narrowed(cells, input_range(layer, k, rows[i]), input_range(layer, k, cols[i]))
                           : cells);
    }
    outputs[i] = evaluate(layer, params[i], inputs, layer.padding, mode);
    for (const std::size_t k : released[i]) outputs[k] = at::Tensor();
  }
}

Scores scores_of(const NetworkGraph& graph, const at::Tensor& values, CellRange rows, CellRange cols) {
  const int shift = graph.output_shift;
  return {values, {rows.first + shift, rows.last + shift}, {cols.first + shift, cols.last + shift}};
}
}  // namespace

Scores forward_padded(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input, TrainingMode mode) {
  const std::vector<CellRange> rows = padded_ranges(graph, static_cast<int>(input.photo.size(2))),
                               cols = padded_ranges(graph, static_cast<int>(input.photo.size(3)));
  std::vector<at::Tensor> outputs(graph.layers.size());
  run_padded(graph, params, input, rows, cols, 0, graph.layers.size(), mode, outputs);
  return scores_of(graph, outputs.back(), rows.back(), cols.back());
}

std::vector<at::Tensor> forward_padded_before(const NetworkGraph& graph, NetworkParams& params,
                                              const InputTensors& input, std::size_t first) {
  const std::vector<CellRange> rows = padded_ranges(graph, static_cast<int>(input.photo.size(2))),
                               cols = padded_ranges(graph, static_cast<int>(input.photo.size(3)));
  std::vector<at::Tensor> outputs(graph.layers.size());
  run_padded(graph, params, input, rows, cols, 0, first, {}, outputs);
  return outputs;
}

Scores forward_padded_from(const NetworkGraph& graph, NetworkParams& params, std::vector<at::Tensor> before,
                           std::size_t first, int image_size_px) {
  const std::vector<CellRange> cells = padded_ranges(graph, image_size_px);
  run_padded(graph, params, {}, cells, cells, first, graph.layers.size(), {}, before);
  return scores_of(graph, before.back(), cells.back(), cells.back());
}

at::Tensor forward_exact(const NetworkGraph& graph, NetworkParams& params, InputTensors input,
                         const ExactWindow& window, const FusionPlan* plan) {
  const NeededRanges rows = needed_ranges(graph, window.output_rows), cols = needed_ranges(graph, window.output_cols);
  const std::vector<std::vector<std::size_t>> released = last_uses(graph, plan);
  const std::size_t count = graph.layers.size() - (window.last_layer ? 0 : 1);
  std::vector<Cells> outputs(graph.layers.size());
  const auto output_of = [&](int layer) {
    return layer < 0 ? Cells{read_by(input, layer), window.image_rows, window.image_cols}
                     : outputs[static_cast<std::size_t>(layer)];
  };
  const std::size_t photo_read = last_reader(graph, plan, image_input), map_read = last_reader(graph, plan, map_input);
  const auto release = [&](std::size_t i) {
    for (const std::size_t k : released[i]) outputs[k] = {};
    if (i == photo_read) input.photo = at::Tensor();
    if (i == map_read) input.map = at::Tensor();
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Layer& layer = graph.layers[i];
    if (plan && plan->step[i] == FusionPlan::inside) continue;
    if (plan && plan->step[i] != FusionPlan::plain) {
      const FusedLayers& fused = plan->fused[static_cast<std::size_t>(plan->step[i])];
      const Cells upsampled = fused.upsampled == FusedLayers::none ? Cells{} : output_of(fused.upsampled);
      outputs[i] = evaluate_fused(fused, output_of(fused.source), upsampled.values.defined() ? &upsampled : nullptr,
                                  rows.layers[i], cols.layers[i]);
      release(i);
      continue;
    }
    std::vector<Cells> inputs;
    for (std::size_t k = 0; k < layer.inputs.size(); ++k) {
      inputs.push_back(narrowed(output_of(layer.inputs[k]), input_range(layer, k, rows.layers[i]),
                                input_range(layer, k, cols.layers[i])));
    }
    Cells output{evaluate(layer, params[i], inputs, 0, {}), rows.layers[i], cols.layers[i]};
    // These two also compute cells that lack a part of their input: cut them off.
    if (layer.kind == LayerKind::deconvolution) {
      const int reach = layer.kernel - 1 - layer.padding;
      output.rows = {inputs[0].rows.first * layer.stride - layer.padding, inputs[0].rows.last * layer.stride + reach};
      output.cols = {inputs[0].cols.first * layer.stride - layer.padding, inputs[0].cols.last * layer.stride + reach};
    } else if (layer.kind == LayerKind::upsample_2x) {
      output.rows = {2 * inputs[0].rows.first, 2 * inputs[0].rows.last + 1};
      output.cols = {2 * inputs[0].cols.first, 2 * inputs[0].cols.last + 1};
    }
    inputs.clear();
    outputs[i] = narrowed(output, rows.layers[i], cols.layers[i]);
    release(i);
  }
  return outputs[count - 1].values;
}

NetworkParams fold_batch_norm(const NetworkGraph& graph, const NetworkParams& params) {
  NetworkParams folded(params.size());
  const at::NoGradGuard no_grad;
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const LayerParams& p = params[i];
    if (!p.kernel.defined()) continue;
    LayerParams& f = folded[i];
    f.kernel = p.kernel.detach().to(at::kCPU).clone();
    if (p.gamma.defined()) {
      const at::Tensor scale = (p.gamma.detach() / at::sqrt(p.variance + batch_norm_eps)).to(at::kCPU);
      f.kernel = (f.kernel * scale.view({-1, 1, 1, 1})).contiguous(at::MemoryFormat::ChannelsLast);
      f.bias = p.beta.detach().to(at::kCPU) - p.mean.to(at::kCPU) * scale;
    } else {
      f.bias = p.bias.detach().to(at::kCPU).clone();
    }
  }
  return folded;
}

std::vector<std::int64_t> kernel_file_shape(const Layer& layer) {
  if (layer.depthwise) return {layer.kernel, layer.kernel, layer.in, 1};
  return {layer.kernel, layer.kernel, layer.in, layer.out};
}

at::Tensor kernel_from_file_order(const Layer& layer, const at::Tensor& hwio) {
  const bool input_first = layer.depthwise || layer.kind == LayerKind::deconvolution;
  return (input_first ? hwio.permute({2, 3, 0, 1}) : hwio.permute({3, 2, 0, 1}))
      .contiguous(at::MemoryFormat::ChannelsLast);
}

at::Tensor tensor_from(const NamedTensor& named) {
  return at::from_blob(const_cast<float*>(named.values.data()), named.shape, at::kFloat).clone();
}

std::string bias_tensor(const Layer& layer) {
  return layer.kernel_tensor.substr(0, layer.kernel_tensor.rfind('/')) + "/bias";
}

NetworkParams params_from_file(const NetworkGraph& graph, const TensorFile& file, const std::string& source) {
  NetworkParams params(graph.layers.size());
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const Layer& layer = graph.layers[i];
    if (layer.kernel_tensor.empty()) continue;
    const auto find = [&](const std::string& name, const std::vector<std::int64_t>& shape) {
      return find_tensor(graph, file, source, name, shape);
    };
    LayerParams& p = params[i];
    p.kernel = kernel_from_file_order(layer, find(layer.kernel_tensor, kernel_file_shape(layer)));
    const std::vector<std::int64_t> channels{layer.out};
    if (layer.norm_tensors.empty()) {
      p.bias = find(bias_tensor(layer), channels);
    } else {
      p.gamma = find(layer.norm_tensors + "/gamma", channels);
      p.beta = find(layer.norm_tensors + "/beta", channels);
      p.mean = find(layer.norm_tensors + "/moving_mean", channels);
      p.variance = find(layer.norm_tensors + "/moving_variance", channels);
    }
  }
  return params;
}

TensorFile file_from_params(const NetworkGraph& graph, const NetworkParams& params, TensorType kernels_as) {
  TensorFile file;
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const Layer& layer = graph.layers[i];
    const LayerParams& p = params[i];
    if (!p.kernel.defined()) continue;
    file.tensors.emplace(layer.kernel_tensor, named_from(file_order_from_kernel(layer, p.kernel.detach()), kernels_as));
    if (p.bias.defined()) file.tensors.emplace(bias_tensor(layer), named_from(p.bias, TensorType::f32));
    if (!p.gamma.defined()) continue;
    file.tensors.emplace(layer.norm_tensors + "/gamma", named_from(p.gamma, TensorType::f32));
    file.tensors.emplace(layer.norm_tensors + "/beta", named_from(p.beta, TensorType::f32));
    file.tensors.emplace(layer.norm_tensors + "/moving_mean", named_from(p.mean, TensorType::f32));
    file.tensors.emplace(layer.norm_tensors + "/moving_variance", named_from(p.variance, TensorType::f32));
  }
  return file;
}

InputTensors InputTensors::to(at::Device device) const {
  return {photo.to(device), map.defined() ? map.to(device) : map};
}

namespace {

/// Bytes, N x H x W x channels, as (value - zero) x scale: N x channels x H x W, a view that is channels-last.
template <std::size_t channels>
at::Tensor normalised(const std::uint8_t* bytes, int count, int width, int height,
                      const std::array<float, channels>& zero, const std::array<float, channels>& scale) {
  std::array<std::array<float, 256>, channels> values;
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t byte = 0; byte < 256; ++byte) values[c][byte] = (static_cast<float>(byte) - zero[c]) * scale[c];
  const at::Tensor tensor = at::empty({count, height, width, static_cast<std::int64_t>(channels)}, at::kFloat);
  float* out = tensor.data_ptr<float>();
  for (std::int64_t left = tensor.numel(); left > 0; left -= channels)
    for (std::size_t c = 0; c < channels; ++c) *out++ = values[c][*bytes++];
  return tensor.permute({0, 3, 1, 2});
}

}  // namespace

InputTensors input_tensors(const NetworkGraph& graph, const NetworkInput& bytes, int count, int width, int height) {
  const InputNormalisation& n = graph.input;
  InputTensors input{normalised<3>(bytes.rgb, count, width, height, n.mean_rgb, {n.scale, n.scale, n.scale}), {}};
  if (n.bgr) input.photo = input.photo.flip(1).contiguous(at::MemoryFormat::ChannelsLast);
  if (graph.map_channels == 0) return input;
  constexpr float whole = 1.0F / 255.0F, half = 1.0F / 128.0F;
  input.map = bytes.map ? normalised<map_raster_channels>(bytes.map, count, width, height, {128.0F, 128.0F, 0.0F, 0.0F},
                                                          {half, half, whole, whole})
                        : at::zeros({count, height, width, graph.map_channels}).permute({0, 3, 1, 2});
  return input;
}

InferenceNetwork::InferenceNetwork(NetworkGraph graph, const NetworkParams& params)
    : graph_(std::move(graph)),
      folded_(fold_batch_norm(graph_, params)),
      plan_(std::make_shared<FusionPlan>(fuse_layers(graph_, folded_))),
      margin_px_(receptive_field(graph_).margin_px() + (half_resolution(graph_) ? 0 : 1)),
      peak_bytes_per_pixel_(peak_bytes(graph_, *plan_)) {}

void InferenceNetwork::predict(const NetworkInput& bytes, const PixelBox& core, int factor, float* scores) const {
  const c10::InferenceMode inference;
  // The layers count cells from a multiple of the stride near the core, so that indices stay small in any mosaic.
  const auto local = [&](std::int64_t px) {
    return static_cast<int>(((px % graph_.stride_px) + graph_.stride_px) % graph_.stride_px);
  };
  const int row = local(core.row), col = local(core.col);
  // The last doubling is ours, together with that to a finer grid; the latter needs the cells around the core.
  const bool half = half_resolution(graph_);
  const int around = half || factor == 1 ? 0 : 1;
  ExactWindow window;
  window.output_rows = {row - around, row + core.height - 1 + around};
  window.output_cols = {col - around, col + core.width - 1 + around};
  window.image_rows = {row - margin_px_, row + core.height - 1 + margin_px_};
  window.image_cols = {col - margin_px_, col + core.width - 1 + margin_px_};
  window.last_layer = !half;
  NetworkParams params = folded_;  // handles only
  InputTensors input = input_tensors(graph_, bytes, 1, core.width + 2 * margin_px_, core.height + 2 * margin_px_);
  const at::Tensor cells =
      forward_exact(graph_, params, std::move(input), window, plan_.get()).permute({0, 2, 3, 1}).contiguous();
  const ScoreGrid grid{cells.data_ptr<float>(), static_cast<int>(cells.size(2)), static_cast<int>(cells.size(1)),
                       graph_.output_channels()};
  const auto axis = [&](CellRange pixels, int first, int count) {
    const int first_cell = half ? input_range(graph_.layers.back(), 0, pixels).first : pixels.first;
    return UpsampledAxis{factor * first, first_cell, factor * count, half ? 2 * factor : factor};
  };
  upsample_scores(grid, axis(window.output_rows, row, core.height), axis(window.output_cols, col, core.width), scores);
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/padded_network.hpp"

#include <algorithm>

#include "orthodrive/nets/layer_weights.hpp"
#include "orthodrive/train/padded_parts.hpp"

namespace orthodrive {
namespace {

constexpr double batch_norm_momentum = 0.02;  // share of the newest batch in the running statistics
// Local response normalisation across 5 channels, Krizhevsky et al., 2012, section 3.3; appendix B of the thesis.
constexpr int lrn_size = 5;
constexpr double lrn_alpha = 1e-4, lrn_beta = 0.75;

/// A layer's output and the cells it holds.
struct TensorCells {
  at::Tensor values;
  CellRange rows, cols;
};

TensorCells narrowed(const TensorCells& cells, CellRange rows, CellRange cols) {
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

/// The layer on tensors that already have the right cells.
at::Tensor evaluate(const Layer& layer, LayerParams& p, const std::vector<TensorCells>& inputs, TrainingMode mode) {
  const at::Tensor& x = inputs.front().values;
  const std::int64_t k = layer.kernel, s = layer.stride, padding = layer.padding;
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
      parts.reserve(inputs.size());
      for (const TensorCells& input : inputs) parts.push_back(input.values);
      return at::cat(parts, 1);
    }
    case LayerKind::add:
      break;
  }
  return x + inputs.at(1).values;
}

/// Which outputs are used for the last time by each layer, so that memory can go back.
std::vector<std::vector<std::size_t>> last_uses(const NetworkGraph& graph) {
  std::vector<std::size_t> last(graph.layers.size(), 0);
  for (std::size_t i = 0; i < graph.layers.size(); ++i)
    for (const int input : graph.layers[i].inputs)
      if (input >= 0) last[static_cast<std::size_t>(input)] = i;
  std::vector<std::vector<std::size_t>> released(graph.layers.size());
  for (std::size_t i = 0; i + 1 < graph.layers.size(); ++i) released[last[i]].push_back(i);
  return released;
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

at::Tensor kernel_from_file_order(const Layer& layer, const at::Tensor& hwio) {
  const bool input_first = layer.depthwise || layer.kind == LayerKind::deconvolution;
  return (input_first ? hwio.permute({2, 3, 0, 1}) : hwio.permute({3, 2, 0, 1}))
      .contiguous(at::MemoryFormat::ChannelsLast);
}

at::Tensor tensor_from(const NamedTensor& named) {
  return at::from_blob(const_cast<float*>(named.values.data()), named.shape, at::kFloat).clone();
}

/// Bytes, N x H x W x channels, as the network sees them: N x channels x H x W, a view that is channels-last.
at::Tensor scaled_tensor(const std::uint8_t* bytes, int count, int width, int height,
                         const std::vector<InputScale>& scales) {
  const auto channels = static_cast<std::int64_t>(scales.size());
  const at::Tensor tensor = at::empty({count, height, width, channels}, at::kFloat);
  scale_input(bytes, static_cast<std::size_t>(tensor.numel() / channels), scales, tensor.data_ptr<float>());
  return tensor.permute({0, 3, 1, 2});
}

/// Layers `first` to `end` - 1 with their padding. `outputs`: of all layers before, where they are still needed, and
/// then of those that layers from `end` on read.
void run_padded(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input,
                const std::vector<CellRange>& rows, const std::vector<CellRange>& cols, std::size_t first,
                std::size_t end, TrainingMode mode, std::vector<at::Tensor>& outputs) {
  const std::vector<std::vector<std::size_t>> released = last_uses(graph);
  for (std::size_t i = first; i < end; ++i) {
    const Layer& layer = graph.layers[i];
    std::vector<TensorCells> inputs;
    for (std::size_t k = 0; k < layer.inputs.size(); ++k) {
      const auto from = static_cast<std::size_t>(layer.inputs[k]);
      const TensorCells cells = layer.inputs[k] < 0 ? TensorCells{read_by(input, layer.inputs[k]),
                                                                  {0, static_cast<int>(input.photo.size(2)) - 1},
                                                                  {0, static_cast<int>(input.photo.size(3)) - 1}}
                                                    : TensorCells{outputs[from], rows[from], cols[from]};
      inputs.push_back(layer.kind == LayerKind::add
                           ? narrowed(cells, input_range(layer, k, rows[i]), input_range(layer, k, cols[i]))
                           : cells);
    }
    outputs[i] = evaluate(layer, params[i], inputs, mode);
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

NetworkParams params_from_file(const NetworkGraph& graph, const TensorFile& file, const std::string& source) {
  NetworkParams params(graph.layers.size());
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const Layer& layer = graph.layers[i];
    if (layer.kernel_tensor.empty()) continue;
    const auto find = [&](const std::string& name, const std::vector<std::int64_t>& shape) {
      return tensor_from(find_tensor(graph, file, source, name, shape));
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

InputTensors input_tensors(const NetworkGraph& graph, const NetworkInput& bytes, int count, int width, int height) {
  InputTensors input{scaled_tensor(bytes.rgb, count, width, height, photo_scales(graph)), {}};
  if (graph.map_channels == 0) return input;
  input.map = bytes.map ? scaled_tensor(bytes.map, count, width, height, map_scales())
                        : at::zeros({count, height, width, graph.map_channels}).permute({0, 3, 1, 2});
  return input;
}

}  // namespace orthodrive

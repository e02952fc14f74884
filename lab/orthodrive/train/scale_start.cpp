// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/scale_start.hpp"

#include <ATen/core/grad_mode.h>

#include <cmath>

#include "orthodrive/train/padded_parts.hpp"

namespace orthodrive {

void scale_to_unit_output(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input) {
  const at::NoGradGuard no_grad;
  std::vector<double> factors(graph.layers.size(), 1.0);  // of each layer's output, against unscaled weights
  for (std::size_t i = 0; i < graph.layers.size(); ++i) {
    const Layer& layer = graph.layers[i];
    const double before = layer.inputs.front() >= 0 ? factors[static_cast<std::size_t>(layer.inputs.front())] : 1.0;
    if (layer.kind == LayerKind::max_pool) factors[i] = before;
    LayerParams& p = params[i];
    if (layer.kind != LayerKind::convolution || layer.activation != Activation::relu || !p.bias.defined()) continue;
    p.bias.mul_(before);
    const at::Tensor output = forward_padded_before(graph, params, input, i + 1)[i];
    const double size = std::sqrt(output.square().mean().item<double>());
    if (!(size > 0.0)) continue;  // it starts at zero
    p.kernel.div_(size);
    p.bias.div_(size);
    factors[i] = before / size;
  }
}

}  // namespace orthodrive

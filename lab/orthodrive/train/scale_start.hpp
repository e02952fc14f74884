// SPDX-License-Identifier: Apache-2.0
#pragma once
// The size of random starting weights, from data. Includes ATen: for the .cpp files of this folder only.

#include "orthodrive/train/padded_network.hpp"

namespace orthodrive {

/// Divides each rectified layer without batch norm by the root mean square of what comes out of it for `input`.
/// Networks that see bytes as they are (VGG16, GoogLeNet) else have features in the hundreds where their weights are
/// random, and one step of Adam changes scores by tens (Mishkin and Matas 2016; Kraehenbuehl et al. 2016). Weights that
/// were taken from elsewhere keep what they compute but for that factor: biases follow the input's factor, along chains
/// of convolutions and pools.
void scale_to_unit_output(const NetworkGraph& graph, NetworkParams& params, const InputTensors& input);

}  // namespace orthodrive

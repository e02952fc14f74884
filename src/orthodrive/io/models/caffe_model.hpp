// SPDX-License-Identifier: Apache-2.0
#pragma once
// Weights out of a binary Caffe model (.caffemodel: protobuf, message NetParameter of BVLC Caffe's caffe.proto).

#include <iosfwd>
#include <string>
#include <string_view>

#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive {

/// Both layouts of layers: `layer` (since 2015) and `layers` (V1, 2014). The tensors of a layer L, and their order of
/// axes (H x W: kernel height and width, I: channels in, O: out, G: groups):
///
///   Convolution    L/kernel             H x W x I/G x O     O x I/G x H x W in Caffe; nothing is flipped in either
///                  L/depthwise_kernel   H x W x I x 1       when every channel is a group of its own
///   Deconvolution  L/transposed_kernel  H x W x O/G x I     I x O/G x H x W in Caffe
///   InnerProduct   L/inner_product      O x I               I runs over channels, then rows, then columns
///   these          L/bias               O
///   BatchNorm      L/moving_mean, L/moving_variance         divided by their common factor, as Caffe does on use
///   Scale          L/gamma, L/beta
///   others         L/blob0, L/blob1 ...                     as they are
///
/// Metadata: L/type (Caffe's name of the type, as above) for every layer with weights, L/group where it is not 1, and
/// "network" if the net has a name. Doubles become floats. Photos go into most Caffe nets as BGR.
///
/// Holds the tensors and one layer of the file; the longest net is 2^31 - 1 bytes, protobuf's limit.
/// Throws InputError naming `source` for what is truncated, no Caffe model, V0 (before 2014) or without weights.
[[nodiscard]] TensorFile read_caffe_model(std::istream& stream, const std::string& source);
[[nodiscard]] TensorFile parse_caffe_model(std::string_view bytes, const std::string& source);

}  // namespace orthodrive

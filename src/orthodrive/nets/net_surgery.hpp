// SPDX-License-Identifier: Apache-2.0
#pragma once
// Starting weights of a network: taken from other networks where they fit, else by rule.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/model/rasters/tensor_file.hpp"
#include "orthodrive/nets/network_graph.hpp"

namespace orthodrive {

struct WeightsSource {
  std::string name;  ///< the file, for messages
  TensorFile file;
};

/// What happened to one layer.
struct SurgeryEntry {
  enum class Outcome {
    taken,      ///< as they are
    converted,  ///< a fully connected layer became a convolution
    bilinear,   ///< a deconvolution that interpolates (Long et al., 2015, section 3.3)
    zero,       ///< scores, so that training starts from "all classes alike"
    random      ///< He et al., 2015: normal, variance 2 / fan-in
  } outcome = Outcome::random;
  std::string layer, from;  ///< `from`: file and tensor
  std::string note;         ///< why a tensor of that name was not taken
};
[[nodiscard]] const char* to_string(SurgeryEntry::Outcome outcome);

struct SurgeryReport {
  std::vector<SurgeryEntry> layers;  ///< in the graph's order, layers with weights only
  std::vector<std::string> unused;   ///< tensors of the sources that no layer has a place for
};
[[nodiscard]] std::string format_report(const SurgeryReport& report);

/// Weights of all layers as a model file without metadata. Sources are asked in order. Layers are found by their own
/// name, by the Keras and Caffe names of the ImageNet networks and by those of the thesis. Score layers of another
/// number of classes start anew. Throws InputError for a source that gives nothing, for a trunk tensor of wrong
/// shape, and for values that are no numbers.
struct StartWeights {
  TensorFile file;
  SurgeryReport report;
};
[[nodiscard]] StartWeights start_weights(const NetworkGraph& graph, std::span<const WeightsSource> sources,
                                         std::uint64_t seed);

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/segment_model.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "orthodrive/core/error.hpp"
#include "orthodrive/nets/inference_network.hpp"
#include "orthodrive/nets/make_network.hpp"
#include "orthodrive/nets/model_metadata.hpp"

namespace orthodrive {

SegmentModel load_model(const TensorFile& file, const std::string& source) {
  const ModelMetadata metadata = parse_model_metadata(file.metadata, source);
  const std::size_t classes = metadata.classes.classes.size();
  NetworkGraph graph;
  try {
    graph = make_network(metadata.architecture, static_cast<int>(classes));
  } catch (const OptionError& error) {
    throw InputError(source, error.what());
  }
  const auto scores = std::find_if(graph.layers.begin(), graph.layers.end(),
                                   [](const Layer& l) { return l.score && l.kind == LayerKind::convolution; });
  const auto kernel = file.tensors.find(scores->kernel_tensor);
  if (kernel != file.tensors.end() && !kernel->second.shape.empty() &&
      kernel->second.shape.back() != static_cast<std::int64_t>(classes)) {
    throw InputError(
        source,
        fmt::format(
            "class table '{}' has {} classes but the weights score {}: use the table the model was trained with",
            metadata.classes.name, classes, kernel->second.shape.back()));
  }
  const auto network_of = [&](NetworkGraph of) {
    const std::vector<LayerWeights> folded = fold_batch_norm(of, file, source);
    return std::make_shared<InferenceNetwork>(std::move(of), folded);
  };
  SegmentModel model{
      .name = metadata.architecture,
      .classes = metadata.classes,
      .gsd_m = metadata.gsd_m,
      .finest_gsd_m = metadata.finest_gsd_m > 0.0 ? std::min(metadata.finest_gsd_m, metadata.gsd_m) : metadata.gsd_m,
      .sees_map = graph.map_channels > 0,
      .crf = read_crf(file, static_cast<int>(classes), source)};
  if (model.sees_map)
    model.without_map = network_of(make_network(without_map(metadata.architecture), static_cast<int>(classes)));
  model.network = network_of(std::move(graph));
  return model;
}

}  // namespace orthodrive

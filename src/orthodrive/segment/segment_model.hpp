// SPDX-License-Identifier: Apache-2.0
#pragma once
// A trained network with its class table.

#include <memory>
#include <optional>
#include <string>

#include "orthodrive/crf/crf_model.hpp"
#include "orthodrive/model/rasters/class_table.hpp"
#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive {

class InferenceNetwork;  // inference_network.hpp

struct SegmentModel {
  std::string name;  ///< architecture, from the file's metadata
  ClassTable classes;
  double gsd_m = 0.5;           ///< the scale the network was trained at
  double finest_gsd_m = 0.5;    ///< the finest it knows: fine photos are classified there
  bool sees_map = false;        ///< beside the photo (map_alignment.hpp)
  std::optional<CrfModel> crf;  ///< trained with it
  std::shared_ptr<const InferenceNetwork> network;
  std::shared_ptr<const InferenceNetwork> without_map;  ///< of a model that sees a map: for photos without one
};

/// From a model file (metadata "architecture", "gsd_m", "classes"); `source` names it in messages. Throws InputError
/// when it is of another architecture, or its class table does not match its weights.
[[nodiscard]] SegmentModel load_model(const TensorFile& file, const std::string& source);

}  // namespace orthodrive

#pragma once
// A trained network with its class table. Opaque: libtorch stays in the .cpp files.

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "orthodrive/model/class_table.hpp"
#include "orthodrive/segment/crf_model.hpp"

namespace orthodrive {

class InferenceNetwork;  // fcn.hpp

struct SegmentModel {
  std::string name;  ///< architecture, from the file's metadata
  ClassTable classes;
  double gsd_m = 0.5;         ///< the scale the network was trained at
  double finest_gsd_m = 0.5;  ///< the finest it knows: fine photos are classified there
  std::optional<CrfModel> crf;  ///< trained with it
  std::shared_ptr<const InferenceNetwork> network;
};

/// From the bytes of a model file (safetensors with metadata "architecture", "gsd_m", "classes"); `source` names it in
/// messages. Throws InputError when it is truncated, of another architecture, or its class table does not match its
/// weights.
[[nodiscard]] SegmentModel load_model(std::string_view bytes, const std::string& source);

}  // namespace orthodrive

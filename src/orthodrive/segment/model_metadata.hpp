#pragma once
// What a model file says about itself, as safetensors metadata.

#include <map>
#include <string>

#include "orthodrive/model/class_table.hpp"

namespace orthodrive {

struct ModelMetadata {
  std::string architecture;
  ClassTable classes;
  double gsd_m = 0.5;
};

/// Keys "architecture", "gsd_m", "classes" (the JSON of docs/segmentation.md). Throws InputError naming `source`.
[[nodiscard]] ModelMetadata parse_model_metadata(const std::map<std::string, std::string>& metadata,
                                                 const std::string& source);
[[nodiscard]] std::map<std::string, std::string> format_model_metadata(const ModelMetadata& metadata);

}  // namespace orthodrive

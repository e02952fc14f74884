// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a model file says about itself, as safetensors metadata.

#include <map>
#include <string>

#include "orthodrive/model/rasters/class_table.hpp"

namespace orthodrive {

struct ModelMetadata {
  std::string architecture;
  ClassTable classes;
  double gsd_m = 0.5;
  double finest_gsd_m = 0.0;  ///< the finest scale it was trained on; 0: not known, gsd_m
};

/// Keys "architecture", "gsd_m", "finest_gsd_m" (may be missing), "classes" (the JSON of docs/segment.md). Throws
/// InputError naming `source`.
[[nodiscard]] ModelMetadata parse_model_metadata(const std::map<std::string, std::string>& metadata,
                                                 const std::string& source);
[[nodiscard]] std::map<std::string, std::string> format_model_metadata(const ModelMetadata& metadata);

}  // namespace orthodrive

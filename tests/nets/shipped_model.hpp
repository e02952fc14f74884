// SPDX-License-Identifier: Apache-2.0
#pragma once
// models/default.safetensors for tests: as a model, and as a trunk to train from.

#include <fstream>
#include <sstream>
#include <string>

#include "orthodrive/io/models/safetensors.hpp"
#include "orthodrive/segment/segment_model.hpp"
#include "paths.hpp"

namespace orthodrive {

inline const std::string& shipped_model_bytes() {
  static const std::string bytes = [] {
    const std::ifstream file(paths::in_source("models/default.safetensors"), std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }();
  return bytes;
}

inline TensorFile shipped_tensors() { return parse_safetensors(shipped_model_bytes(), "models/default.safetensors"); }

inline const SegmentModel& shipped_model() {
  static const SegmentModel model = load_model(shipped_tensors(), "models/default.safetensors");
  return model;
}

}  // namespace orthodrive

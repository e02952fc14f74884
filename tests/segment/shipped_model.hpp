#pragma once
// models/default.safetensors for tests: as a model, and as a trunk to train from.

#include <fstream>
#include <sstream>
#include <string>

#include "orthodrive/segment/safetensors.hpp"
#include "orthodrive/segment/segment_model.hpp"

namespace orthodrive {

inline const std::string& shipped_model_bytes() {
  static const std::string bytes = [] {
    const std::ifstream file(ORTHODRIVE_SOURCE_DIR "/models/default.safetensors", std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }();
  return bytes;
}

inline const SegmentModel& shipped_model() {
  static const SegmentModel model = load_model(shipped_model_bytes(), "models/default.safetensors");
  return model;
}

inline TensorFile shipped_tensors() { return parse_safetensors(shipped_model_bytes(), "models/default.safetensors"); }

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// A training data set as one safetensors file: what `train --pack` writes, so that a machine without GDAL, maps or
// photos can train.
//
//   scene/<i>/rgb      U8 H x W x 3
//   scene/<i>/allowed  U8 H x W: index into scene/<i>/sets; I64 H x W, the sets themselves, when they are more than 256
//   scene/<i>/sets     I64: the sets that occur, as bits, ascending
//   scene/<i>/valid    U8 H x W, of validation scenes only
//   metadata "packed_scenes" (the format's version), "scenes" (a JSON array with the numbers of scene i), and free keys

#include <filesystem>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "orthodrive/train/train_network.hpp"
#include "orthodrive/train/training_scene.hpp"

namespace orthodrive {

struct PackedScenes {
  std::vector<TrainingScene> scenes;
  std::vector<ValidationScene> validation;
  /// Free keys. `train --pack` writes "experiment" and "network", the texts of their TOML, and those of
  /// model_metadata.hpp.
  std::map<std::string, std::string> metadata;
};

/// Needs little memory beside the data. Throws Error when the stream fails or the rasters of a scene differ in size.
void write_packed_scenes(std::ostream& out, const PackedScenes& data);

/// Exactly what was written. Throws InputError for a file that is something else, incomplete, or has sets of more
/// classes than ClassSet can hold.
[[nodiscard]] PackedScenes read_packed_scenes(const std::filesystem::path& file);

}  // namespace orthodrive

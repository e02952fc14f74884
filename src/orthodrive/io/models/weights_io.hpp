// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where model files lie and how they come into memory.

#include <filesystem>
#include <string>

#include "orthodrive/model/rasters/tensor_file.hpp"

namespace orthodrive::io {

/// A file of weights. Throws InputError when it cannot be read or is no complete safetensors file.
[[nodiscard]] TensorFile read_weights(const std::filesystem::path& path);

/// A path is taken as it is; a bare name is NAME.safetensors in the folder of the environment variable
/// ORTHODRIVE_MODELS, else of the models that came with the program (find_resource.hpp). Throws InputError listing
/// where it looked.
[[nodiscard]] std::filesystem::path find_model(const std::string& name_or_path);

}  // namespace orthodrive::io

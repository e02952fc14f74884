#pragma once
// Where model files lie and how they come into memory.

#include <filesystem>
#include <string>

namespace orthodrive::io {

/// The bytes of a file. Throws InputError when it cannot be read.
[[nodiscard]] std::string read_file(const std::filesystem::path& path);

/// A path is taken as it is; a bare name is NAME.safetensors in the folder of the environment variable
/// ORTHODRIVE_MODELS, else in models/ of the source tree. Throws InputError listing where it looked.
[[nodiscard]] std::filesystem::path find_model(const std::string& name_or_path);

}  // namespace orthodrive::io

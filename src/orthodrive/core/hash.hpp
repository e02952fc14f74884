// SPDX-License-Identifier: Apache-2.0
#pragma once
// Content hashes (XXH3, 128 bit) for caching and for telling that two outputs are the same. Not for security.

#include <filesystem>
#include <string>
#include <string_view>

namespace orthodrive {

/// 32 hexadecimal digits.
[[nodiscard]] std::string hash_bytes(std::string_view bytes);
/// Hash of a file's content. Throws InputError when it cannot be read.
[[nodiscard]] std::string hash_file(const std::filesystem::path& path);

}  // namespace orthodrive

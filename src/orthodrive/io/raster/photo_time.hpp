// SPDX-License-Identifier: Apache-2.0
#pragma once
// When a photo was taken.

#include <filesystem>
#include <optional>
#include <string>

namespace orthodrive::io {

/// "2021-06-01T10:00:00Z" of the photo's EXIF DateTimeOriginal or, without one, its TIFF tag DateTime; none where it
/// has neither. Cameras and writers state no time zone: taken as UTC. Throws InputError when the file is no raster.
[[nodiscard]] std::optional<std::string> photo_time(const std::filesystem::path& path);

/// The same of the text of such a tag, "2021:06:01 10:00:00"; none for what is no time.
[[nodiscard]] std::optional<std::string> time_of_tag(const std::string& text);

}  // namespace orthodrive::io

#pragma once
// The site of a photo that no site file describes.

#include <filesystem>

#include "orthodrive/model/site_frame.hpp"

namespace orthodrive::app {

/// All that the photo shows, in the UTM zone of its centre.
[[nodiscard]] SiteFrame site_of_photo(const std::filesystem::path& photo);

}  // namespace orthodrive::app

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Colours as maps write them.

#include <array>
#include <optional>
#include <string_view>

namespace orthodrive::io {

/// Linear red, green and blue (0..1) of "#rrggbb", "#rgb" or a name of CSS as buildings have them, in any case; nothing
/// for other text.
[[nodiscard]] std::optional<std::array<float, 3>> map_color(std::string_view text);
/// Of what walls and roofs are made of (OSM's building:material, roof:material); nothing for materials of any colour,
/// as plaster.
[[nodiscard]] std::optional<std::array<float, 3>> material_color(std::string_view material);

}  // namespace orthodrive::io

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a road is made of.

#include <cstdint>
#include <optional>
#include <string_view>

namespace roadquery {

/// OSM's `surface` values and OpenDRIVE's <material surface> are sorted into these. The order is that of the C
/// interface.
enum class SurfaceClass : std::uint8_t { asphalt, concrete, setts, gravel, ground };

/// "asphalt", "concrete", "setts", "gravel" or "ground": what is written as <material surface>.
[[nodiscard]] const char* to_string(SurfaceClass surface);

/// Class of a text as OSM's `surface` (https://wiki.openstreetmap.org/wiki/Key:surface) or others' <material surface>
/// have it. Case does not count, nor do spaces around it; of "asphalt;gravel" the first known one counts, and of
/// "concrete:plates" what stands before the colon where the whole is not known. Nothing for other texts.
[[nodiscard]] std::optional<SurfaceClass> surface_class_of(std::string_view text);

}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a road is made of, how well one knows it, and what a tyre finds on it.

#include <cstdint>
#include <string>
#include <string_view>

#include "roadquery/map/surface_class.hpp"

namespace orthodrive {

using SurfaceClass = roadquery::SurfaceClass;

/// Where the surface class of a way comes from.
enum class SurfaceSource : std::int8_t {
  unset,      ///< nothing was looked at
  tag,        ///< OSM's `surface`
  tracktype,  ///< OSM's `tracktype`
  highway,    ///< what is usual for the class of the road
  photo,      ///< the labels along it
  truth       ///< of a synthetic site
};
/// As the column `surface_source` of roads.gpkg has it; unset is the empty text.
[[nodiscard]] const char* to_string(SurfaceSource source);
/// Unset for other texts.
[[nodiscard]] SurfaceSource surface_source_of(std::string_view text);

struct KnownSurface {
  SurfaceClass surface = SurfaceClass::asphalt;
  SurfaceSource source = SurfaceSource::unset;
};

/// By the first of these that says something: `surface` (roadquery/surface_class.hpp), `tracktype` (grade1: asphalt,
/// grade2: gravel, others: ground; https://wiki.openstreetmap.org/wiki/Key:tracktype), the class of the road (track:
/// gravel, path and bridleway: ground, all others: asphalt).
[[nodiscard]] KnownSurface surface_of_tags(std::string_view highway, std::string_view surface,
                                           std::string_view tracktype);

enum class Weather : std::uint8_t { dry, wet };
[[nodiscard]] const char* to_string(Weather weather);
/// "dry" or "wet"; throws OptionError for other texts.
[[nodiscard]] Weather weather_of(std::string_view text);

struct RoadMaterial {
  /// Largest force over load that a tyre finds, over that on dry asphalt. Tyres multiply the peak that was measured on
  /// a dry test track by it, whatever tyre it is.
  double friction = 1.0;
  double roughness_m = 0.0;  ///< root mean square of the heights over the smooth surface, waves of 0.1 to 10 m
};

/// Friction: J. Y. Wong, Theory of Ground Vehicles, 3rd ed., table 1.3, average peak values over those of dry asphalt
/// and concrete (0.85): wet asphalt 0.6, wet concrete 0.8, gravel 0.6 (one value for dry and wet), earth 0.68 and 0.55.
/// The table has no setts: 0.80 and 0.50 are an estimate, between asphalt and what worn, polished stone is known for.
/// Roughness: ISO 8608 displacement spectra G_d(n0) (n / n0)^-2 between 0.1 and 10 cycles/m, whose variance is
/// 0.099 m-1 G_d(n0): class A (16e-6 m3) for asphalt and concrete, C for setts and gravel, D for ground.
[[nodiscard]] RoadMaterial material_of(SurfaceClass surface, Weather weather);

}  // namespace orthodrive

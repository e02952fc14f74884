// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/road_material.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

constexpr std::array source_names{"", "tag", "tracktype", "highway", "photo", "truth"};

struct ClassFriction {
  double dry, wet;
  double roughness_m;
};
// In the order of SurfaceClass. Roughness: sqrt(0.099 G_d(n0)) with G_d(n0) = 16e-6, 256e-6, 1024e-6 m3.
constexpr std::array frictions{ClassFriction{1.00, 0.70, 0.0013}, ClassFriction{1.00, 0.95, 0.0013},
                               ClassFriction{0.80, 0.50, 0.0050}, ClassFriction{0.70, 0.70, 0.0050},
                               ClassFriction{0.80, 0.65, 0.0101}};

}  // namespace

const char* to_string(SurfaceSource source) { return source_names.at(static_cast<std::size_t>(source)); }

SurfaceSource surface_source_of(std::string_view text) {
  const auto at = std::find(source_names.begin(), source_names.end(), text);
  return at == source_names.end() ? SurfaceSource::unset
                                  : static_cast<SurfaceSource>(std::distance(source_names.begin(), at));
}

KnownSurface surface_of_tags(std::string_view highway, std::string_view surface, std::string_view tracktype) {
  if (const auto known = roadquery::surface_class_of(surface)) return {*known, SurfaceSource::tag};
  if (tracktype == "grade1") return {SurfaceClass::asphalt, SurfaceSource::tracktype};
  if (tracktype == "grade2") return {SurfaceClass::gravel, SurfaceSource::tracktype};
  if (tracktype.starts_with("grade")) return {SurfaceClass::ground, SurfaceSource::tracktype};
  if (highway == "track") return {SurfaceClass::gravel, SurfaceSource::highway};
  if (highway == "path" || highway == "bridleway") return {SurfaceClass::ground, SurfaceSource::highway};
  return {SurfaceClass::asphalt, SurfaceSource::highway};
}

const char* to_string(Weather weather) { return weather == Weather::wet ? "wet" : "dry"; }

Weather weather_of(std::string_view text) {
  if (text == "dry") return Weather::dry;
  if (text == "wet") return Weather::wet;
  throw OptionError("weather must be dry or wet, not '" + std::string(text) + "'");
}

RoadMaterial material_of(SurfaceClass surface, Weather weather) {
  const ClassFriction& f = frictions.at(static_cast<std::size_t>(surface));
  return {weather == Weather::wet ? f.wet : f.dry, f.roughness_m};
}

}  // namespace orthodrive

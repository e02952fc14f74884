// SPDX-License-Identifier: Apache-2.0
#pragma once
// The village seen from above, pixel by pixel, before light and colour: what lies there and how high it stands.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/raster.hpp"
#include "orthodrive/synth/ground/site_objects.hpp"
#include "orthodrive/synth/ground/terrain.hpp"

namespace orthodrive::synth {

/// Crops of the fields; a field's number modulo their count.
enum class Crop : std::uint8_t { wheat, rape, ploughed, stubble, maize, hay };
constexpr int crop_count = 6;

struct World;
class TextureSampler;

/// What the pixels are made from. All in local metres.
struct SceneSource {
  const SitePlan& plan;
  const std::vector<RoadSample>& road_samples;
  const SiteObjects& objects;
  const BareEarth& earth;
  const GridFrame& earth_frame;
  std::uint32_t seed = 0;
  const World* world = nullptr;              ///< none: the plain one
  const TextureSampler* textures = nullptr;  ///< none: surfaces as the generator paints them
};

struct SceneRaster {
  GridFrame frame;
  Raster<Cover> cover;
  Raster<std::uint16_t> detail;       ///< number of the field or area
  Raster<std::int32_t> road_segment;  ///< index of the segment's first sample in road_samples, -1 far from roads
  Raster<float> road_edge_m;          ///< distance to the edge of the paved surface, negative inside; 9 far from roads
  Raster<std::uint8_t> road_count;    ///< carriageways that overlap here: > 1 in junctions
  Raster<std::int32_t> object;        ///< number of the house, tree or car on top (object_*), -1 none
  Raster<float> height_m;             ///< above the ground
  // Bare trees, through which the ground is seen. Empty where there are none.
  Raster<std::uint8_t> twigs{};       ///< share of the pixel that branches hide, of 255
  Raster<std::uint8_t> bare_crown{};  ///< 1: so dense that ground and grass below count as vegetation
  Raster<float> twig_height_m{};
};

/// Objects are numbered houses first, then trees, then cars.
struct ObjectCounts {
  std::int32_t houses = 0, trees = 0, cars = 0;
};
[[nodiscard]] inline ObjectCounts counts_of(const SiteObjects& o) {
  return {static_cast<std::int32_t>(o.houses.size()), static_cast<std::int32_t>(o.trees.size()),
          static_cast<std::int32_t>(o.cars.size())};
}

/// Bare earth, bilinear. Precondition: p lies in the site (the earth's grid reaches beyond it).
[[nodiscard]] float ground_height(const SceneSource& source, Vec2 p_local);

[[nodiscard]] SceneRaster rasterize_scene(const SceneSource& source, const GridFrame& frame, int threads);

/// Default class table: what is seen from above. Crowns over a road are vegetation, cars are what they stand on.
[[nodiscard]] Raster<std::uint8_t> label_scene(const SceneSource& source, const SceneRaster& scene, int threads);

}  // namespace orthodrive::synth

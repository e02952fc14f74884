// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/water_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/model/rasters/sample_height.hpp"
#include "orthodrive/scene/plan/tile_address.hpp"

namespace orthodrive::scene {
namespace {

constexpr double sample_m = 3.0, most_samples = 20'000.0;
constexpr double largest_drop_m = 3.0;
constexpr LinearColor darkest = {0.012F, 0.022F, 0.024F}, brightest = {0.10F, 0.14F, 0.13F};

struct Place {
  std::size_t body = 0;
  Vec2 at;
};
using PlacesByTile = std::map<TileAddress, std::vector<Place>>;

PlacesByTile places_in(const MultiPolygon& polygons, const Outline& area) {
  PlacesByTile places;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    const double step_m = std::max(sample_m, std::sqrt(area_m2(polygons[i]) / most_samples));
    const GridFrame frame = covering_grid(bounds_of(polygons[i].outer), step_m);
    rasterize(polygons[i], frame, [&](int row, int begin, int end) {
      for (int col = begin; col < end; ++col) {
        const Vec2 p = frame.center_of(col, row);
        if (area.contains(p)) places[tile_at(p)].push_back({i, p});
      }
    });
  }
  return places;
}

/// What is seen at the places of a body.
struct Seen {
  Vec2 first;
  std::vector<double> heights;
  std::vector<Rgb> colors;
};

void look(const std::vector<Place>& places, const TerrainWindows& terrain, const PhotoSource& photo,
          std::vector<Seen>& bodies) {
  const Box2 box = [&] {
    Ring points;
    for (const Place& place : places) points.push_back(place.at);
    return bounds_of(points);
  }();
  const HeightGrid heights = terrain.window(box);
  const Photo pixels = window_of(photo, box.grown(photo.frame.gsd_m));
  for (const Place& place : places) {
    Seen& body = bodies[place.body];
    if (body.heights.empty()) body.first = place.at;
    const double z = sample_bilinear(heights, place.at);
    if (std::isfinite(z)) body.heights.push_back(z);
    if (const auto pixel = pixel_at(pixels, place.at)) body.colors.push_back(*pixel);
  }
}

std::optional<WaterLevel> level_of(Seen& body, Findings& findings) {
  if (body.heights.empty()) return std::nullopt;
  std::ranges::sort(body.heights);
  const auto quantile = [&](double share) {
    return body.heights[static_cast<std::size_t>(share * static_cast<double>(body.heights.size() - 1))];
  };
  if (const double drop_m = quantile(0.9) - quantile(0.1); drop_m > largest_drop_m) {
    findings.push_back(
        {Severity::info, "scene.water_slope",
         fmt::format("water falls by {:.1f} m in the terrain model: it has no level and is not drawn", drop_m),
         body.first.x, body.first.y});
    return std::nullopt;
  }
  LinearColor color = median_color(body.colors);
  for (std::size_t c = 0; c < color.size(); ++c) color[c] = std::clamp(color[c], darkest[c], brightest[c]);
  return WaterLevel{quantile(0.25), color};
}

}  // namespace

std::vector<std::optional<WaterLevel>> water_levels(const MultiPolygon& polygons, const Outline& area,
                                                    const TerrainWindows& terrain, const PhotoSource& photo,
                                                    Findings& findings) {
  std::vector<Seen> bodies(polygons.size());
  for (const auto& [address, places] : places_in(polygons, area)) look(places, terrain, photo, bodies);
  std::vector<std::optional<WaterLevel>> levels;
  levels.reserve(bodies.size());
  for (Seen& body : bodies) levels.push_back(level_of(body, findings));
  return levels;
}

}  // namespace orthodrive::scene

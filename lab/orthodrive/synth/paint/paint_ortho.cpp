// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/synth/paint/paint_ortho.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "orthodrive/core/noise.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/synth/paint/mood.hpp"
#include "orthodrive/synth/paint/pavement.hpp"
#include "orthodrive/synth/paint/photo_textures.hpp"

namespace orthodrive::synth {
namespace {
constexpr double motorway_strip_m = 0.75, motorway_lane_m = 3.75;  // RAA 2008: edge strip at the median, lane

Rgb operator+(const Rgb& a, const Rgb& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Rgb operator*(const Rgb& a, float k) { return {a[0] * k, a[1] * k, a[2] * k}; }
Rgb mix(const Rgb& a, const Rgb& b, float t) { return a * (1.0f - t) + b * t; }
Rgb grey(float value) { return {value, value, value}; }

/// Share of direct sun that reaches each pixel, 0..255. The sun stands in the south, so rows are swept from south to
/// north: the shadow's upper bound is carried from row to row along the sun's direction.
/// `height_m` above the ground.
Raster<std::uint8_t> cast_shadows(const SceneSource& source, const SceneRaster& scene, const Raster<float>& height_m,
                                  const Mood& mood) {
  const int width = scene.frame.width, height = scene.frame.height;
  Raster<std::uint8_t> lit(width, height, 1, 255);
  const double shift = -std::tan(mood.sun_azimuth_rad - std::numbers::pi);  // columns towards the sun a row
  const auto drop = static_cast<float>(scene.frame.gsd_m * std::hypot(1.0, shift) * std::tan(mood.sun_elevation_rad));
  const int whole = static_cast<int>(std::floor(shift));
  const auto part = static_cast<float>(shift - whole);
  std::vector<float> ray(static_cast<std::size_t>(width), -1e4f), south(ray);
  for (int row = height - 1; row >= 0; --row) {
    std::swap(ray, south);
    for (int col = 0; col < width; ++col) {
      const int a = std::clamp(col + whole, 0, width - 1), b = std::clamp(a + 1, 0, width - 1);
      const float bound =
          (1.0f - part) * south[static_cast<std::size_t>(a)] + part * south[static_cast<std::size_t>(b)] - drop;
      const float here = ground_height(source, scene.frame.center_of(col, row)) + height_m.at(col, row);
      lit.at(col, row) = static_cast<std::uint8_t>(255.0f * (1.0f - smoothstep(0.05f, 0.7f, bound - here)));
      ray[static_cast<std::size_t>(col)] = std::max(bound, here);
    }
  }
  return lit;
}

/// Sun on the bare earth relative to flat ground, on the terrain's grid.
Raster<float> shade_terrain(const SceneSource& source, Vec3 sun) {
  const Raster<float>& z = source.earth.height_m;
  Raster<float> shade(z.width, z.height, 1, 1.0f);
  const auto step = static_cast<float>(2.0 * source.earth_frame.gsd_m);
  for (int row = 1; row + 1 < z.height; ++row)
    for (int col = 1; col + 1 < z.width; ++col) {
      const float zx = (z.at(col + 1, row) - z.at(col - 1, row)) / step,
                  zy = (z.at(col, row - 1) - z.at(col, row + 1)) / step;
      const double cosine = (sun.z - zx * sun.x - zy * sun.y) / std::sqrt(1.0 + zx * zx + zy * zy);
      shade.at(col, row) = static_cast<float>(std::clamp(cosine / sun.z, 0.4, 1.5));
    }
  return shade;
}

class Painter {
 public:
  Painter(const SceneSource& source, const SceneRaster& scene, const Mood& mood)
      : source_(source), scene_(scene), mood_(mood), counts_(counts_of(source.objects)), seed_(source.seed) {
    const double elevation = mood.sun_elevation_rad;
    sun_ = {std::sin(mood.sun_azimuth_rad) * std::cos(elevation), std::cos(mood.sun_azimuth_rad) * std::cos(elevation),
            std::sin(elevation)};
    lit_ = cast_shadows(source, scene, scene.height_m, mood);
    if (!scene.twigs.data.empty()) let_through_twigs(cast_shadows(source, scene, scene.twig_height_m, mood));
    terrain_shade_ = shade_terrain(source, sun_);
  }

  /// Reflected light of a pixel, before the camera.
  [[nodiscard]] Rgb light(int col, int row) const {
    const Vec2 p = scene_.frame.center_of(col, row);
    const std::int32_t object = scene_.object.at(col, row);
    Rgb albedo;
    float roughness = 0.0f;  // how much of the relief's own shading counts
    if (object < 0) {
      albedo = ground(col, row, p);
      const Cover cover = scene_.cover.at(col, row);
      if (cover == Cover::rock || cover == Cover::debris || cover == Cover::barrier) roughness = 0.8f;
      if (!scene_.twigs.data.empty()) albedo = under_twigs(albedo, col, row, p);
    } else if (object < counts_.houses) {
      albedo = roof(source_.objects.houses[static_cast<std::size_t>(object)], p);
      roughness = 1.0f;
    } else if (object < counts_.houses + counts_.trees) {
      albedo = crown(source_.objects.trees[static_cast<std::size_t>(object - counts_.houses)], p);
      roughness = 0.55f;
    } else {
      albedo = car(source_.objects.cars[static_cast<std::size_t>(object - counts_.houses - counts_.trees)], p);
    }
    if (source_.textures != nullptr) add_detail(albedo, object, col, row);
    float lambert = roughness > 0.0f ? 1.0f + roughness * (relief_shade(col, row) - 1.0f) : 1.0f;
    if (!on_deck(col, row)) lambert *= terrain_shade(p);
    const float sunlight = static_cast<float>(lit_.at(col, row)) / 255.0f * lambert;
    Rgb out;
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = albedo[i] * (mood_.ambient[i] + mood_.direct[i] * sunlight) / (mood_.ambient[i] + mood_.direct[i]);
    return out;
  }

 private:
  /// Bare branches take a part of the sun.
  void let_through_twigs(const Raster<std::uint8_t>& lit_by_twigs) {
    constexpr float most = 0.45f;
    for (std::size_t i = 0; i < lit_.data.size(); ++i)
      lit_.data[i] =
          static_cast<std::uint8_t>(static_cast<float>(lit_.data[i]) *
                                    (1.0f - most * (1.0f - static_cast<float>(lit_by_twigs.data[i]) / 255.0f)));
  }
  [[nodiscard]] Rgb under_twigs(const Rgb& below, int col, int row, Vec2 p) const {
    const float share = static_cast<float>(scene_.twigs.at(col, row)) / 255.0f;
    return share > 0.0f ? mix(below, mood_.foliage * (0.95f + 0.25f * fractal(p, 0.8, 94, 2)), share) : below;
  }

  /// Of real photos; cars, kerbs and pools stay as they are.
  void add_detail(Rgb& albedo, std::int32_t object, int col, int row) const {
    std::optional<Texture> texture;
    if (object < 0) {
      texture = texture_of(scene_.cover.at(col, row));
    } else if (object < counts_.houses + counts_.trees) {
      texture = object < counts_.houses ? Texture::building : Texture::vegetation;
    }
    if (!texture) return;
    const Rgb factors = source_.textures->at(*texture, scene_.frame.first_col + col, scene_.frame.first_row + row);
    for (std::size_t i = 0; i < 3; ++i) albedo[i] *= factors[i];
  }
  [[nodiscard]] static std::optional<Texture> texture_of(Cover cover) {
    switch (cover) {
      case Cover::road:
        return Texture::road;
      case Cover::parking:
      case Cover::paved:
      case Cover::drive:
      case Cover::apron:
        return Texture::parking;
      case Cover::field:
      case Cover::meadow:
      case Cover::lawn:
      case Cover::verge:
      case Cover::orchard:
        return Texture::grass;
      case Cover::garden_bed:
      case Cover::forest_floor:
      case Cover::gravel:
      case Cover::path:
      case Cover::gravel_trap:
      case Cover::sidewalk:
      case Cover::dirt:
        return Texture::ground;
      case Cover::water:
      case Cover::river:
        return Texture::water;
      case Cover::kerb:
      case Cover::pool:
      case Cover::snow:
      case Cover::debris:
      case Cover::rock:
      case Cover::rails:
      case Cover::barrier:
        break;
    }
    return std::nullopt;
  }

  [[nodiscard]] float relief_shade(int col, int row) const {
    const Raster<float>& h = scene_.height_m;
    const int west = std::max(0, col - 1), east = std::min(h.width - 1, col + 1), north = std::max(0, row - 1),
              south = std::min(h.height - 1, row + 1);
    const auto pixel = static_cast<float>(scene_.frame.gsd_m);
    const float hx = std::clamp((h.at(east, row) - h.at(west, row)) / (2.0f * pixel), -1.6f, 1.6f);
    const float hy = std::clamp((h.at(col, north) - h.at(col, south)) / (2.0f * pixel), -1.6f, 1.6f);
    const double cosine = (sun_.z - hx * sun_.x - hy * sun_.y) / std::sqrt(1.0 + hx * hx + hy * hy);
    return static_cast<float>(std::clamp(cosine / sun_.z, 0.0, 1.7));
  }

  [[nodiscard]] bool on_deck(int col, int row) const {
    const std::int32_t segment = scene_.road_segment.at(col, row);
    if (segment < 0) return false;
    const auto i = static_cast<std::size_t>(segment);
    return source_.road_samples[i].bridge || source_.road_samples[i + 1].bridge;
  }

  /// Bilinear; the terrain's grid reaches beyond the photo.
  [[nodiscard]] float terrain_shade(Vec2 p) const {
    const Vec2 q = source_.earth_frame.pixel_from_world(p) - Vec2{0.5, 0.5};
    const int col = static_cast<int>(q.x), row = static_cast<int>(q.y);
    const auto u = static_cast<float>(q.x - col), v = static_cast<float>(q.y - row);
    const Raster<float>& t = terrain_shade_;
    return (t.at(col, row) * (1.0f - u) + t.at(col + 1, row) * u) * (1.0f - v) +
           (t.at(col, row + 1) * (1.0f - u) + t.at(col + 1, row + 1) * u) * v;
  }

  [[nodiscard]] float noise(Vec2 p, double size_m, std::uint32_t layer) const {
    return value_noise(p.x / size_m, p.y / size_m, seed_ + layer);
  }
  [[nodiscard]] float fractal(Vec2 p, double size_m, std::uint32_t layer, int octaves) const {
    return fractal_noise(p.x / size_m, p.y / size_m, seed_ + layer, octaves);
  }
  /// A number in [0, 1) of a thing.
  [[nodiscard]] float trait(std::int32_t thing, std::uint32_t layer) const {
    return unit_hash(thing, 77, seed_ + layer);
  }

  [[nodiscard]] std::int32_t area_id(std::uint16_t detail) const { return source_.objects.areas[detail].id; }

  [[nodiscard]] Rgb ground(int col, int row, Vec2 p) const {
    const std::uint16_t detail = scene_.detail.at(col, row);
    switch (scene_.cover.at(col, row)) {
      case Cover::road:
        return road(col, row, p);
      case Cover::field:
        return field(p, detail);
      case Cover::meadow:
        return grass(p, 0.0f, 0.5f);
      case Cover::lawn:
        return grass(p, trait(area_id(detail), 20) - 0.5f, trait(area_id(detail), 21));
      case Cover::verge:
        return mix(grass(p, -0.2f, 0.5f), {0.52f, 0.48f, 0.37f}, 0.35f + 0.3f * noise(p, 1.5, 22));
      case Cover::garden_bed: {
        return mix(mood_.soil, mood_.foliage * 1.3f, smoothstep(0.0f, 0.5f, fractal(p, 0.9, 23, 2)));
      }
      case Cover::forest_floor:
        return mood_.forest_floor * (0.75f + 0.25f * fractal(p, 2.5, 24, 3));
      case Cover::paved:
      case Cover::drive:
      case Cover::apron: {
        const float tone = 0.52f + 0.22f * trait(area_id(detail), 25) + 0.03f * fractal(p, 1.0, 26, 3);
        const float red = 0.06f * trait(area_id(detail), 27);
        return {tone + red, tone, tone - 0.03f - 0.5f * red};
      }
      case Cover::gravel:
      case Cover::path: {
        if (source_.world != nullptr) return bare_ground(p);
        const float tone = 0.58f + 0.06f * fractal(p, 0.8, 28, 3);
        return mix({tone, tone * 0.95f, tone * 0.86f}, grass(p, 0.0f, 0.5f), smoothstep(0.1f, 0.7f, noise(p, 0.7, 29)));
      }
      case Cover::sidewalk: {
        const float edge = scene_.road_edge_m.at(col, row);
        const float tone = (edge < 0.18f ? 0.70f : 0.60f) + 0.03f * fractal(p, 0.7, 30, 3);
        return {tone, tone * 0.985f, tone * 0.96f};
      }
      case Cover::parking:
        return parking(source_.objects.areas[detail].polygon.outer, p);
      case Cover::gravel_trap: {
        const float tone = 0.66f + 0.05f * fractal(p, 1.2, 34, 3) + 0.03f * noise(p, 12.0, 35);
        return {tone, tone * 0.94f, tone * 0.82f};
      }
      case Cover::kerb:
        return kerb(col, row, p);
      case Cover::pool:
        return Rgb{0.36f, 0.66f, 0.74f} * (1.0f + 0.05f * noise(p, 0.8, 33));
      case Cover::water: {
        const float ripple = 0.02f * fractal(p, 1.6, 31, 2) + 0.02f * noise(p, 25.0, 32);
        return {mood_.water[0] + ripple, mood_.water[1] + ripple, mood_.water[2] + ripple};
      }
      default:
        return landmark_ground(scene_.cover.at(col, row), detail, p);
    }
  }

  /// Covers that only landmarks have.
  [[nodiscard]] Rgb landmark_ground(Cover cover, std::uint16_t detail, Vec2 p) const {
    switch (cover) {
      case Cover::snow:
        return grey(0.91f + 0.03f * fractal(p, 6.0, 110, 3) + 0.02f * noise(p, 0.7, 111));
      case Cover::dirt: {
        const float ruts = 0.08f * fractal(p, 3.0, 112, 4) + 0.05f * noise(p, 0.6, 113);
        return mood_.soil * (1.0f + ruts);
      }
      case Cover::debris: {  // stones of half a metre, with gaps in the shade
        const float stone =
            unit_hash(static_cast<int>(std::floor(p.x / 0.5)), static_cast<int>(std::floor(p.y / 0.5)), seed_ + 114);
        return grey(0.42f + 0.30f * stone + 0.05f * fractal(p, 3.0, 115, 2));
      }
      case Cover::rock: {
        const float crack = std::abs(fractal(p, 3.5, 116, 3)) < 0.03f ? 0.75f : 1.0f;
        const float tone = (0.55f + 0.10f * fractal(p, 9.0, 117, 4)) * crack;
        return {tone * 1.02f, tone, tone * 0.95f};
      }
      case Cover::river: {  // streaks along the current, foam here and there
        const float streak = 0.03f * fractal({p.x / 4.0, p.y}, 1.2, 118, 3);
        const float foam = smoothstep(0.55f, 0.8f, fractal(p, 1.4, 119, 3));
        return mix({0.20f + streak, 0.27f + streak, 0.25f + streak}, grey(0.8f), 0.6f * foam);
      }
      case Cover::rails:
        return rails(source_.objects.areas[detail].polygon.outer, p);
      case Cover::orchard:
        return grass(p, 0.2f, 0.2f);
      case Cover::barrier: {  // stacks of tyres, some painted
        const float tyre =
            unit_hash(static_cast<int>(std::floor(p.x / 0.7)), static_cast<int>(std::floor(p.y / 0.7)), seed_ + 120);
        return tyre > 0.75f ? Rgb{0.78f, 0.78f, 0.76f} : grey(0.10f + 0.08f * tyre);
      }
      default:
        return grey(0.5f);
    }
  }

  /// Ballast, sleepers, and the steel of two tracks along the area's first edge.
  [[nodiscard]] Rgb rails(const Ring& c, Vec2 p) const {
    constexpr double gauge_m = 1.435, tracks_m = 4.0, sleeper_m = 2.6;
    const Vec2 along = normalized(c[1] - c[0]), inward = normalized(c[3] - c[0]);
    const double s = dot(p - c[0], along), d = dot(p - c[0], inward) - 0.5 * distance(c[0], c[3]);
    const double from_track = std::abs(std::abs(d) - 0.5 * tracks_m), pixel = scene_.frame.gsd_m;
    const float stones = 0.06f * fractal(p, 0.6, 121, 2);
    Rgb color{0.46f + stones, 0.42f + stones, 0.38f + stones};
    if (from_track < 0.5 * sleeper_m && std::abs(std::remainder(s, 0.65)) < 0.13) color = color * 0.8f;
    const double rail = std::abs(from_track - 0.5 * gauge_m);
    if (rail < 0.5 * (0.08 + pixel)) color = mix(color, grey(0.70f), static_cast<float>(std::min(1.0, 0.2 / pixel)));
    return color;
  }

  /// Red and white in turn, along the road that it edges.
  [[nodiscard]] Rgb kerb(int col, int row, Vec2 p) const {
    const auto segment = static_cast<std::size_t>(scene_.road_segment.at(col, row));
    const RoadSample &a = source_.road_samples[segment], &b = source_.road_samples[segment + 1];
    const double along = a.s_m + dot(p - a.p, normalized(b.p - a.p));
    const bool red = std::fmod(along + 1000.0, 3.0) < 1.5;
    return (red ? Rgb{0.66f, 0.18f, 0.16f} : Rgb{0.84f, 0.83f, 0.80f}) * (1.0f + 0.08f * noise(p, 0.6, 36));
  }

  /// Trodden or gravelled, with grass where nobody walks.
  [[nodiscard]] Rgb bare_ground(Vec2 p) const {
    const float tone = 1.0f + 0.07f * fractal(p, 4.0, 37, 4) + 0.05f * fractal(p, 0.8, 28, 2);
    const Rgb soil = mix(mood_.gravel, mood_.dirt, 0.5f + 0.4f * noise(p, 20.0, 38));
    return mix(soil * tone, grass(p, 0.3f, 0.3f), 0.8f * smoothstep(0.15f, 0.6f, fractal(p, 7.0, 29, 4)));
  }

  /// `hue` < 0 lush, > 0 dry; `care` 1 = even lawn, 0 = patchy.
  [[nodiscard]] Rgb grass(Vec2 p, float hue, float care) const {
    const float patches = (1.0f - 0.6f * care) * fractal(p, 14.0, 40, 4), blades = fractal(p, 0.6, 41, 2);
    const float dryness = std::clamp(mood_.dryness + 0.35f * hue + 0.45f * patches, 0.0f, 0.85f);
    return mix(mood_.grass, mood_.dry, dryness) * (1.0f + 0.05f * blades + 0.05f * fractal(p, 4.0, 42, 2));
  }

  [[nodiscard]] Rgb field(Vec2 p, std::uint16_t number) const {
    const int thing = number;
    const float turn = 6.283f * trait(thing, 50);
    const double across = std::cos(turn) * p.x + std::sin(turn) * p.y;
    const float patches = fractal(p, 35.0, 51, 4), grain = fractal(p, 0.8, 52, 2);
    Rgb color;
    double row_m = 1.2;
    float row_depth = 0.03f;
    if (source_.world != nullptr) {
      const FieldLook& look = field_look(*source_.world, number);
      color = look.color, row_m = look.row_m, row_depth = look.row_depth;
    } else {
      switch (static_cast<Crop>(thing % crop_count)) {
        case Crop::wheat:
          color = {0.31f, 0.40f, 0.21f};
          break;
        case Crop::rape:
          color = {0.62f, 0.59f, 0.22f};
          row_depth = 0.02f;
          break;
        case Crop::ploughed:
          color = {0.47f, 0.38f, 0.29f}, row_m = 2.4, row_depth = 0.07f;
          break;
        case Crop::stubble:
          color = {0.64f, 0.56f, 0.40f}, row_m = 3.0, row_depth = 0.05f;
          break;
        case Crop::maize:
          color = {0.27f, 0.36f, 0.18f}, row_m = 0.75, row_depth = 0.08f;
          break;
        case Crop::hay:
          color = mood_.grass, row_m = 4.0, row_depth = 0.04f;
          break;
      }
    }
    for (std::size_t i = 0; i < 3; ++i) color[i] *= 0.93f + 0.14f * trait(thing, 53 + static_cast<std::uint32_t>(i));
    const auto wave = static_cast<float>(std::sin(2.0 * std::numbers::pi * across / row_m + 0.5 * noise(p, 9.0, 56)));
    float shade = 1.0f + 0.09f * patches + 0.06f * grain + row_depth * wave;
    // Tramlines: the wheel tracks of the sprayer, every 21 m.
    const double in_tramline = std::abs(std::remainder(across + 0.4 * noise(p, 30.0, 57), 21.0));
    if (std::abs(in_tramline - 0.95) < 0.25) shade *= 1.13f;
    return color * shade;
  }

  [[nodiscard]] Rgb asphalt(Vec2 p, float tone) const {
    const float blotches = 0.045f * fractal(p, 9.0, 60, 4),
                stones = 0.035f * signed_hash(static_cast<int>(std::floor(p.x / 0.17)),
                                              static_cast<int>(std::floor(p.y / 0.17)), seed_ + 61);
    float value = tone * (1.0f + blotches + stones);
    // Cracks: where a slow noise passes through zero.
    const float crack = std::abs(fractal(p, 5.0, 62, 3));
    if (crack < 0.012f && noise(p, 22.0, 63) > 0.1f) value *= 0.80f;
    return {value * 1.005f, value, value * 0.985f};
  }

  [[nodiscard]] Rgb parking(const Ring& c, Vec2 p) const {
    const Vec2 along = normalized(c[1] - c[0]), inward = normalized(c[3] - c[0]);
    const double s = dot(p - c[0], along), d = dot(p - c[0], inward), depth = distance(c[0], c[3]);
    Rgb color = asphalt(p, mood_.asphalt + 0.05f);
    const bool in_bay = d < 5.0 || d > depth - 5.0;
    if (in_bay && std::abs(std::remainder(s, 2.5)) < 0.5 * 0.12 + 0.25 * scene_.frame.gsd_m)
      color = mix(color, grey(0.85f), 0.65f);
    return color;
  }

  [[nodiscard]] Rgb road(int col, int row, Vec2 p) const {
    const auto segment = static_cast<std::size_t>(scene_.road_segment.at(col, row));
    const RoadSample &a = source_.road_samples[segment], &b = source_.road_samples[segment + 1];
    const PlannedRoad& plan = source_.plan.roads[a.road];
    const Vec2 d = b.p - a.p;
    const double n = length(d), part = dot(p - a.p, d) / (n * n);
    const double s = a.s_m + part * (b.s_m - a.s_m), t = cross(d, p - a.p) / n;
    const bool bridge = a.bridge || b.bridge;
    if (plan.pavement != Pavement::plain) return paved_road(plan, a.road, {p, s, t}, col, row);

    float tone = mood_.asphalt + mood_.asphalt_spread * (2.0f * trait(a.road, 70) - 1.0f);
    // Resurfaced stretches, then smaller repairs of a lane.
    const int stretch = static_cast<int>(std::floor(s / 140.0 + 0.3 * trait(a.road, 71)));
    tone += 0.6f * mood_.asphalt_spread * signed_hash(stretch, a.road, seed_ + 72);
    const int patch_s = static_cast<int>(std::floor(s / 7.0)), patch_t = static_cast<int>(std::floor(t / 2.6));
    if (unit_hash(patch_s, patch_t * 64 + a.road, seed_ + 73) < 0.05f)
      tone *= 0.90f + 0.16f * unit_hash(patch_s, patch_t, seed_ + 74);
    if (bridge) tone += 0.05f;
    // Wheel tracks are polished lighter, oil darkens the middle of the lane.
    const double lane = plan.oneway || plan.lanes < 2 ? 0.0 : 0.25 * plan.width_at(s);
    const auto from_lane =
        static_cast<float>(plan.highway == "motorway" ? from_motorway_lane(plan, t) : std::abs(std::abs(t) - lane));
    tone *= 1.0f + 0.025f * std::exp(-8.0f * (from_lane - 0.8f) * (from_lane - 0.8f)) -
            0.03f * std::exp(-6.0f * from_lane * from_lane);
    Rgb color = asphalt({p.x, p.y}, tone);
    // Dust and moss along the edge.
    const float edge = scene_.road_edge_m.at(col, row);
    const float dirt = smoothstep(-0.9f, 0.0f, edge + 0.35f * noise(p, 1.1, 75));
    color = mix(color, {0.53f, 0.50f, 0.43f}, 0.45f * dirt);
    const float paint = marking(plan, s, t, col, row) * (0.62f + 0.25f * noise(p, 2.0, 76) + 0.08f * noise(p, 0.3, 77));
    return mix(color, {0.93f, 0.93f, 0.91f}, std::clamp(paint, 0.0f, 1.0f));
  }

  /// Of a site with a world.
  [[nodiscard]] Rgb paved_road(const PlannedRoad& plan, int number, PavedPlace at, int col, int row) const {
    at.width_m = plan.width_at(at.s_m), at.edge_m = scene_.road_edge_m.at(col, row), at.road = number;
    at.lane_m = plan.oneway || plan.lanes < 2 || at.width_m < 4.5 ? 0.0 : 0.25 * at.width_m;
    at.pixel_m = scene_.frame.gsd_m;
    Rgb color = pavement_color(plan.pavement, at, mood_, seed_);
    if (plan.pavement == Pavement::gravel || plan.pavement == Pavement::dirt) return color;
    const float dirt = smoothstep(-0.7f, 0.0f, at.edge_m + 0.35f * noise(at.p, 1.1, 75));
    color = mix(color, mix(mood_.gravel, mood_.grass, 0.3f), 0.4f * dirt * trait(number, 78));
    const float paint = marking(plan, at.s_m, at.t_m, col, row) * mood_.paint * (0.4f + 0.6f * trait(number, 79)) *
                        (0.75f + 0.25f * noise(at.p, 2.0, 76) + 0.08f * noise(at.p, 0.3, 77));
    const Rgb white{0.93f, 0.93f, 0.91f}, yellow{0.86f, 0.70f, 0.24f};
    const bool middle = std::abs(at.t_m) < 0.2 * at.width_m && !plan.oneway;
    return mix(color, mood_.yellow_center && middle ? yellow : white, std::clamp(paint, 0.0f, 1.0f));
  }

  [[nodiscard]] static double from_motorway_lane(const PlannedRoad& road, double t) {
    const double from_left = 0.5 * road.width_m - motorway_strip_m - t;
    const int lane = std::clamp(static_cast<int>(std::floor(from_left / motorway_lane_m)), 0, road.lanes - 1);
    return std::abs(from_left - (lane + 0.5) * motorway_lane_m);
  }

  /// Share of the pixel that is road paint.
  [[nodiscard]] float marking(const PlannedRoad& road, double s, double t, int col, int row) const {
    const bool motorway = road.highway == "motorway", track = is_raceway(road.highway),
               link = road.highway == "motorway_link";
    if (road.highway != "secondary" && road.highway != "tertiary" && !motorway && !track && !link) return 0.0f;
    const bool junction = scene_.road_count.at(col, row) > 1;
    const bool circuit = source_.plan.circuit && &road == &source_.plan.roads[*source_.plan.circuit];
    if (junction && road.highway == "tertiary" && !circuit) return 0.0f;
    if (junction && (link || road.roundabout)) return 0.0f;
    const double pixel = scene_.frame.gsd_m;
    const auto line = [&](double offset, double width) {
      return static_cast<float>(
          std::clamp((0.5 * (width + pixel) - std::abs(t - offset)) / pixel, 0.0, std::min(1.0, width / pixel)));
    };
    const double period = road.highway == "secondary" ? 12.0 : 9.0;
    const auto dashed = [&](double every_m, double dash_m) { return s - every_m * std::floor(s / every_m) < dash_m; };
    float paint = 0.0f;
    if (motorway) {  // strip, lanes, shoulder from left to right; where a slip road joins, the shoulder's line is
                     // broken
      const double left = 0.5 * road.width_m - motorway_strip_m;
      paint = line(left, 0.15);
      for (int lane = 1; lane < road.lanes; ++lane)
        if (dashed(18.0, 6.0)) paint = std::max(paint, line(left - lane * motorway_lane_m, 0.15));
      if (!junction || dashed(6.0, 3.0)) paint = std::max(paint, line(left - road.lanes * motorway_lane_m, 0.3));
      return paint;
    }
    if (track && circuit && s < 1.0) return 0.9f;  // start and finish
    if (!track && !link && !road.roundabout && dashed(period, period / 3.0)) paint = line(0.0, 0.13);
    if (!junction) {
      const double edge = 0.5 * road.width_at(s) - 0.25;
      paint = std::max({paint, line(edge, 0.15), line(-edge, 0.15)});
    }
    return paint;
  }

  [[nodiscard]] Rgb roof(const House& house, Vec2 p) const {
    const std::int32_t number = house.id;
    const Vec2 d = p - house.center, along{std::cos(house.heading_rad), std::sin(house.heading_rad)};
    const double u = dot(d, along), v = cross(along, d);
    float shade = 1.0f + 0.05f * fractal(p, 3.0, 80, 3) +
                  0.03f * signed_hash(static_cast<int>(p.x * 6.0), static_cast<int>(p.y * 6.0), seed_ + 81);
    if (house.roof == RoofShape::flat) {
      const bool rim = house.half_length_m - std::abs(u) < 0.3 || house.half_width_m - std::abs(v) < 0.3;
      return house.color * (rim ? shade * 1.15f : shade);
    }
    shade *= 1.0f + 0.04f * static_cast<float>(std::sin(2.0 * std::numbers::pi * v / 0.7));  // rows of tiles
    if (std::abs(v) < 0.2) shade *= 1.08f;                                                   // ridge
    // Roof windows, a chimney, on some roofs solar panels.
    const int cell = static_cast<int>(std::floor(u / 2.2));
    if (trait(number, 82) < 0.5f && std::abs(std::abs(v) - 0.5 * house.half_width_m) < 0.5 &&
        std::abs(u - 2.2 * cell - 1.1) < 0.4 && unit_hash(cell, number, seed_ + 83) < 0.4f)
      return {0.25f, 0.28f, 0.32f};
    if (std::abs(u - (trait(number, 84) - 0.5f) * house.half_length_m) < 0.35 && std::abs(v - 0.8) < 0.35)
      return {0.50f, 0.40f, 0.36f};
    if (trait(number, 85) < 0.15f && v > 0.15 * house.half_width_m && v < 0.8 * house.half_width_m &&
        std::abs(u) < 0.65 * house.half_length_m)
      return {0.13f, 0.15f, 0.22f};
    return house.color * shade;
  }

  [[nodiscard]] Rgb crown(const Tree& tree, Vec2 p) const {
    const std::int32_t number = tree.id;
    Rgb color = tree.conifer ? mood_.conifer : mood_.foliage;
    if (tree.leaves == Leaves::autumn) {
      constexpr std::array<Rgb, 4> leaves{
          {{0.60f, 0.48f, 0.18f}, {0.55f, 0.34f, 0.15f}, {0.44f, 0.25f, 0.16f}, {0.48f, 0.44f, 0.20f}}};
      color = leaves[hash_lattice(number, 95, seed_) % leaves.size()];
    }
    const float warm = trait(number, 90) - 0.5f, light = 0.85f + 0.35f * trait(number, 91);
    color = {color[0] * (1.0f + 0.22f * warm), color[1] * (1.0f + 0.06f * warm), color[2] * (1.0f - 0.15f * warm)};
    if (tree.radius_m > 1.0 && source_.world == nullptr && trait(number, 92) < 0.015f)
      color = {0.36f, 0.22f, 0.20f};  // copper beech
    const auto d = static_cast<float>(distance(p, tree.center) / tree.radius_m);
    return color * (light * (1.0f - 0.25f * d * d) * (1.0f + 0.22f * fractal(p, 0.9, 93, 3)));
  }

  [[nodiscard]] static Rgb car(const Car& car, Vec2 p) {
    const Vec2 d = p - car.center, along{std::cos(car.heading_rad), std::sin(car.heading_rad)};
    const double u = dot(d, along) / car.half_length_m, v = std::abs(cross(along, d)) / car.half_width_m;
    const bool glass = car.half_length_m < 2.6 && v < 0.8 && ((u > 0.18 && u < 0.45) || (u > -0.75 && u < -0.5));
    return glass ? Rgb{0.16f, 0.18f, 0.20f} : car.color * (v > 0.85 ? 0.85f : 1.0f);
  }

  const SceneSource& source_;
  const SceneRaster& scene_;
  const Mood& mood_;
  ObjectCounts counts_;
  std::uint32_t seed_;
  Vec3 sun_;
  Raster<std::uint8_t> lit_;
  Raster<float> terrain_shade_;
};

/// The camera: haze, contrast, tint, blur of the optics and noise of the sensor, row by row. `site_row`: which
/// pixels of the site the row has; of the light there is a pixel more on both sides.
void develop(const std::array<const std::vector<Rgb>*, 3>& rows, const Mood& mood, std::uint32_t seed,
             const PixelBox& site_row, int row, Raster<std::uint8_t>& rgb) {
  const std::array blur{mood.blur, 1.0f - 2.0f * mood.blur, mood.blur};
  const auto site_y = static_cast<std::int32_t>(site_row.row);
  for (int col = 0; col < rgb.width; ++col) {
    const auto site_x = static_cast<std::int32_t>(site_row.col) + col;
    Rgb sum{};
    for (std::size_t j = 0; j < 3; ++j)
      for (int i = -1; i <= 1; ++i)
        sum =
            sum + (*rows[j])[static_cast<std::size_t>(col + i + 1)] * (blur[j] * blur[static_cast<std::size_t>(i + 1)]);
    const float grain =
        signed_hash(site_x, site_y, seed + 100) + signed_hash(site_x, site_y, seed + 101);  // triangular, sigma 0.82
    for (int c = 0; c < 3; ++c) {
      float value = sum[static_cast<std::size_t>(c)];
      value = (value - 0.45f) * mood.contrast + 0.45f;
      value = value * mood.gain * mood.tint[static_cast<std::size_t>(c)] * (1.0f - mood.haze) +
              mood.haze * mood.haze_color[static_cast<std::size_t>(c)];
      const float chroma = signed_hash(site_x, site_y, seed + 102 + static_cast<std::uint32_t>(c));
      value += mood.noise_sigma * (grain + 0.6f * chroma);
      rgb.at(col, row, c) = static_cast<std::uint8_t>(std::clamp(value * 255.0f + 0.5f, 0.0f, 255.0f));
    }
  }
}
}  // namespace

Raster<std::uint8_t> paint_ortho(const SceneSource& source, const SceneRaster& scene, const PixelBox& box,
                                 int threads) {
  const Mood mood = make_mood(source.seed, source.world);
  const Painter painter(source, scene, mood);
  const GridFrame& frame = scene.frame;
  const int first_col = static_cast<int>(box.col) - frame.first_col,
            first_row = static_cast<int>(box.row) - frame.first_row;  // of the box in the scene
  Raster<std::uint8_t> rgb(box.width, box.height, 3);
  constexpr int band_rows = 64;
  parallel_for(static_cast<std::size_t>((box.height + band_rows - 1) / band_rows), threads, [&](std::size_t band) {
    const int first = static_cast<int>(band) * band_rows, end = std::min(box.height, first + band_rows);
    std::array<std::vector<Rgb>, 3> window;  // rows with a pixel more on both sides
    const auto slot = [](int row) { return static_cast<std::size_t>((row + 3) % 3); };
    const auto fill = [&](int row) {
      std::vector<Rgb>& line = window[slot(row)];
      line.resize(static_cast<std::size_t>(box.width) + 2);
      for (int col = -1; col <= box.width; ++col)
        line[static_cast<std::size_t>(col + 1)] = painter.light(std::clamp(first_col + col, 0, frame.width - 1),
                                                                std::clamp(first_row + row, 0, frame.height - 1));
    };
    fill(first - 1), fill(first);
    for (int row = first; row < end; ++row) {
      fill(row + 1);
      develop({&window[slot(row - 1)], &window[slot(row)], &window[slot(row + 1)]}, mood, source.seed,
              {box.col, box.row + row, box.width, 1}, row, rgb);
    }
  });
  return rgb;
}

}  // namespace orthodrive::synth

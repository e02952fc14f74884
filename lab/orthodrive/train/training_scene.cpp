// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/training_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/segment/mirror_beyond.hpp"
#include "orthodrive/segment/resample_photo.hpp"
#include "orthodrive/train/disturb_photo.hpp"

namespace orthodrive {
namespace {

/// Source pixel coordinates of crop pixel (col, row): origin + col * right + row * down.
struct Placement {
  Vec2 origin, right, down;
};

Placement draw_placement(const TrainingScene& scene, const CropOptions& options, Random& random) {
  const Augmentation& vary = options.augmentation;
  const double zoom = vary.zoom ? std::exp(random.uniform(std::log(scene.min_zoom), std::log(scene.max_zoom))) : 1.0;
  const double step = options.gsd_m / scene.gsd_m / zoom;  // source pixels a crop pixel
  const double turn = random.uniform(0.0, 4.0);
  const double angle = 0.5 * std::numbers::pi *
                       (vary.turn == Augmentation::Turn::any        ? turn
                        : vary.turn == Augmentation::Turn::quarters ? std::floor(turn)
                                                                    : 0.0);
  const Vec2 right{step * std::cos(angle), step * std::sin(angle)};
  const bool mirrored = vary.mirror && random.uniform() >= 0.5;
  const Vec2 down = left_normal(right) * (mirrored ? -1.0 : 1.0);  // to the left: rows are counted downwards
  // Centres keep a quarter of the crop inside the photo, so that few crops are mostly empty.
  const double margin = std::min({0.25 * step * options.size_px, 0.5 * scene.rgb.width, 0.5 * scene.rgb.height});
  const Vec2 center{random.uniform(margin, scene.rgb.width - margin),
                    random.uniform(margin, scene.rgb.height - margin)};
  return {center - (right + down) * (0.5 * (options.size_px - 1)), right, down};
}

/// Lines of the scene in the crop's pixels, as far as they may come near it.
std::vector<RoadLine> placed(const std::vector<RoadLine>& lines, const Placement& place, int size) {
  const double step = length(place.right);
  const Box2 near = Box2{0.0, 0.0, static_cast<double>(size), static_cast<double>(size)}.grown(map_reach_px);
  std::vector<RoadLine> result;
  for (const RoadLine& line : lines) {
    RoadLine in_crop{{}, line.half_width / step};
    for (const Vec2 p : line.points) {
      const Vec2 from_origin = p - place.origin;
      in_crop.points.push_back(
          Vec2{dot(from_origin, place.right), dot(from_origin, place.down)} * (1.0 / (step * step)) + Vec2{0.5, 0.5});
    }
    if (bounds_of(in_crop.points).overlaps(near)) result.push_back(std::move(in_crop));
  }
  return result;
}

/// Adds the photo at p (pixel edges at whole numbers), bilinear, mirrored beyond its edges.
void add_sample(const Raster<std::uint8_t>& rgb, Vec2 p, std::array<float, 3>& sum) {
  const double x = p.x - 0.5, y = p.y - 0.5;
  const auto left = static_cast<std::int64_t>(std::floor(x)), top = static_cast<std::int64_t>(std::floor(y));
  const auto u = static_cast<float>(x - static_cast<double>(left)),
             v = static_cast<float>(y - static_cast<double>(top));
  const bool inside = left >= 0 && top >= 0 && left + 1 < rgb.width && top + 1 < rgb.height;
  const auto pixel = [&](std::int64_t col, std::int64_t row) {
    if (!inside) col = mirrored_index(col, rgb.width), row = mirrored_index(row, rgb.height);
    return &rgb.at(static_cast<int>(col), static_cast<int>(row));
  };
  const std::uint8_t *const a = pixel(left, top), *const b = pixel(left + 1, top), *const c = pixel(left, top + 1),
                            *const d = pixel(left + 1, top + 1);
  for (std::size_t i = 0; i < 3; ++i) {
    const float upper = static_cast<float>(a[i]) * (1.0F - u) + static_cast<float>(b[i]) * u;
    const float lower = static_cast<float>(c[i]) * (1.0F - u) + static_cast<float>(d[i]) * u;
    sum[i] += upper * (1.0F - v) + lower * v;
  }
}

/// A crop pixel is the mean of as many samples as it covers source pixels: what is finer than the crop averages out, as
/// it does where prediction resamples a photo. Beyond the photo's edges it is mirrored, as prediction does (labels,
/// too). `beyond`: those pixels.
Crop cut(const TrainingScene& scene, int size, const Placement& place, std::vector<std::size_t>& beyond) {
  Crop crop{Raster<std::uint8_t>(size, size, 3, no_photo_value), Raster<ClassSet>(size, size, 1, unknown_class),
            placed(scene.map, place, size)};
  const int samples = std::max(1, static_cast<int>(std::lround(length(place.right))));
  const float share = 1.0F / static_cast<float>(samples * samples);
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) {
      std::array<float, 3> sum{};
      for (int i = 0; i < samples * samples; ++i) {
        const int across = i % samples, along = i / samples;
        const double right = (across + 0.5) / samples - 0.5, down = (along + 0.5) / samples - 0.5;
        add_sample(scene.rgb, place.origin + place.right * (col + right) + place.down * (row + down), sum);
      }
      for (int c = 0; c < 3; ++c)
        crop.rgb.at(col, row, c) =
            static_cast<std::uint8_t>(std::floor(sum[static_cast<std::size_t>(c)] * share + 0.5F));
      const Vec2 p = place.origin + place.right * col + place.down * row;
      const auto x = static_cast<std::int64_t>(std::floor(p.x)), y = static_cast<std::int64_t>(std::floor(p.y));
      const auto from_col = mirrored_index(x, scene.rgb.width), from_row = mirrored_index(y, scene.rgb.height);
      crop.allowed.at(col, row) = scene.allowed.at(static_cast<int>(from_col), static_cast<int>(from_row));
      if (from_col != x || from_row != y) beyond.push_back(static_cast<std::size_t>(row * size + col));
    }
  }
  return crop;
}

/// value -> 255 * gain * (contrast * (value/255 - 1/2) + 1/2) ^ gamma, another gain for each channel.
void disturb_colors(Raster<std::uint8_t>& rgb, Random& random) {
  const double brightness = random.uniform(0.75, 1.25), contrast = random.uniform(0.8, 1.25),
               gamma = random.uniform(0.8, 1.25);
  for (int c = 0; c < 3; ++c) {
    const double gain = brightness * random.uniform(0.92, 1.08);
    std::array<std::uint8_t, 256> table{};
    for (int value = 0; value < 256; ++value) {
      const double stretched = std::clamp(contrast * (value / 255.0 - 0.5) + 0.5, 0.0, 1.0);
      table[static_cast<std::size_t>(value)] =
          static_cast<std::uint8_t>(std::clamp(255.0 * gain * std::pow(stretched, gamma), 0.0, 255.0));
    }
    for (std::size_t i = static_cast<std::size_t>(c); i < rgb.data.size(); i += 3) rgb.data[i] = table[rgb.data[i]];
  }
}

void add_noise(Raster<std::uint8_t>& rgb, Random& random) {
  const double amplitude = random.uniform(2.0, 10.0);
  for (std::uint8_t& value : rgb.data) {
    value = static_cast<std::uint8_t>(std::clamp(value + amplitude * (random.uniform() - 0.5), 0.0, 255.0));
  }
}

}  // namespace

Crop draw_crop(const TrainingScene& scene, const CropOptions& options, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::size_t> beyond;
  Crop crop = cut(scene, options.size_px, draw_placement(scene, options, random), beyond);
  const Augmentation& vary = options.augmentation;
  if (vary.blur && random.uniform() < 0.3) blur(crop.rgb);
  if (vary.domain > 0.0)
    disturb_domain(crop.rgb, vary.domain, random);
  else if (vary.colors)
    disturb_colors(crop.rgb, random);
  if (vary.noise && random.uniform() < 0.3) add_noise(crop.rgb, random);
  if (scene.map.empty() && random.uniform() < 0.5) return crop;
  for (const std::size_t pixel : beyond) {  // as where a photo has no data; a map of its own is not mirrored
    crop.allowed.data[pixel] = unknown_class;
    for (std::size_t c = 0; c < 3; ++c) crop.rgb.data[3 * pixel + c] = no_photo_value;
  }
  return crop;
}

std::size_t draw_scene(const std::vector<TrainingScene>& scenes, std::int64_t step, std::uint64_t seed) {
  const auto weight = [&](const TrainingScene& scene) { return scene.from_step <= step ? scene.weight : 0.0; };
  double total = 0.0;
  for (const TrainingScene& scene : scenes) total += weight(scene);
  if (total <= 0.0) throw OptionError("no training scene is in use at step " + std::to_string(step));
  double left = Random(seed).uniform() * total;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (weight(scenes[i]) <= 0.0) continue;
    chosen = i;
    left -= weight(scenes[i]);
    if (left < 0.0) break;
  }
  return chosen;
}

}  // namespace orthodrive

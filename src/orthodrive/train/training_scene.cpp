#include "orthodrive/train/training_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/random.hpp"
#include "orthodrive/segment/resample_photo.hpp"

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
  const Vec2 down = vary.mirror && random.uniform() < 0.5 ? left_normal(right) : left_normal(right) * -1.0;
  // Centres keep a quarter of the crop inside the photo, so that few crops are mostly empty.
  const double margin = std::min({0.25 * step * options.size_px, 0.5 * scene.rgb.width, 0.5 * scene.rgb.height});
  const Vec2 center{random.uniform(margin, scene.rgb.width - margin),
                    random.uniform(margin, scene.rgb.height - margin)};
  return {center - (right + down) * (0.5 * (options.size_px - 1)), right, down};
}

Crop cut(const TrainingScene& scene, int size, const Placement& place) {
  Crop crop{Raster<std::uint8_t>(size, size, 3, no_photo_value), Raster<ClassSet>(size, size, 1, unknown_class)};
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size; ++col) {
      const Vec2 p = place.origin + place.right * col + place.down * row;  // pixel edges at whole numbers
      const double x = p.x - 0.5, y = p.y - 0.5;
      const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
      if (left < 0 || top < 0 || left + 1 >= scene.rgb.width || top + 1 >= scene.rgb.height) continue;
      const auto u = static_cast<float>(x - left), v = static_cast<float>(y - top);
      const std::uint8_t* upper = &scene.rgb.at(left, top);
      const std::uint8_t* lower = &scene.rgb.at(left, top + 1);
      for (int c = 0; c < 3; ++c) {
        const float a = static_cast<float>(upper[c]) * (1.0F - u) + static_cast<float>(upper[c + 3]) * u;
        const float b = static_cast<float>(lower[c]) * (1.0F - u) + static_cast<float>(lower[c + 3]) * u;
        crop.rgb.at(col, row, c) = static_cast<std::uint8_t>(a * (1.0F - v) + b * v + 0.5F);
      }
      crop.allowed.at(col, row) = scene.allowed.at(static_cast<int>(p.x), static_cast<int>(p.y));
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

void blur(Raster<std::uint8_t>& rgb) {  // 1 2 1 binomial, both ways
  const auto pass = [&rgb](int count, int lines, int step, int line_step) {
    for (int line = 0; line < lines; ++line) {
      std::uint8_t* p = rgb.data.data() + static_cast<std::ptrdiff_t>(line) * line_step;
      std::array<int, 3> before{p[0], p[1], p[2]};
      for (int i = 0; i + 1 < count; ++i, p += step) {
        for (int c = 0; c < 3; ++c) {
          const int here = p[c];
          p[c] = static_cast<std::uint8_t>((before[static_cast<std::size_t>(c)] + 2 * here + p[c + step] + 2) / 4);
          before[static_cast<std::size_t>(c)] = here;
        }
      }
    }
  };
  pass(rgb.width, rgb.height, 3, 3 * rgb.width);
  pass(rgb.height, rgb.width, 3 * rgb.width, 3);
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
  Crop crop = cut(scene, options.size_px, draw_placement(scene, options, random));
  const Augmentation& vary = options.augmentation;
  if (vary.blur && random.uniform() < 0.3) blur(crop.rgb);
  if (vary.colors) disturb_colors(crop.rgb, random);
  if (vary.noise && random.uniform() < 0.3) add_noise(crop.rgb, random);
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

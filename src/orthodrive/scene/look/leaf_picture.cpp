// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/look/leaf_picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "orthodrive/core/random.hpp"
#include "orthodrive/geo/vec.hpp"
#include "orthodrive/model/rasters/srgb.hpp"
#include "orthodrive/scene/look/surface_texture.hpp"

namespace orthodrive::scene {
namespace {

struct LeafTexel {
  float shade = 0.0F, warmth = 0.0F;
  bool is_opaque = false;
};

struct Leaf {
  Vec2 at;  ///< its middle, in sides of the box
  double angle_rad = 0.0, length = 0.1, width = 0.05;
  double shade = 1.0, warmth = 0.0;
};

class Canvas {
 public:
  explicit Canvas(int size_px) : texels_(size_px, size_px) {}

  void fill(const PictureBox& box, double shade) {
    each(box, {0.5, 0.5}, 1.0, [&](LeafTexel& texel, Vec2) { texel = {static_cast<float>(shade), 0.0F, true}; });
  }

  /// Pointed at both ends, lighter along its rib.
  void add(const PictureBox& box, const Leaf& leaf) {
    const Vec2 along{std::cos(leaf.angle_rad), std::sin(leaf.angle_rad)};
    each(box, leaf.at, leaf.length, [&](LeafTexel& texel, Vec2 p) {
      const double x = 2.0 * dot(along, p - leaf.at) / leaf.length, y = 2.0 * cross(along, p - leaf.at) / leaf.width;
      if (std::abs(x) >= 1.0 || std::abs(y) > 1.0 - x * x) return;
      const double rib = std::abs(y) < 0.15 ? 0.12 : 0.0, side = y > 0.0 ? 0.06 : -0.06;
      texel = {static_cast<float>(leaf.shade + rib + side), static_cast<float>(leaf.warmth), true};
    });
  }

  /// Streaks along the trunk.
  void add_bark(const PictureBox& box, Random& random) {
    fill(box, 0.8);
    for (int i = 0; i < 160; ++i)
      add(box, {.at = {random.uniform(), random.uniform()},
                .angle_rad = 0.5 * std::numbers::pi + random.uniform(-0.08, 0.08),
                .length = random.uniform(0.2, 0.6),
                .width = random.uniform(0.03, 0.08),
                .shade = random.uniform(0.5, 1.2)});
  }

  [[nodiscard]] Raster<std::uint8_t> picture() const {
    double sum = 0.0;
    std::size_t count = 0;
    for (const LeafTexel& texel : texels_.data)
      if (texel.is_opaque) sum += static_cast<double>(texel.shade), ++count;
    const double mean = sum / static_cast<double>(count);
    Raster<std::uint8_t> picture(texels_.width, texels_.height, 4);
    for (int row = 0; row < picture.height; ++row)
      for (int col = 0; col < picture.width; ++col) {
        const LeafTexel& texel = texels_.at(col, row);
        // Between leaves the picture has their mean: it shows at their rims.
        const double value = surface_texture_mean * (texel.is_opaque ? static_cast<double>(texel.shade) / mean : 1.0);
        for (int channel = 0; channel < 3; ++channel)
          picture.at(col, row, channel) = srgb_byte(value * (1.0 + (1 - channel) * static_cast<double>(texel.warmth)));
        picture.at(col, row, 3) = texel.is_opaque ? 255 : 0;
      }
    return picture;
  }

 private:
  /// Calls visit(texel, place in the box) within `reach` of a place.
  template <typename Visit>
  void each(const PictureBox& box, Vec2 at, double reach, const Visit& visit) {
    const double size = texels_.width, width = box.u1 - box.u0, height = box.v1 - box.v0;
    const auto range = [size](double low, double high, double from, double to) {
      return std::pair(static_cast<int>(std::ceil(std::max(low, from) * size - 0.5)),
                       static_cast<int>(std::ceil(std::min(high, to) * size - 0.5)));
    };
    const auto [col0, col1] = range(box.u0, box.u1, box.u0 + (at.x - reach) * width, box.u0 + (at.x + reach) * width);
    const auto [row0, row1] = range(box.v0, box.v1, box.v0 + (at.y - reach) * height, box.v0 + (at.y + reach) * height);
    for (int row = row0; row < row1; ++row)
      for (int col = col0; col < col1; ++col)
        visit(texels_.at(col, row),
              Vec2{((col + 0.5) / size - box.u0) / width, ((row + 0.5) / size - box.v0) / height});
  }

  Raster<LeafTexel> texels_;
};

/// What lies in front is lit, what lies behind is in its shadow.
double depth_shade(int i, int count, Random& random) {
  return 0.55 + 0.6 * static_cast<double>(i) / count + random.uniform(-0.08, 0.08);
}

void add_cluster(Canvas& canvas, const PictureBox& box, int leaves, double length, Random& random) {
  constexpr double radius = 0.41;
  for (int i = 0; i < leaves; ++i) {
    const double from_middle = radius * std::sqrt(random.uniform()), turn = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double own = length * random.uniform(0.8, 1.2);
    canvas.add(box, {.at = Vec2{0.5, 0.5} + Vec2{std::cos(turn), std::sin(turn)} * from_middle,
                     .angle_rad = turn + random.uniform(-1.2, 1.2),
                     .length = own,
                     .width = 0.55 * own,
                     .shade = depth_shade(i, leaves, random),
                     .warmth = random.uniform(-0.04, 0.10)});
  }
}

void add_dense(Canvas& canvas, const PictureBox& box, Random& random) {
  canvas.fill(box, 0.5);
  constexpr int leaves = 500;
  for (int i = 0; i < leaves; ++i)
    canvas.add(box, {.at = {random.uniform(), random.uniform()},
                     .angle_rad = random.uniform(0.0, 2.0 * std::numbers::pi),
                     .length = 0.13,
                     .width = 0.07,
                     .shade = depth_shade(i, leaves, random),
                     .warmth = random.uniform(-0.04, 0.10)});
}

/// Twigs to both sides of a stem, shorter towards its tip, with needles along them.
void add_twig(Canvas& canvas, const PictureBox& box, Random& random) {
  constexpr int twigs = 15, needles = 16;
  constexpr double slant_rad = 0.9, needle_rad = 0.6;
  for (int layer = 0; layer < 2; ++layer)
    for (int i = 0; i < twigs; ++i)
      for (const double side : {-1.0, 1.0}) {
        const double x = 0.03 + 0.9 * (i + 0.5 * layer) / twigs,
                     length = 0.06 + 0.5 * (1.0 - x) * random.uniform(0.85, 1.0);
        const double angle = side * (slant_rad + random.uniform(-0.15, 0.15));
        const Vec2 way{std::cos(angle), std::sin(angle)};
        const double shade = 0.65 + 0.35 * layer + random.uniform(-0.1, 0.1);
        for (int k = 0; k < needles; ++k) {
          const Vec2 at = Vec2{x, 0.5} + way * (length * (k + 0.5) / needles);
          for (const double turn : {-needle_rad, needle_rad})
            canvas.add(box, {.at = at,
                             .angle_rad = angle + turn,
                             .length = 0.07,
                             .width = 0.022,
                             .shade = shade + 0.2 * k / needles});
        }
      }
  canvas.add(box, {.at = {0.48, 0.5}, .angle_rad = 0.0, .length = 0.96, .width = 0.03, .shade = 0.5});
}

}  // namespace

Raster<std::uint8_t> leaf_picture(int size_px) {
  Canvas canvas(size_px);
  Random random(181);
  constexpr double margin = 0.02;  // of what is opaque around its box
  const auto with_margin = [](const PictureBox& box) {
    return PictureBox{box.u0 - margin, box.v0 - margin, box.u1 + margin, box.v1 + margin};
  };
  add_dense(canvas, with_margin(dense_leaves_box), random);
  canvas.add_bark(with_margin(bark_box), random);
  add_cluster(canvas, broad_leaves_box, 330, 0.105, random);
  add_cluster(canvas, small_leaves_box, 620, 0.075, random);
  add_twig(canvas, needles_box, random);
  return canvas.picture();
}

}  // namespace orthodrive::scene

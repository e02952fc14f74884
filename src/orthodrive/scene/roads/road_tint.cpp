// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_tint.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/model/rasters/srgb.hpp"

namespace orthodrive::scene {
namespace {

constexpr double tint_cell_m = 8.0, along_m = 2.0, across_m = 1.0;
constexpr double edge_m = 0.5;  // from the road's edge, whose pixels are half of the verge
constexpr LinearColor no_photo = {0.12F, 0.12F, 0.12F};

using TintCell = std::array<int, 2>;

TintCell cell_of(Vec2 p) {
  return {static_cast<int>(std::floor(p.x / tint_cell_m)), static_cast<int>(std::floor(p.y / tint_cell_m))};
}

int brightness_of(const Rgb& c) { return 2 * c[0] + 5 * c[1] + c[2]; }

using Samples = std::map<TintCell, std::vector<Rgb>>;

void sample_strip(const std::vector<CrossSection>& strip, const Photo& photo, Samples& samples) {
  for (std::size_t i = 1; i < strip.size(); ++i) {
    const CrossSection &a = strip[i - 1], &b = strip[i];
    const auto plan = [](const Vec3& v) { return Vec2{v.x, v.y}; };
    const int parts = std::max(1, static_cast<int>(std::ceil((b.s_m - a.s_m) / along_m)));
    for (int k = 0; k < parts; ++k) {
      const double u = (k + 0.5) / parts;
      const Vec2 left = plan(a.left) * (1.0 - u) + plan(b.left) * u;
      const Vec2 right = plan(a.right) * (1.0 - u) + plan(b.right) * u;
      const double width_m = distance(left, right);
      if (width_m < 2.5 * edge_m) continue;
      const int columns = std::max(1, static_cast<int>((width_m - 2.0 * edge_m) / across_m));
      for (int c = 0; c < columns; ++c) {
        const double v = (edge_m + (c + 0.5) * (width_m - 2.0 * edge_m) / columns) / width_m;
        const Vec2 p = left * (1.0 - v) + right * v;
        if (const auto pixel = pixel_at(photo, p)) samples[cell_of(p)].push_back(*pixel);
      }
    }
  }
}

}  // namespace

LinearColor as_asphalt(const LinearColor& color) {
  const auto [low, high] = std::ranges::minmax(color);
  const float mean = (color[0] + color[1] + color[2]) / 3.0F;
  const float share = high > low ? std::min(1.0F, asphalt_chroma * mean / (high - low)) : 1.0F;
  LinearColor grey{};
  for (std::size_t c = 0; c < 3; ++c) grey[c] = mean + share * (color[c] - mean);
  return grey;
}

std::optional<Rgb> pixel_at(const Photo& photo, Vec2 p) {
  const Vec2 at = photo.frame.pixel_from_world(p);
  const int col = static_cast<int>(std::floor(at.x)), row = static_cast<int>(std::floor(at.y));
  if (!photo.valid.inside(col, row) || !photo.valid.at(col, row)) return std::nullopt;
  return Rgb{photo.rgb.at(col, row, 0), photo.rgb.at(col, row, 1), photo.rgb.at(col, row, 2)};
}

LinearColor median_color(std::vector<Rgb>& pixels) {
  if (pixels.empty()) return no_photo;
  const auto middle = pixels.begin() + static_cast<std::ptrdiff_t>(pixels.size() / 2);
  std::nth_element(pixels.begin(), middle, pixels.end(), [](const Rgb& a, const Rgb& b) {
    return std::pair(brightness_of(a), a) < std::pair(brightness_of(b), b);
  });
  const auto& linear = linear_values();
  return {linear[(*middle)[0]], linear[(*middle)[1]], linear[(*middle)[2]]};
}

RoadTint::RoadTint(std::span<const RoadLevel* const> levels, const Photo& photo) {
  Samples samples;
  for (const RoadLevel* level : levels)
    for (const auto& strip : level->strips()) sample_strip(strip, photo, samples);
  std::vector<Rgb> around;
  for (const auto& [cell, own] : samples) {
    around.clear();
    for (int k = 0; k < 9; ++k)
      if (const auto found = samples.find({cell[0] + k % 3 - 1, cell[1] + k / 3 - 1}); found != samples.end())
        around.insert(around.end(), found->second.begin(), found->second.end());
    cells_[cell] = median_color(around);
  }
}

LinearColor RoadTint::at(Vec2 p) const {
  const Vec2 at = {p.x / tint_cell_m - 0.5, p.y / tint_cell_m - 0.5};
  const int x0 = static_cast<int>(std::floor(at.x)), y0 = static_cast<int>(std::floor(at.y));
  LinearColor sum{};
  float total = 0.0F;
  for (int k = 0; k < 4; ++k) {
    const int x = x0 + k % 2, y = y0 + k / 2;
    const auto found = cells_.find({x, y});
    if (found == cells_.end()) continue;
    const auto w = static_cast<float>((1.0 - std::abs(at.x - x)) * (1.0 - std::abs(at.y - y)));
    for (std::size_t c = 0; c < 3; ++c) sum[c] += w * found->second[c];
    total += w;
  }
  if (!(total > 1e-6F)) return no_photo;
  for (float& v : sum) v /= total;
  return sum;
}

LinearColor photo_mean(const Photo& photo, Vec2 p, double size_m) {
  const Vec2 low = photo.frame.pixel_from_world({p.x - 0.5 * size_m, p.y + 0.5 * size_m});
  const int size_px = std::max(1, static_cast<int>(std::lround(size_m / photo.frame.gsd_m)));
  const int col = static_cast<int>(std::lround(low.x)), row = static_cast<int>(std::lround(low.y));
  const auto& linear = linear_values();
  std::array<double, 3> sum{};
  int count = 0;
  for (int r = row; r < row + size_px; ++r) {
    for (int c = col; c < col + size_px; ++c) {
      if (!photo.valid.inside(c, r) || !photo.valid.at(c, r)) continue;
      for (int channel = 0; channel < 3; ++channel)
        sum[static_cast<std::size_t>(channel)] += static_cast<double>(linear[photo.rgb.at(c, r, channel)]);
      ++count;
    }
  }
  if (count == 0) return no_photo;
  return {static_cast<float>(sum[0] / count), static_cast<float>(sum[1] / count), static_cast<float>(sum[2] / count)};
}

LinearColor photo_median(const Photo& photo, const Polygon& polygon) {
  return photo_median(photo, polygon, [](Vec2) { return true; }).value_or(no_photo);
}

std::optional<LinearColor> photo_median(const Photo& photo, const Polygon& polygon,
                                        const std::function<bool(Vec2)>& counts) {
  std::vector<Rgb> pixels;
  const GridFrame frame = covering_grid(bounds_of(polygon.outer), 1.0);
  rasterize(polygon, frame, [&](int row, int begin, int end) {
    for (int col = begin; col < end; ++col)
      if (const Vec2 p = frame.center_of(col, row); counts(p))
        if (const auto pixel = pixel_at(photo, p)) pixels.push_back(*pixel);
  });
  if (pixels.empty()) return std::nullopt;
  return median_color(pixels);
}

}  // namespace orthodrive::scene

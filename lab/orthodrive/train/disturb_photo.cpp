// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/train/disturb_photo.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace orthodrive {
namespace {

std::uint8_t byte_of(double value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)); }

// ---- JPEG ------------------------------------------------------------------------------------------------------

using CosineCell = std::array<float, 64>;
using QuantTable = std::array<int, 64>;

// ITU-T T.81, tables K.1 and K.2.
constexpr QuantTable luminance_table{16, 11, 10, 16, 24,  40,  51,  61,  12, 12, 14, 19, 26,  58,  60,  55,
                                     14, 13, 16, 24, 40,  57,  69,  56,  14, 17, 22, 29, 51,  87,  80,  62,
                                     18, 22, 37, 56, 68,  109, 103, 77,  24, 35, 55, 64, 81,  104, 113, 92,
                                     49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99};
constexpr QuantTable chrominance_table{17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99,
                                       24, 26, 56, 99, 99, 99, 99, 99, 47, 66, 99, 99, 99, 99, 99, 99,
                                       99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
                                       99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99};

/// Entries scaled to the quality as the Independent JPEG Group's encoder does.
QuantTable scaled(const QuantTable& table, int quality) {
  const int q = std::clamp(quality, 1, 100), percent = q < 50 ? 5000 / q : 200 - 2 * q;
  QuantTable result{};
  for (std::size_t i = 0; i < 64; ++i) result[i] = std::clamp((table[i] * percent + 50) / 100, 1, 255);
  return result;
}

/// Row u: the cosine of frequency u, orthonormal.
CosineCell make_cosines() {
  CosineCell cosines{};
  for (std::size_t u = 0; u < 8; ++u)
    for (std::size_t x = 0; x < 8; ++x)
      cosines[8 * u + x] = static_cast<float>(
          (u == 0 ? std::sqrt(0.125) : 0.5) *
          std::cos((2.0 * static_cast<double>(x) + 1.0) * static_cast<double>(u) * std::numbers::pi / 16.0));
  return cosines;
}

/// a * b, or a^T * b, of 8 x 8 matrices.
CosineCell product(const CosineCell& a, const CosineCell& b, bool first_transposed) {
  CosineCell result{};
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t k = 0; k < 8; ++k) {
      const float factor = first_transposed ? a[8 * k + i] : a[8 * i + k];
      for (std::size_t j = 0; j < 8; ++j) result[8 * i + j] += factor * b[8 * k + j];
    }
  return result;
}

CosineCell transposed(const CosineCell& a) {
  CosineCell result{};
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j) result[8 * j + i] = a[8 * i + j];
  return result;
}

void quantise(CosineCell& values, const QuantTable& table) {
  static const CosineCell cosines = make_cosines();
  const CosineCell half = product(cosines, values, false);
  CosineCell frequencies = transposed(product(cosines, transposed(half), false));  // C V C^T
  for (std::size_t i = 0; i < 64; ++i) {
    const auto step = static_cast<float>(table[i]);
    frequencies[i] = std::round(frequencies[i] / step) * step;
  }
  const CosineCell back = product(cosines, frequencies, true);
  values = transposed(product(cosines, transposed(back), true));  // C^T F C
}

/// Every cell of 8 x 8 values of a plane; cells at the border repeat the last row and column.
void quantise_plane(Raster<float>& plane, const QuantTable& table) {
  for (int top = 0; top < plane.height; top += 8) {
    for (int left = 0; left < plane.width; left += 8) {
      CosineCell cell{};
      for (int row = 0; row < 8; ++row)
        for (int col = 0; col < 8; ++col)
          cell[static_cast<std::size_t>(8 * row + col)] =
              plane.at(std::min(left + col, plane.width - 1), std::min(top + row, plane.height - 1));
      quantise(cell, table);
      for (int row = 0; row < std::min(8, plane.height - top); ++row)
        for (int col = 0; col < std::min(8, plane.width - left); ++col)
          plane.at(left + col, top + row) = cell[static_cast<std::size_t>(8 * row + col)];
    }
  }
}

/// Means of 2 x 2 values, quantised, each put back on its four.
void quantise_halved(Raster<float>& plane, const QuantTable& table) {
  Raster<float> half((plane.width + 1) / 2, (plane.height + 1) / 2, 1);
  const auto inside = [&](int col, int row) {
    return plane.at(std::min(col, plane.width - 1), std::min(row, plane.height - 1));
  };
  for (int row = 0; row < half.height; ++row)
    for (int col = 0; col < half.width; ++col)
      half.at(col, row) = 0.25F * (inside(2 * col, 2 * row) + inside(2 * col + 1, 2 * row) +
                                   inside(2 * col, 2 * row + 1) + inside(2 * col + 1, 2 * row + 1));
  quantise_plane(half, table);
  for (int row = 0; row < plane.height; ++row)
    for (int col = 0; col < plane.width; ++col) plane.at(col, row) = half.at(col / 2, row / 2);
}

}  // namespace

void change_colors(Raster<std::uint8_t>& rgb, const ColorChange& change) {
  // Saturation and hue as one matrix: a turn by hue_rad around the grey axis (Rodrigues), scaled across it.
  const double across = change.saturation * std::cos(change.hue_rad) / 3.0,
               turned = change.saturation * std::sin(change.hue_rad) / std::numbers::sqrt3;
  const double own = 1.0 / 3.0 + 2.0 * across, next = 1.0 / 3.0 - across - turned, last = 1.0 / 3.0 - across + turned;
  std::array<std::array<std::uint8_t, 256>, 3> tables{};
  for (std::size_t c = 0; c < 3; ++c)
    for (int value = 0; value < 256; ++value) {
      const double stretched = std::clamp(change.contrast * (value / 255.0 - 0.5) + 0.5, 0.0, 1.0);
      tables[c][static_cast<std::size_t>(value)] = byte_of(255.0 * change.gain[c] * std::pow(stretched, change.gamma));
    }
  for (std::size_t i = 0; i + 2 < rgb.data.size(); i += 3) {
    const double r = rgb.data[i], g = rgb.data[i + 1], b = rgb.data[i + 2];
    rgb.data[i] = tables[0][byte_of(own * r + next * g + last * b)];
    rgb.data[i + 1] = tables[1][byte_of(last * r + own * g + next * b)];
    rgb.data[i + 2] = tables[2][byte_of(next * r + last * g + own * b)];
  }
}

void fade_green(Raster<std::uint8_t>& rgb, double share) {
  for (std::size_t i = 0; i + 2 < rgb.data.size(); i += 3) {
    const double excess = rgb.data[i + 1] - 0.5 * (rgb.data[i] + rgb.data[i + 2]);
    if (excess <= 0.0) continue;
    rgb.data[i] = byte_of(rgb.data[i] + 0.5 * share * excess);
    rgb.data[i + 1] = byte_of(rgb.data[i + 1] - share * excess);
  }
}

void add_haze(Raster<std::uint8_t>& rgb, double density) {
  constexpr std::array<double, 3> air_light{200.0, 210.0, 225.0};
  for (std::size_t i = 0; i < rgb.data.size(); ++i)
    rgb.data[i] = byte_of((1.0 - density) * rgb.data[i] + density * air_light[i % 3]);
}

void blur(Raster<std::uint8_t>& rgb) {
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

void sharpen(Raster<std::uint8_t>& rgb, double amount) {
  Raster<std::uint8_t> soft = rgb;
  blur(soft);
  for (std::size_t i = 0; i < rgb.data.size(); ++i)
    rgb.data[i] = byte_of(rgb.data[i] + amount * (rgb.data[i] - soft.data[i]));
}

void compress(Raster<std::uint8_t>& rgb, int quality) {
  // JFIF's Y Cb Cr, all three around 0.
  std::array<Raster<float>, 3> planes{Raster<float>(rgb.width, rgb.height, 1), Raster<float>(rgb.width, rgb.height, 1),
                                      Raster<float>(rgb.width, rgb.height, 1)};
  for (std::size_t i = 0; i < planes[0].data.size(); ++i) {
    const float r = rgb.data[3 * i], g = rgb.data[3 * i + 1], b = rgb.data[3 * i + 2];
    planes[0].data[i] = 0.299F * r + 0.587F * g + 0.114F * b - 128.0F;
    planes[1].data[i] = -0.168736F * r - 0.331264F * g + 0.5F * b;
    planes[2].data[i] = 0.5F * r - 0.418688F * g - 0.081312F * b;
  }
  quantise_plane(planes[0], scaled(luminance_table, quality));
  quantise_halved(planes[1], scaled(chrominance_table, quality));
  quantise_halved(planes[2], scaled(chrominance_table, quality));
  for (std::size_t i = 0; i < planes[0].data.size(); ++i) {
    const double y = planes[0].data[i] + 128.0, cb = planes[1].data[i], cr = planes[2].data[i];
    rgb.data[3 * i] = byte_of(y + 1.402 * cr);
    rgb.data[3 * i + 1] = byte_of(y - 0.344136 * cb - 0.714136 * cr);
    rgb.data[3 * i + 2] = byte_of(y + 1.772 * cb);
  }
}

void cast_shadow(Raster<std::uint8_t>& rgb, const Shadow& shadow) {
  const double area = cross(shadow.side, shadow.reach);
  if (area == 0.0) return;
  const std::array<double, 3> light{shadow.light, shadow.light, shadow.light + 0.15 * (1.0 - shadow.light)};
  for (int row = 0; row < rgb.height; ++row) {
    for (int col = 0; col < rgb.width; ++col) {
      const Vec2 p = Vec2{col + 0.5, row + 0.5} - shadow.corner;
      const double along = cross(p, shadow.reach) / area, away = cross(shadow.side, p) / area;
      if (along < 0.0 || along > 1.0 || away < 0.0 || away > 1.0) continue;
      for (int c = 0; c < 3; ++c)
        rgb.at(col, row, c) = byte_of(light[static_cast<std::size_t>(c)] * rgb.at(col, row, c));
    }
  }
}

void disturb_domain(Raster<std::uint8_t>& rgb, double strength, Random& random) {
  const auto happens = [&](double share) { return random.uniform() < share * strength; };
  const auto about_one = [&](double low, double high) { return std::exp(strength * random.uniform(low, high)); };
  if (happens(0.4)) fade_green(rgb, strength * random.uniform());
  if (happens(0.3)) {
    const double sun = random.uniform(0.0, 2.0 * std::numbers::pi), light = random.uniform(0.3, 0.65);
    for (std::uint64_t left = 1 + random.below(8); left > 0; --left) {
      const double wall = sun + random.uniform(0.25, 0.75) * std::numbers::pi, length = random.uniform(10.0, 80.0),
                   reach = random.uniform(5.0, 40.0);
      cast_shadow(rgb, {{random.uniform(0.0, rgb.width), random.uniform(0.0, rgb.height)},
                        {length * std::cos(wall), length * std::sin(wall)},
                        {reach * std::cos(sun), reach * std::sin(sun)},
                        light});
    }
  }
  ColorChange change{.saturation = happens(0.05) ? 0.0 : about_one(-0.7, 0.4),
                     .hue_rad = strength * random.uniform(-0.25, 0.25),
                     .contrast = about_one(-0.35, 0.35),
                     .gamma = about_one(-0.4, 0.4)};
  const double brightness = about_one(-0.35, 0.3);
  for (double& gain : change.gain) gain = brightness * about_one(-0.15, 0.15);
  change_colors(rgb, change);
  if (happens(0.25)) add_haze(rgb, strength * random.uniform(0.05, 0.4));
  if (happens(0.3)) {
    for (std::uint64_t passes = 1 + random.below(4); passes > 0; --passes) blur(rgb);
  } else if (happens(0.25)) {
    sharpen(rgb, strength * random.uniform(0.5, 2.5));
  }
  if (happens(0.3)) compress(rgb, static_cast<int>(random.uniform(20.0, 85.0)));
}

}  // namespace orthodrive

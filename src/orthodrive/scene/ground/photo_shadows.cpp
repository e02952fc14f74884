// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/ground/photo_shadows.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "orthodrive/core/median.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/model/rasters/srgb.hpp"

namespace orthodrive::scene {
namespace {

constexpr float least_light = 1e-3F;        // added before logarithms: a byte's step in the dark
constexpr double soft_m = 1.0;              // over this distance to each side the strength is a mean
constexpr float weak = 0.4F, full = 0.75F;  // of the way from sunlit to shaded: where lifting begins and is whole

using Tone = PhotoShadows::Tone;

float luminance(const LinearColor& c) { return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2]; }

LinearColor linear_of(const std::uint8_t* rgb) {
  const auto& linear = linear_values();
  return {linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]};
}

const std::array<float, 256>& log_values() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::log2(linear_values()[i] + least_light);
    return values;
  }();
  return table;
}

float log_ratio(const std::uint8_t* rgb, std::size_t over) { return log_values()[rgb[2]] - log_values()[rgb[over]]; }
float log_luminance(const LinearColor& color) { return std::log2(luminance(color) + least_light); }

Tone tone_of(const LinearColor& c) {
  const auto blue_over = [&](std::size_t k) { return std::log2((c[2] + least_light) / (c[k] + least_light)); };
  return {blue_over(0), log_luminance(c), blue_over(1)};
}

/// How far a pixel is on the way from sunlit to shaded: 0 and 1 at the two. The least of all signs. Dark crops are dark
/// and have little red, but as much green over blue as in the sun; that ratio changes less, so it counts less.
float shade(const Tone& sunlit, const Tone& shaded, const std::uint8_t* rgb) {
  constexpr float noise = 0.25F;
  const auto part = [&](float value, std::size_t k) { return (value - sunlit[k]) / (shaded[k] - sunlit[k]); };
  const float by_red = part(log_ratio(rgb, 0), 0);
  if (by_red <= weak) return by_red;  // most pixels
  return std::min({by_red, part(log_luminance(linear_of(rgb)), 1), part(log_ratio(rgb, 1), 2) + noise});
}

bool is_lifted(Role role) { return role != Role::water && role != Role::vegetation; }

/// Labels of a window of the photo, pixel by pixel; label_nodata beyond the labels.
Raster<std::uint8_t> labels_in(const LabelSource& labels, const GridFrame& photo, const PixelBox& box) {
  Raster<std::uint8_t> result(box.width, box.height, 1, label_nodata);
  const auto at = [&](std::int64_t col, std::int64_t row) {
    const Vec2 p = photo.world_from_pixel(static_cast<double>(col) + 0.5, static_cast<double>(row) + 0.5);
    const Vec2 pixel = labels.frame.pixel_from_world(p);
    return std::pair(static_cast<std::int64_t>(std::floor(pixel.x)), static_cast<std::int64_t>(std::floor(pixel.y)));
  };
  const auto first = at(box.col, box.row), last = at(box.end_col() - 1, box.end_row() - 1);
  const PixelBox part =
      intersection(pixels_of(labels.frame), {first.first, first.second, static_cast<int>(last.first - first.first) + 1,
                                             static_cast<int>(last.second - first.second) + 1});
  if (part.empty()) return result;
  const Raster<std::uint8_t> read = labels.read(part);
  std::vector<std::int64_t> cols(static_cast<std::size_t>(box.width));
  for (int c = 0; c < box.width; ++c) cols[static_cast<std::size_t>(c)] = at(box.col + c, box.row).first - part.col;
  for (int r = 0; r < box.height; ++r) {
    const std::int64_t row = at(box.col, box.row + r).second - part.row;
    if (row < 0 || row >= part.height) continue;
    for (int c = 0; c < box.width; ++c) {
      const std::int64_t col = cols[static_cast<std::size_t>(c)];
      if (col >= 0 && col < part.width) result.at(c, r) = read.at(static_cast<int>(col), static_cast<int>(row));
    }
  }
  return result;
}

struct Sample {
  PhotoWindow photo;
  Raster<std::uint8_t> labels;
};

std::vector<Sample> samples_of(const PhotoSource& photo, const LabelSource& labels, int threads) {
  constexpr int a_side = 8, size_px = 256;
  std::vector<Sample> samples(a_side * a_side);
  const int width = std::min(size_px, photo.frame.width), height = std::min(size_px, photo.frame.height);
  if (width == 0 || height == 0) return {};
  parallel_for(samples.size(), threads, [&](std::size_t number) {
    const int i = static_cast<int>(number);
    const auto place = [&](int k, int length, int part) {
      return static_cast<std::int64_t>(length - part) * k / (a_side - 1);
    };
    const PixelBox box{place(i % a_side, photo.frame.width, width), place(i / a_side, photo.frame.height, height),
                       width, height};
    samples[number] = {photo.read(box), labels_in(labels, photo.frame, box)};
  });
  return samples;
}

template <typename Visit>  // (pixel, label)
void for_each_pixel(const std::vector<Sample>& samples, const Visit& visit) {
  for (const Sample& sample : samples)
    for (std::size_t i = 0; i < sample.labels.data.size(); ++i)
      if (sample.photo.valid.data[i] != 0 && sample.labels.data[i] != label_nodata)
        visit(&sample.photo.rgb.data[3 * i], sample.labels.data[i]);
}

/// Two groups of tones by their means; the first is the brighter one.
struct Groups {
  std::array<Tone, 2> middle{};
  std::array<double, 2> count{};
  double apart = 0.0;   ///< both middles
  double spread = 0.0;  ///< standard deviation from the own middle along the line through both
};

Groups two_groups(const std::vector<Tone>& tones) {
  const auto at_share = [&](std::size_t channel, double share) {
    std::vector<float> values;
    values.reserve(tones.size());
    for (const Tone& tone : tones) values.push_back(tone[channel]);
    return at_rank(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
  };
  Groups groups;
  groups.middle = {Tone{at_share(0, 0.3), at_share(1, 0.7), at_share(2, 0.3)},
                   Tone{at_share(0, 0.99), at_share(1, 0.01), at_share(2, 0.99)}};
  const auto group_of = [&](const Tone& tone) -> std::size_t {
    const auto squared = [&](const Tone& m) {
      float sum = 0.0F;
      for (std::size_t k = 0; k < tone.size(); ++k) sum += (tone[k] - m[k]) * (tone[k] - m[k]);
      return sum;
    };
    return squared(groups.middle[1]) < squared(groups.middle[0]) ? 1 : 0;
  };
  constexpr int rounds = 20;
  for (int round = 0; round < rounds; ++round) {
    std::array<std::array<double, 3>, 2> sum{};
    groups.count = {};
    for (const Tone& tone : tones) {
      const std::size_t g = group_of(tone);
      for (std::size_t k = 0; k < tone.size(); ++k) sum[g][k] += static_cast<double>(tone[k]);
      groups.count[g] += 1.0;
    }
    for (std::size_t g = 0; g < 2; ++g)
      for (std::size_t k = 0; k < sum[g].size() && groups.count[g] > 0.0; ++k)
        groups.middle[g][k] = static_cast<float>(sum[g][k] / groups.count[g]);
  }
  std::array<double, 3> line{};
  double squared = 0.0;
  for (std::size_t k = 0; k < line.size(); ++k) {
    line[k] = static_cast<double>(groups.middle[1][k] - groups.middle[0][k]);
    squared += line[k] * line[k];
  }
  groups.apart = std::sqrt(squared);
  for (const Tone& tone : tones) {
    const Tone& m = groups.middle[group_of(tone)];
    double along = 0.0;
    for (std::size_t k = 0; k < line.size(); ++k) along += static_cast<double>(tone[k] - m[k]) * line[k];
    groups.spread += along * along / std::max(squared, 1e-9);
  }
  groups.spread = std::sqrt(groups.spread / static_cast<double>(tones.size()));
  return groups;
}

/// How often each byte of each channel is there.
struct Histogram {
  std::array<std::array<std::uint64_t, 256>, 3> counts{};
  std::uint64_t total = 0;

  void add(const std::uint8_t* rgb) {
    for (std::size_t channel = 0; channel < 3; ++channel) ++counts[channel][rgb[channel]];
    ++total;
  }
  /// Linear light below which that share of the pixels is, by channel.
  [[nodiscard]] LinearColor at_share(double share) const {
    LinearColor color{};
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::uint64_t sum = 0;
      std::size_t value = 0;
      while (value < 255 && static_cast<double>(sum += counts[channel][value]) <= share * static_cast<double>(total))
        ++value;
      color[channel] = linear_values()[value];
    }
    return color;
  }
};

}  // namespace

std::optional<PhotoShadows> find_shadows(const PhotoSource& photo, const LabelSource& labels, int threads) {
  constexpr std::size_t least_tones = 1000, most_tones = 200000;
  constexpr double least_share = 0.01, least_separation = 3.0;  // of the shaded; in standard deviations
  constexpr float least_bluer = 0.4F, least_darker = 1.5F;      // log2
  constexpr float least_gain = 0.4F, most_gain = 1.25F, haze_share = 0.9F;
  constexpr std::uint64_t least_of_class = 500;

  const std::vector<Sample> samples = samples_of(photo, labels, threads);
  const std::vector<ClassInfo>& classes = labels.classes.classes;
  const auto role_of = [&](std::uint8_t label) { return label < classes.size() ? classes[label].role : Role::other; };
  std::vector<Tone> tones;
  Histogram all;
  for_each_pixel(samples, [&](const std::uint8_t* rgb, std::uint8_t label) {
    all.add(rgb);
    if (role_of(label) == Role::road) tones.push_back(tone_of(linear_of(rgb)));
  });
  if (tones.size() < least_tones) return std::nullopt;
  const std::size_t step = tones.size() / most_tones + 1;
  for (std::size_t i = 0; i * step < tones.size(); ++i) tones[i] = tones[i * step];
  tones.resize((tones.size() + step - 1) / step);
  const Groups groups = two_groups(tones);
  const auto [sunlit, shaded] = groups.middle;
  const float bluer = shaded[0] - sunlit[0], darker = sunlit[1] - shaded[1];
  if (groups.count[1] < least_share * static_cast<double>(tones.size()) || bluer < least_bluer ||
      darker < least_darker || shaded[2] <= sunlit[2] || groups.apart < least_separation * groups.spread)
    return std::nullopt;

  std::vector<std::array<Histogram, 2>> of_class(classes.size());
  std::array<Histogram, 2> of_roads;
  for_each_pixel(samples, [&](const std::uint8_t* rgb, std::uint8_t label) {
    const float at = shade(sunlit, shaded, rgb);
    if (label >= classes.size() || (at > 0.5F * weak && at <= weak)) return;
    const std::size_t side = at <= weak ? 0 : 1;
    of_class[label][side].add(rgb);
    if (role_of(label) == Role::road) of_roads[side].add(rgb);
  });
  PhotoShadows shadows{.haze = all.at_share(0.005)};
  for (float& v : shadows.haze) v *= haze_share;
  const auto gain_of = [&](const LinearColor& lit, const LinearColor& dark) {
    LinearColor gain{};
    for (std::size_t c = 0; c < 3; ++c)
      gain[c] = std::max(1.0F, (lit[c] - shadows.haze[c]) / std::max(dark[c] - shadows.haze[c], least_light));
    return gain;
  };
  const PhotoShadows::Class roads{sunlit, shaded, gain_of(of_roads[0].at_share(0.5), of_roads[1].at_share(0.5))};
  for (std::size_t k = 0; k < classes.size(); ++k) {
    PhotoShadows::Class& own = shadows.classes.emplace_back();
    if (!is_lifted(classes[k].role)) continue;
    own = roads;
    if (std::min(of_class[k][0].total, of_class[k][1].total) < least_of_class) continue;
    const LinearColor lit = of_class[k][0].at_share(0.5), dark = of_class[k][1].at_share(0.5);
    const Tone in_sun = tone_of(lit), in_shade = tone_of(dark);
    if (in_shade[0] - in_sun[0] < 0.5F * bluer || in_sun[1] - in_shade[1] < 0.5F * darker ||
        in_shade[2] - in_sun[2] < 0.5F * (shaded[2] - sunlit[2]))
      continue;
    own = {in_sun, in_shade, gain_of(lit, dark)};
    for (std::size_t c = 0; c < 3; ++c)
      own.gain[c] = std::clamp(own.gain[c], least_gain * roads.gain[c], most_gain * roads.gain[c]);
  }
  return shadows;
}

namespace {

/// Mean over a square of that radius; the values beyond the raster are not known, so its edge is cut off.
Raster<std::uint8_t> blurred(const Raster<std::uint8_t>& values, int radius) {
  const int size = 2 * radius + 1;
  Raster<std::uint8_t> result(values.width - 2 * radius, values.height - 2 * radius);
  std::vector<int> column_sums(static_cast<std::size_t>(values.width), 0);
  const auto add_row = [&](int row, int sign) {
    const std::uint8_t* line = &values.data[values.index(0, row)];
    for (std::size_t c = 0; c < column_sums.size(); ++c) column_sums[c] += sign * line[c];
  };
  for (int row = 0; row < size - 1; ++row) add_row(row, 1);
  for (int row = 0; row < result.height; ++row) {
    add_row(row + size - 1, 1);
    int sum = 0;
    for (int c = 0; c < size - 1; ++c) sum += column_sums[static_cast<std::size_t>(c)];
    for (int c = 0; c < result.width; ++c) {
      sum += column_sums[static_cast<std::size_t>(c + size - 1)];
      result.at(c, row) = static_cast<std::uint8_t>((sum + size * size / 2) / (size * size));
      sum -= column_sums[static_cast<std::size_t>(c)];
    }
    add_row(row, -1);
  }
  return result;
}

/// 0..255: how much of the gain a pixel takes, before it is a mean.
std::uint8_t strength_of(const PhotoShadows::Class& own, const std::uint8_t* rgb) {
  const float t = std::clamp((shade(own.sunlit, own.shaded, rgb) - weak) / (full - weak), 0.0F, 1.0F);
  return static_cast<std::uint8_t>(std::lround(255.0F * t * t * (3.0F - 2.0F * t)));
}

/// Gains of a class by strength.
using GainTable = std::array<LinearColor, 256>;

/// Mean of the 3 x 3 pixels around one that are not much brighter: lifting makes ten times more of the noise in the
/// dark. The pixel is not on the raster's edge.
LinearColor smoothed(const PhotoWindow& photo, int col, int row) {
  const auto sum_of = [](const std::uint8_t* rgb) { return int{rgb[0]} + rgb[1] + rgb[2]; };
  const int limit = 3 * sum_of(&photo.rgb.data[photo.rgb.index(col, row)]) / 2;
  LinearColor sum{};
  float count = 0.0F;
  for (int r = row - 1; r <= row + 1; ++r) {
    for (int c = col - 1; c <= col + 1; ++c) {
      const std::uint8_t* rgb = &photo.rgb.data[photo.rgb.index(c, r)];
      if (photo.valid.at(c, r) == 0 || sum_of(rgb) > limit) continue;
      const LinearColor color = linear_of(rgb);
      for (std::size_t k = 0; k < 3; ++k) sum[k] += color[k];
      count += 1.0F;
    }
  }
  for (float& v : sum) v /= count;
  return sum;
}

std::array<std::uint8_t, 3> lifted(const LinearColor& dark, const LinearColor& haze, const LinearColor& gain,
                                   float strength) {
  LinearColor light{};
  constexpr float least_share = 0.3F;  // of what is darker than the haze
  for (std::size_t c = 0; c < 3; ++c)
    light[c] = std::max((1.0F - strength * (1.0F - least_share)) * dark[c], dark[c] - strength * haze[c]) * gain[c];
  // In the darkest corners the haze is more than what is left of red: they would turn blue.
  light[2] = std::min(light[2], std::max({light[0], light[1], dark[2]}));
  return {srgb_byte(static_cast<double>(light[0])), srgb_byte(static_cast<double>(light[1])),
          srgb_byte(static_cast<double>(light[2]))};
}

}  // namespace

PhotoSource without_shadows(PhotoSource photo, LabelSource labels, PhotoShadows shadows) {
  std::vector<GainTable> tables;
  for (const auto& [sunlit, shaded, gain] : shadows.classes) {
    GainTable& table = tables.emplace_back();
    for (std::size_t s = 0; s < table.size(); ++s)
      for (std::size_t c = 0; c < 3; ++c) table[s][c] = std::pow(gain[c], static_cast<float>(s) / 255.0F);
  }
  const int radius = std::max(1, static_cast<int>(std::lround(soft_m / photo.frame.gsd_m)));
  PhotoSource result{.crs = photo.crs, .frame = photo.frame};
  result.read = [photo = std::move(photo), labels = std::move(labels), shadows = std::move(shadows),
                 tables = std::move(tables), radius](const PixelBox& box) {
    const PixelBox around = box.grown(radius);
    const PhotoWindow dark = photo.read(around);
    const Raster<std::uint8_t> classes = labels_in(labels, photo.frame, around);
    Raster<std::uint8_t> strength(around.width, around.height);
    const auto is_lifted_class = [&](std::uint8_t label) {
      return label < shadows.classes.size() && shadows.classes[label].is_lifted();
    };
    for (std::size_t i = 0; i < strength.data.size(); ++i)
      if (dark.valid.data[i] != 0 && is_lifted_class(classes.data[i]))
        strength.data[i] = strength_of(shadows.classes[classes.data[i]], &dark.rgb.data[3 * i]);
    strength = blurred(strength, radius);
    PhotoWindow window{Raster<std::uint8_t>(box.width, box.height, 3), Raster<std::uint8_t>(box.width, box.height)};
    for (int row = 0; row < box.height; ++row) {
      std::copy_n(&dark.rgb.data[dark.rgb.index(radius, row + radius)], 3 * static_cast<std::size_t>(box.width),
                  &window.rgb.data[window.rgb.index(0, row)]);
      std::copy_n(&dark.valid.data[dark.valid.index(radius, row + radius)], static_cast<std::size_t>(box.width),
                  &window.valid.data[window.valid.index(0, row)]);
      for (int col = 0; col < box.width; ++col) {
        const std::uint8_t s = strength.at(col, row), label = classes.at(col + radius, row + radius);
        if (s == 0 || window.valid.at(col, row) == 0 || !is_lifted_class(label)) continue;
        const auto rgb = lifted(smoothed(dark, col + radius, row + radius), shadows.haze, tables[label][s],
                                static_cast<float>(s) / 255.0F);
        std::ranges::copy(rgb, &window.rgb.data[window.rgb.index(col, row)]);
      }
    }
    return window;
  };
  return result;
}

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/rasters/photo_mosaic.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>

namespace orthodrive {
namespace {

constexpr double color_reach_m = 40.0;  // sigma of the Gaussian that smooths differences of colour; at least one cell
using Color = std::array<float, 3>;

constexpr double finest_cell_m = 4.0;  // of overviews: some metres tell colours of surfaces, not of single things
constexpr double most_cells = 1 << 21;
// An overview knows a rim to a cell: its weight is zero from there on.
constexpr double rim_cells = 1.5;
// At its rim a photo has no weight, but a place where all photos are at their rims needs a colour.
constexpr float least_weight = 1.0F / 1024.0F;

/// Width of the strip inside a photo's rim over which it fades.
double feather_m(double cell_m) { return std::max(15.0, 2.0 * cell_m); }

/// Distance of each cell from the nearest one without data, in cells, from centre to centre; at most `most` + 1.
Raster<float> cells_from_gaps(const Raster<std::uint8_t>& valid, int most) {
  const int width = valid.width, height = valid.height, far = most + 1;
  Raster<int> along_row(width, height);
  for (int row = 0; row < height; ++row) {
    int last = far;
    for (int col = 0; col < width; ++col)
      along_row.at(col, row) = last = valid.at(col, row) ? std::min(last + 1, far) : 0;
    last = far;
    for (int col = width - 1; col >= 0; --col) {
      last = valid.at(col, row) ? std::min(last + 1, far) : 0;
      along_row.at(col, row) = std::min(along_row.at(col, row), last);
    }
  }
  Raster<float> cells(width, height);
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col) {
      int squared = far * far;
      for (int other = std::max(0, row - most); other <= std::min(height - 1, row + most); ++other) {
        const int across = along_row.at(col, other), down = other - row;
        squared = std::min(squared, across * across + down * down);
      }
      cells.at(col, row) = std::sqrt(static_cast<float>(squared));
    }
  return cells;
}

/// 0 at the rim, 1 a feather inside of it.
Raster<float> weights_of(const Photo& overview) {
  const double feather_cells = feather_m(overview.frame.gsd_m) / overview.frame.gsd_m;
  Raster<float> weights = cells_from_gaps(overview.valid, static_cast<int>(std::ceil(feather_cells + rim_cells)));
  for (float& value : weights.data) {
    const float t = std::clamp((value - static_cast<float>(rim_cells)) / static_cast<float>(feather_cells), 0.0F, 1.0F);
    value = t * t * (3.0F - 2.0F * t);
  }
  return weights;
}

/// A place of the mosaic while photos are laid there, best first.
struct Blend {
  Color sum{};
  float weight = 0.0F, left = 1.0F;  ///< what the photos so far have, what is left for those below

  void add(const Color& color, float photo_weight) {
    constexpr float full = 0.9999F;  // interpolation of ones
    const float share = photo_weight >= full ? left : left * std::max(photo_weight, least_weight);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += share * color[c];
    weight += share;
    left -= share;
  }
  [[nodiscard]] bool settled() const { return left <= 0.0F; }
  [[nodiscard]] Color color() const { return {sum[0] / weight, sum[1] / weight, sum[2] / weight}; }
};

/// How a photo is brought to the colours of those above it.
struct ColorMatch {
  Color gain{1.0F, 1.0F, 1.0F}, offset{};  ///< of the whole photo; grey levels
  Raster<float> rest;                      ///< to add at a cell, grey levels, 3 channels; empty: zero

  [[nodiscard]] Color apply(const Color& color, const Color& rest_here) const {
    Color result{};
    for (std::size_t c = 0; c < 3; ++c)
      result[c] = std::clamp(gain[c] * color[c] + offset[c] + rest_here[c], 0.0F, 255.0F);
    return result;
  }
};

/// Along rows, then along columns; zero beyond the raster.
void blur(Raster<float>& raster, double sigma_cells) {
  const int radius = static_cast<int>(std::ceil(3.0 * sigma_cells)), channels = raster.channels;
  std::vector<float> kernel;
  double total = 0.0;
  for (int i = -radius; i <= radius; ++i) total += std::exp(-0.5 * i * i / (sigma_cells * sigma_cells));
  for (int i = -radius; i <= radius; ++i)
    kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_cells * sigma_cells)) / total));
  const float* middle = kernel.data() + radius;
  const auto add = [](float factor, const float* from, float* to, int count) {
    for (int i = 0; i < count; ++i) to[i] += factor * from[i];
  };
  Raster<float> rows(raster.width, raster.height, channels);
  for (int row = 0; row < raster.height; ++row)
    for (int shift = -radius; shift <= radius; ++shift) {
      const int first = std::max(0, -shift), end = std::min(raster.width, raster.width - shift);
      if (first < end)
        add(middle[shift], &raster.at(first + shift, row), &rows.at(first, row), (end - first) * channels);
    }
  std::ranges::fill(raster.data, 0.0F);
  for (int row = 0; row < raster.height; ++row)
    for (int other = std::max(0, row - radius); other <= std::min(raster.height - 1, row + radius); ++other)
      add(middle[other - row], &rows.at(0, other), &raster.at(0, row), raster.width * channels);
}

/// Values near black and white are cut off and say nothing of colours.
bool tells_colors(const Color& color) {
  constexpr float darkest = 4.0F, brightest = 251.0F;
  return std::ranges::all_of(color, [](float value) { return value >= darkest && value <= brightest; });
}

Color color_at(const Raster<std::uint8_t>& rgb, std::size_t cell) {
  const std::uint8_t* at = rgb.data.data() + 3 * cell;
  return {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])};
}

/// Sets gain and offset so that mean and deviation of the cells that both show become those of the photos above. The
/// ratio of deviations takes both photos alike; a regression would give less contrast where they differ.
void match_moments(const std::vector<Blend>& above, const Photo& photo, const std::vector<std::uint8_t>& common,
                   ColorMatch& match) {
  constexpr double fewest_cells = 100.0;  // of them the local difference alone is told
  constexpr double flat = 2.0;            // grey levels of deviation: noise, which says nothing of contrast
  constexpr double largest_gain = 1.5;    // beyond it the photos show different things
  for (std::size_t c = 0; c < 3; ++c) {
    double cells = 0.0, wanted = 0.0, given = 0.0, wanted_square = 0.0, given_square = 0.0;
    for (std::size_t cell = 0; cell < common.size(); ++cell) {
      if (!common[cell]) continue;
      const auto should = static_cast<double>(above[cell].color()[c]);
      const auto is = static_cast<double>(color_at(photo.rgb, cell)[c]);
      cells += 1.0, wanted += should, given += is, wanted_square += should * should, given_square += is * is;
    }
    if (cells < fewest_cells) return;
    const auto deviation = [cells](double sum, double square) {
      return std::sqrt(std::max(0.0, square / cells - sum / cells * (sum / cells)));
    };
    const double from = deviation(given, given_square), to = deviation(wanted, wanted_square);
    const double gain = from < flat || to < flat ? 1.0 : std::clamp(to / from, 1.0 / largest_gain, largest_gain);
    match.gain[c] = static_cast<float>(gain);
    match.offset[c] = static_cast<float>((wanted - gain * given) / cells);
  }
}

ColorMatch match_colors(const std::vector<Blend>& above, const Photo& photo) {
  constexpr float largest_difference = 64.0F;  // grey levels; beyond it, as under a cloud, the ground is not the same
  constexpr float support_for_half = 0.02F;    // share of the Gaussian over the overlap where the rest counts half
  std::vector<std::uint8_t> common(above.size());
  for (std::size_t cell = 0; cell < common.size(); ++cell)
    common[cell] = photo.valid.data[cell] && above[cell].weight > 0.0F && tells_colors(above[cell].color()) &&
                   tells_colors(color_at(photo.rgb, cell));
  ColorMatch match;
  if (!std::memchr(common.data(), 1, common.size())) return match;
  match_moments(above, photo, common, match);
  Raster<float> rest(photo.rgb.width, photo.rgb.height, 4);  // of each channel, and the cells that it comes from
  for (std::size_t cell = 0; cell < common.size(); ++cell) {
    if (!common[cell]) continue;
    const Color is = color_at(photo.rgb, cell), should = above[cell].color();
    for (std::size_t c = 0; c < 3; ++c)
      rest.data[4 * cell + c] =
          std::clamp(should[c] - match.gain[c] * is[c] - match.offset[c], -largest_difference, largest_difference);
    rest.data[4 * cell + 3] = 1.0F;
  }
  blur(rest, std::max(1.0, color_reach_m / photo.frame.gsd_m));
  match.rest = Raster<float>(photo.rgb.width, photo.rgb.height, 3);
  for (std::size_t cell = 0; cell < common.size(); ++cell)
    for (std::size_t c = 0; c < 3; ++c)
      match.rest.data[3 * cell + c] = rest.data[4 * cell + c] / (rest.data[4 * cell + 3] + support_for_half);
  return match;
}

/// A photo of the mosaic with all that was estimated on its overview.
struct Layer {
  PhotoSource photo;
  Raster<float> weights;
  ColorMatch match;
};

/// Where the centre of a pixel lies between the centres of two cells.
struct Tap {
  int first;
  float second_share;
};

class Mosaic {
 public:
  Mosaic(std::vector<MosaicPhoto> photos) : frame_(photos.front().photo.frame), cells_(photos.front().overview.frame) {
    std::vector<Blend> above(photos.front().overview.valid.data.size());
    for (MosaicPhoto& photo : photos) {
      assert(photo.photo.frame == frame_ && photo.overview.frame == cells_);
      Layer layer{std::move(photo.photo), weights_of(photo.overview), {}};
      if (!layers_.empty()) layer.match = match_colors(above, photo.overview);
      for (std::size_t cell = 0; cell < above.size(); ++cell)
        if (photo.overview.valid.data[cell]) {
          Color rest{};
          if (!layer.match.rest.empty()) std::copy_n(&layer.match.rest.data[3 * cell], 3, rest.begin());
          above[cell].add(layer.match.apply(color_at(photo.overview.rgb, cell), rest), layer.weights.data[cell]);
        }
      layers_.push_back(std::move(layer));
    }
  }
  [[nodiscard]] const GridFrame& frame() const { return frame_; }

  [[nodiscard]] PhotoWindow read(const PixelBox& box) const {
    PhotoWindow window = layers_.front().photo.read(box);
    const PixelBox wanted = intersection(box, pixels_of(frame_));
    if (wanted.empty()) return window;
    // The blocks in which photos are warped (io/raster/photo_read). Most of them need the first photo alone.
    constexpr int columns = 512, rows = 128;
    for (std::int64_t row = wanted.row / rows * rows; row < wanted.end_row(); row += rows)
      for (std::int64_t col = wanted.col / columns * columns; col < wanted.end_col(); col += columns)
        lay_photos(intersection(wanted, {col, row, columns, rows}), box, window);
    return window;
  }

 private:
  [[nodiscard]] Tap column_tap(std::int64_t col) const {
    const double west_m = frame_.west_m - cells_.west_m;
    return tap((west_m + (static_cast<double>(col) + 0.5) * frame_.gsd_m) / cells_.gsd_m - 0.5, cells_.width);
  }
  [[nodiscard]] Tap row_tap(std::int64_t row) const {
    const double north_m = cells_.north_m - frame_.north_m;
    return tap((north_m + (static_cast<double>(row) + 0.5) * frame_.gsd_m) / cells_.gsd_m - 0.5, cells_.height);
  }
  static Tap tap(double place, int cells) {
    const int first = std::clamp(static_cast<int>(std::floor(place)), 0, cells - 2);
    return {first, static_cast<float>(std::clamp(place - first, 0.0, 1.0))};
  }
  static float between(const Raster<float>& field, Tap col, Tap row, int channel = 0) {
    const auto along = [&](int at_row) {
      const float a = field.at(col.first, at_row, channel), b = field.at(col.first + 1, at_row, channel);
      return a + col.second_share * (b - a);
    };
    const float above = along(row.first), below = along(row.first + 1);
    return above + row.second_share * (below - above);
  }

  /// Nothing of the photos below the first is seen in the block.
  [[nodiscard]] bool hidden_by_first(const PixelBox& block, const PixelBox& box, const PhotoWindow& window) const {
    const Raster<float>& weights = layers_.front().weights;
    const Tap left = column_tap(block.col), right = column_tap(block.end_col() - 1), top = row_tap(block.row),
              bottom = row_tap(block.end_row() - 1);
    for (int row = top.first; row <= bottom.first + 1; ++row)
      for (int col = left.first; col <= right.first + 1; ++col)
        if (weights.at(col, row) < 1.0F) return false;
    for (std::int64_t row = block.row; row < block.end_row(); ++row)
      if (std::memchr(&window.valid.at(static_cast<int>(block.col - box.col), static_cast<int>(row - box.row)), 0,
                      static_cast<std::size_t>(block.width)))
        return false;
    return true;
  }

  void lay_photos(const PixelBox& block, const PixelBox& box, PhotoWindow& window) const {
    if (hidden_by_first(block, box, window)) return;
    std::vector<Blend> blends(static_cast<std::size_t>(block.width) * static_cast<std::size_t>(block.height));
    PixelBox open = lay(layers_.front(), window, box, block, block, blends);
    for (std::size_t i = 1; i < layers_.size() && !open.empty(); ++i)
      open = lay(layers_[i], layers_[i].photo.read(open), open, open, block, blends);
    const Blend* blend = blends.data();
    for (std::int64_t row = block.row; row < block.end_row(); ++row) {
      const int left = static_cast<int>(block.col - box.col), at_row = static_cast<int>(row - box.row);
      std::uint8_t *rgb = &window.rgb.at(left, at_row), *valid = &window.valid.at(left, at_row);
      for (int i = 0; i < block.width; ++i, ++blend, rgb += 3) {
        valid[i] = blend->weight > 0.0F ? 1 : 0;
        if (!valid[i]) continue;
        const Color color = blend->color();
        for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(std::lround(color[c]));
      }
    }
  }

  /// Lays the pixels of a photo in `part` of the block; `shown_box` is what `shown` shows. Returns the box of the
  /// pixels in it that wait for a photo below.
  [[nodiscard]] PixelBox lay(const Layer& layer, const PhotoWindow& shown, const PixelBox& shown_box,
                             const PixelBox& part, const PixelBox& block, std::vector<Blend>& blends) const {
    std::vector<Tap> columns;
    for (std::int64_t col = part.col; col < part.end_col(); ++col) columns.push_back(column_tap(col));
    std::int64_t west = part.end_col(), east = part.col, north = part.end_row(), south = part.row;
    for (std::int64_t row = part.row; row < part.end_row(); ++row) {
      const Tap of_row = row_tap(row);
      Blend* blend = &blends[static_cast<std::size_t>((row - block.row) * block.width + part.col - block.col)];
      const int left = static_cast<int>(part.col - shown_box.col), at_row = static_cast<int>(row - shown_box.row);
      const std::uint8_t *rgb = &shown.rgb.at(left, at_row), *valid = &shown.valid.at(left, at_row);
      for (int i = 0; i < part.width; ++i, ++blend, rgb += 3) {
        const Tap of_col = columns[static_cast<std::size_t>(i)];
        if (valid[i] && !blend->settled()) {
          Color rest{};
          if (!layer.match.rest.empty())
            for (int c = 0; c < 3; ++c)
              rest[static_cast<std::size_t>(c)] = between(layer.match.rest, of_col, of_row, c);
          const Color color{static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
          blend->add(layer.match.apply(color, rest), between(layer.weights, of_col, of_row));
        }
        if (blend->settled()) continue;
        west = std::min(west, part.col + i), east = std::max(east, part.col + i + 1);
        north = std::min(north, row), south = row + 1;
      }
    }
    if (west >= east) return {};
    return {west, north, static_cast<int>(east - west), static_cast<int>(south - north)};
  }

  GridFrame frame_, cells_;
  std::vector<Layer> layers_;
};
}  // namespace

GridFrame mosaic_overview_frame(const GridFrame& mosaic, std::span<const double> photo_gsds_m) {
  const Box2 box = mosaic.bounds();
  const double least_m = std::sqrt(box.width() * box.height() * static_cast<double>(photo_gsds_m.size()) / most_cells);
  const double cell_m = std::max({finest_cell_m, least_m, *std::ranges::max_element(photo_gsds_m)});
  const double margin_m = 2.0 * std::max(feather_m(cell_m), color_reach_m) + 2.0 * cell_m;
  return covering_grid(box.grown(margin_m), cell_m);
}

PhotoSource mosaic_of(std::vector<MosaicPhoto> photos) {
  assert(!photos.empty());
  const Crs crs = photos.front().photo.crs;
  const auto mosaic = std::make_shared<const Mosaic>(std::move(photos));
  return {crs, mosaic->frame(), [mosaic](const PixelBox& box) { return mosaic->read(box); }};
}

}  // namespace orthodrive

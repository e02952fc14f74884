// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plants/tree_crowns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace orthodrive::scene {
namespace {

constexpr double grid_m = 1.0;
constexpr std::array<double, 5> radii_m = {5.0, 4.0, 3.2, 2.4, 1.6};
constexpr double min_cover = 0.85;    // of a crown's disc
constexpr double free_share = 0.8;    // of the sum of two radii: nearer crowns are one
constexpr float cover_weight = 2.0F;  // of full cover against full brightness
constexpr int band_rows = 256;
constexpr int samples = 2;  // a side of a grid cell

struct Canopy {
  GridFrame frame;
  Raster<std::uint8_t> cover;  ///< how many of a cell's samples are vegetation: a byte, because towns are large
  Raster<float> bright;        ///< mean brightness of its samples, 0 to 1; what is no vegetation counts as 0
};

constexpr float sample_share = 1.0F / (samples * samples);

bool is_vegetation(const LabelMap& labels, Vec2 p) {
  const Vec2 at = labels.frame.pixel_from_world(p);
  const int col = static_cast<int>(std::floor(at.x)), row = static_cast<int>(std::floor(at.y));
  if (!labels.labels.inside(col, row)) return false;
  const std::uint8_t label = labels.labels.at(col, row);
  return label < labels.classes.classes.size() && labels.classes.classes[label].role == Role::vegetation;
}

float brightness(const Photo& photo, Vec2 p) {
  const Vec2 at = photo.frame.pixel_from_world(p);
  const int col = static_cast<int>(std::floor(at.x)), row = static_cast<int>(std::floor(at.y));
  if (!photo.valid.inside(col, row) || photo.valid.at(col, row) == 0) return 0.0F;
  return static_cast<float>(2 * photo.rgb.at(col, row, 0) + 5 * photo.rgb.at(col, row, 1) + photo.rgb.at(col, row, 2)) /
         2040.0F;
}

Canopy canopy_of(const LabelMap& labels, const Photo& photo) {
  Canopy canopy{covering_grid(labels.frame.bounds(), grid_m), {}, {}};
  canopy.cover = Raster<std::uint8_t>(canopy.frame.width, canopy.frame.height);
  canopy.bright = Raster<float>(canopy.frame.width, canopy.frame.height);
  for (int row = 0; row < canopy.frame.height; ++row) {
    for (int col = 0; col < canopy.frame.width; ++col) {
      for (int k = 0; k < samples * samples; ++k) {
        const int right = k % samples, down = k / samples;
        const Vec2 p = canopy.frame.world_from_pixel(col + (right + 0.5) / samples, row + (down + 0.5) / samples);
        if (!is_vegetation(labels, p)) continue;
        ++canopy.cover.at(col, row);
        canopy.bright.at(col, row) += sample_share * brightness(photo, p);
      }
    }
  }
  return canopy;
}

/// Rows of a raster times a factor; those beyond its border are 0.
template <typename T>
Raster<float> rows_of(const Raster<T>& raster, int first, int count, float factor) {
  Raster<float> result(raster.width, count);
  for (int row = std::max(0, -first); row < std::min(count, raster.height - first); ++row)
    for (int col = 0; col < raster.width; ++col)
      result.at(col, row) = factor * static_cast<float>(raster.at(col, first + row));
  return result;
}

/// Mean over 2 reach + 1 cells in a row; cells beyond the border are 0.
void blur_rows(Raster<float>& raster, int reach) {
  std::vector<double> sums(static_cast<std::size_t>(raster.width) + 1);
  for (int row = 0; row < raster.height; ++row) {
    for (int col = 0; col < raster.width; ++col)
      sums[static_cast<std::size_t>(col) + 1] =
          sums[static_cast<std::size_t>(col)] + static_cast<double>(raster.at(col, row));
    for (int col = 0; col < raster.width; ++col) {
      const auto low = static_cast<std::size_t>(std::max(0, col - reach));
      const auto high = static_cast<std::size_t>(std::min(raster.width, col + reach + 1));
      raster.at(col, row) = static_cast<float>((sums[high] - sums[low]) / (2 * reach + 1));
    }
  }
}

Raster<float> transposed(const Raster<float>& raster) {
  Raster<float> result(raster.height, raster.width);
  for (int row = 0; row < raster.height; ++row)
    for (int col = 0; col < raster.width; ++col) result.at(row, col) = raster.at(col, row);
  return result;
}

/// Two box filters in each direction: nearly a cone.
Raster<float> blurred(Raster<float> raster, int reach) {
  for (int direction = 0; direction < 2; ++direction) {
    blur_rows(raster, reach);
    blur_rows(raster, reach);
    raster = transposed(raster);
  }
  return raster;
}

/// Larger than the neighbours before it and no smaller than those after it.
bool is_peak(const Raster<float>& raster, int col, int row) {
  const float own = raster.at(col, row);
  for (int dr = -1; dr <= 1; ++dr) {
    for (int dc = -1; dc <= 1; ++dc) {
      if ((dr == 0 && dc == 0) || !raster.inside(col + dc, row + dr)) continue;
      const float other = raster.at(col + dc, row + dr);
      if (other > own || (other == own && (dr < 0 || (dr == 0 && dc < 0)))) return false;
    }
  }
  return true;
}

/// Cells of which most lies in a disc around the middle of cell (0, 0), as steps of columns and rows.
std::vector<std::array<int, 2>> disc_of(double radius_m) {
  const int reach = static_cast<int>(radius_m / grid_m);
  std::vector<std::array<int, 2>> disc;
  for (int dr = -reach; dr <= reach; ++dr)
    for (int dc = -reach; dc <= reach; ++dc)
      if (std::hypot(dc, dr) * grid_m + 0.35 * grid_m <= radius_m) disc.push_back({dc, dr});
  return disc;
}

double cover_of(const Canopy& canopy, std::array<int, 2> at, const std::vector<std::array<int, 2>>& disc) {
  int sum = 0;
  for (const auto& [dc, dr] : disc)
    if (canopy.cover.inside(at[0] + dc, at[1] + dr)) sum += canopy.cover.at(at[0] + dc, at[1] + dr);
  return static_cast<double>(sum) / static_cast<double>(disc.size() * samples * samples);
}

/// Crowns by place: is there room for one more?
class Crowns {
 public:
  [[nodiscard]] bool has_room(const TreeCrown& crown) const {
    const auto [x, y] = cell(crown.at);
    for (int k = 0; k < 9; ++k) {
      const auto found = cells_.find({x + k % 3 - 1, y + k / 3 - 1});
      if (found == cells_.end()) continue;
      for (const std::size_t i : found->second)
        if (distance(all[i].at, crown.at) < free_share * (all[i].radius_m + crown.radius_m)) return false;
    }
    return true;
  }
  void add(const TreeCrown& crown) {
    cells_[cell(crown.at)].push_back(all.size());
    all.push_back(crown);
  }
  std::vector<TreeCrown> all;

 private:
  static constexpr double cell_m = 2.0 * radii_m[0];
  static std::array<int, 2> cell(Vec2 p) {
    return {static_cast<int>(std::floor(p.x / cell_m)), static_cast<int>(std::floor(p.y / cell_m))};
  }
  std::map<std::array<int, 2>, std::vector<std::size_t>> cells_;
};

/// The measure of rows first to first + count.
Raster<float> measure_of(const Canopy& canopy, int first, int count, int reach) {
  Raster<float> measure = blurred(rows_of(canopy.bright, first, count, 1.0F), reach);
  const Raster<float> cover = blurred(rows_of(canopy.cover, first, count, sample_share), reach);
  for (std::size_t i = 0; i < measure.data.size(); ++i)
    measure.data[i] = cover.data[i] > 0.0F ? measure.data[i] / cover.data[i] + cover_weight * cover.data[i] : 0.0F;
  return measure;
}

int blur_reach(double radius_m) { return std::max(1, static_cast<int>(std::lround(0.35 * radius_m / grid_m))); }

/// Columns and rows of the measure's peaks in vegetation. Band by band: the blurred rasters of a whole town would take
/// more memory than its photo.
std::vector<std::array<int, 2>> peaks_of(const Canopy& canopy, int reach) {
  std::vector<std::array<int, 2>> peaks;
  const int beyond = 2 * reach + 1;  // what two filters and a look at the neighbours reach
  for (int first = 0; first < canopy.frame.height; first += band_rows) {
    const int count = std::min(band_rows, canopy.frame.height - first);
    const Raster<float> measure = measure_of(canopy, first - beyond, count + 2 * beyond, reach);
    for (int row = first; row < first + count; ++row)
      for (int col = 0; col < measure.width; ++col)
        if (canopy.cover.at(col, row) > 0 && is_peak(measure, col, row - first + beyond)) peaks.push_back({col, row});
  }
  return peaks;
}

}  // namespace

std::vector<TreeCrown> find_crowns(const LabelMap& labels, const Photo& photo) {
  const Canopy canopy = canopy_of(labels, photo);
  Crowns crowns;
  std::vector<std::array<int, 2>> peaks;
  int reach = 0;
  for (const double radius_m : radii_m) {
    if (blur_reach(radius_m) != reach) peaks = peaks_of(canopy, reach = blur_reach(radius_m));
    const std::vector<std::array<int, 2>> disc = disc_of(radius_m);
    for (const auto& [col, row] : peaks) {
      const TreeCrown crown{canopy.frame.center_of(col, row), radius_m};
      if (cover_of(canopy, {col, row}, disc) >= min_cover && crowns.has_room(crown)) crowns.add(crown);
    }
  }
  return crowns.all;
}

}  // namespace orthodrive::scene

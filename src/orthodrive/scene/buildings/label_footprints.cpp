// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/label_footprints.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr double known_reach_m = 4.0;  // roofs lean in photos, and maps are a little off
constexpr double footprint_cell_m = 2.5;
constexpr double min_area_m2 = 40.0, min_footprint_width_m = 4.0, min_filled = 0.55;
constexpr double min_inside = 0.7;  // of a patch in its rectangle
constexpr double all_filled = 0.9;  // of a rectangle: the corners are only blurred
constexpr double min_courtyard_m2 = 50.0;
constexpr int angle_steps = 90;

/// 1 where the photo shows a building that nobody knows.
Raster<std::uint8_t> unknown_buildings(const LabelMap& labels, std::span<const Building> known) {
  Raster<std::uint8_t> mask(labels.labels.width, labels.labels.height);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    const std::uint8_t label = labels.labels.data[i];
    mask.data[i] = label < labels.classes.classes.size() && labels.classes.classes[label].role == Role::building;
  }
  for (const Building& building : known) {
    if (building.footprint.outer.size() < 3) continue;
    const Vec2 from = building.footprint.outer.front();
    const Polygon outer{moved(building.footprint, from * -1.0).outer, {}};
    for (const Polygon& grown : buffer_of({outer}, known_reach_m, 2))
      fill_polygon(mask, labels.frame, moved(grown, from), std::uint8_t{0});
  }
  return mask;
}

/// Centres of the pixels that are connected with the first one over their sides, which are cleared.
std::vector<Vec2> take_patch(Raster<std::uint8_t>& mask, const GridFrame& frame, int first_col, int first_row) {
  std::vector<Vec2> patch;
  std::vector<std::array<int, 2>> open = {{first_col, first_row}};
  mask.at(first_col, first_row) = 0;
  while (!open.empty()) {
    const auto [col, row] = open.back();
    open.pop_back();
    patch.push_back(frame.center_of(col, row));
    for (const auto& [dc, dr] : {std::array{1, 0}, std::array{-1, 0}, std::array{0, 1}, std::array{0, -1}}) {
      if (!mask.inside(col + dc, row + dr) || mask.at(col + dc, row + dr) == 0) continue;
      mask.at(col + dc, row + dr) = 0;
      open.push_back({col + dc, row + dr});
    }
  }
  return patch;
}

Vec2 turned(Vec2 p, Vec2 along) { return {dot(p, along), cross(along, p)}; }
Vec2 turned_back(Vec2 p, Vec2 along) { return along * p.x + left_normal(along) * p.y; }

/// How sharply the patch begins and ends along a direction: squared steps of its extent across, per bin.
double sharpness(const std::vector<Vec2>& points, Vec2 along, double bin_m) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec2 p : points) low = std::min(low, dot(p, along)), high = std::max(high, dot(p, along));
  std::vector<double> counts(static_cast<std::size_t>((high - low) / bin_m) + 4);
  for (const Vec2 p : points) {  // shared between two bins: the pixels' own grid must not show
    const double at = (dot(p, along) - low) / bin_m + 1.0;
    const auto bin = static_cast<std::size_t>(at);
    const double part = at - static_cast<double>(bin);
    counts[bin] += 1.0 - part;
    counts[bin + 1] += part;
  }
  double sum = 0.0;
  for (std::size_t i = 1; i < counts.size(); ++i) sum += std::pow(counts[i] - counts[i - 1], 2);
  return sum;
}

/// Direction of the patch's sides, to a degree.
Vec2 main_direction(const std::vector<Vec2>& points, double pixel_m) {
  double sharpest = -1.0;
  Vec2 best{1.0, 0.0};
  for (int step = 0; step < angle_steps; ++step) {
    const double angle = 0.5 * std::numbers::pi * step / angle_steps, bin_m = pixel_m;
    const Vec2 along{std::cos(angle), std::sin(angle)};
    const double sharp = sharpness(points, along, bin_m) + sharpness(points, left_normal(along), bin_m);
    if (sharp > sharpest) sharpest = sharp, best = along;
  }
  return best;
}

Polygon largest_without_small_holes(const MultiPolygon& polygons) {
  Polygon polygon = *std::ranges::max_element(polygons, {}, [](const Polygon& p) { return area_m2(p); });
  std::erase_if(polygon.holes, [](const Ring& hole) { return -signed_area_m2(hole) < min_courtyard_m2; });
  return simplified({polygon}, plan_grid_m).front();
}

/// From where to where the patch is at least a quarter as deep as in its deepest place: specks at its border do not
/// count.
std::array<double, 2> extent(const std::vector<Vec2>& points, double Vec2::*along, double bin_m) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec2 p : points) low = std::min(low, p.*along), high = std::max(high, p.*along);
  std::vector<int> counts(static_cast<std::size_t>((high - low) / bin_m) + 1);
  for (const Vec2 p : points) ++counts[static_cast<std::size_t>((p.*along - low) / bin_m)];
  const int enough = *std::ranges::max_element(counts) / 4;
  const auto is_deep = [&](int count) { return count >= enough; };
  const auto first = std::ranges::find_if(counts, is_deep) - counts.begin();
  const auto last = std::find_if(counts.rbegin(), counts.rend(), is_deep).base() - counts.begin();
  return {low + static_cast<double>(first) * bin_m, std::min(high, low + static_cast<double>(last) * bin_m)};
}

struct CellBlock {
  int first_col, first_row, end_col, end_row;
};

/// The covered cells of a grid as few rectangles: runs of a row, joined with the same run of the row before.
template <typename IsCovered>
std::vector<CellBlock> blocks_of(int columns, int rows, const IsCovered& is_covered) {
  std::vector<CellBlock> blocks;
  for (int row = 0; row < rows; ++row) {
    for (int col = 0; col < columns; ++col) {
      if (!is_covered(col, row)) continue;
      const int first = col;
      while (col < columns && is_covered(col, row)) ++col;
      const auto goes_on = std::ranges::find_if(blocks, [&](const CellBlock& block) {
        return block.end_row == row && block.first_col == first && block.end_col == col;
      });
      if (goes_on != blocks.end())
        ++goes_on->end_row;
      else
        blocks.push_back({first, row, col, row + 1});
    }
  }
  return blocks;
}

/// The cells of a grid along the rectangle that the patch covers by half, as one polygon; empty when it is no building.
Polygon right_angled(const std::vector<Vec2>& patch, double pixel_m) {
  const Vec2 from = patch.front();
  std::vector<Vec2> points;
  points.reserve(patch.size());
  for (const Vec2 p : patch) points.push_back(p - from);
  const Vec2 along = main_direction(points, pixel_m);
  for (Vec2& p : points) p = turned(p, along);
  const auto [west, east] = extent(points, &Vec2::x, pixel_m);
  const auto [south, north] = extent(points, &Vec2::y, pixel_m);
  Box2 box{west, south, east, north};
  std::erase_if(points, [&](Vec2 p) { return !box.contains(p); });
  const double covered_m2 = static_cast<double>(points.size()) * pixel_m * pixel_m;
  if (!(std::min(box.width(), box.height()) >= min_footprint_width_m)) return {};
  if (static_cast<double>(points.size()) < min_inside * static_cast<double>(patch.size())) return {};
  const double filled = covered_m2 / (box.width() * box.height());
  if (filled < min_filled) return {};
  const int columns = std::max(1, static_cast<int>(std::lround(box.width() / footprint_cell_m)));
  const int rows = std::max(1, static_cast<int>(std::lround(box.height() / footprint_cell_m)));
  const double width_m = box.width() / columns, height_m = box.height() / rows;
  Raster<int> count(columns, rows);
  for (const Vec2 p : points)
    ++count.at(std::clamp(static_cast<int>((p.x - box.min_x) / width_m), 0, columns - 1),
               std::clamp(static_cast<int>((p.y - box.min_y) / height_m), 0, rows - 1));
  const auto is_covered = [&](int col, int row) {
    return filled >= all_filled || count.at(col, row) * pixel_m * pixel_m >= 0.5 * width_m * height_m;
  };
  std::vector<Polygon> cells;
  for (const CellBlock& block : blocks_of(columns, rows, is_covered)) {
    const Vec2 low = snap_to_grid({box.min_x + block.first_col * width_m, box.min_y + block.first_row * height_m});
    const Vec2 high = snap_to_grid({box.min_x + block.end_col * width_m, box.min_y + block.end_row * height_m});
    cells.push_back({{low, {high.x, low.y}, high, {low.x, high.y}}, {}});
  }
  if (cells.empty()) return {};
  Polygon footprint = largest_without_small_holes(union_of(cells, plan_grid_m));
  const auto back = [&](Ring& ring) {
    for (Vec2& p : ring) p = from + turned_back(p, along);
  };
  back(footprint.outer);
  for (Ring& hole : footprint.holes) back(hole);
  return footprint;
}

}  // namespace

std::vector<Building> footprints_of_labels(const LabelMap& labels, std::span<const Building> known) {
  Raster<std::uint8_t> mask = unknown_buildings(labels, known);
  const double pixel_m = labels.frame.gsd_m;
  std::vector<Building> buildings;
  for (int row = 0; row < mask.height; ++row) {
    for (int col = 0; col < mask.width; ++col) {
      if (mask.at(col, row) == 0) continue;
      const std::vector<Vec2> patch = take_patch(mask, labels.frame, col, row);
      if (static_cast<double>(patch.size()) * pixel_m * pixel_m < min_area_m2) continue;
      Polygon footprint = right_angled(patch, pixel_m);
      if (!footprint.outer.empty() && area_m2(footprint) >= min_area_m2)
        buildings.push_back({.footprint = std::move(footprint)});
    }
  }
  return buildings;
}

}  // namespace orthodrive::scene

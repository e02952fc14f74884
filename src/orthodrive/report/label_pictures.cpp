// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/report/label_pictures.hpp"

#include <algorithm>
#include <cmath>

namespace orthodrive {
namespace {
/// Grows with every pixel that is compared.
struct PlaceCount {
  int min_col = 0, min_row = 0, max_col = -1, max_row = -1;
  std::size_t pixels = 0, wrong = 0;
  void add(int col, int row, bool right) {
    if (pixels == 0) min_col = max_col = col, min_row = max_row = row;
    min_col = std::min(min_col, col), max_col = std::max(max_col, col);
    min_row = std::min(min_row, row), max_row = std::max(max_row, row);
    ++pixels, wrong += right ? 0 : 1;
  }
};

Box2 box_of_pixels(const GridFrame& frame, int col0, int row0, int col1, int row1) {  // without col1, row1
  const Vec2 nw = frame.world_from_pixel(col0, row0), se = frame.world_from_pixel(col1, row1);
  return {nw.x, se.y, se.x, nw.y};
}

LabelPlace place_of(const PlaceCount& count, const GridFrame& frame, const std::string& name) {
  return {name, box_of_pixels(frame, count.min_col, count.min_row, count.max_col + 1, count.max_row + 1), count.pixels,
          count.wrong};
}

/// Calls with every compared pixel.
template <typename Visit>
void for_compared(const LabelComparisonView& view, const Visit& visit) {
  for (int row = 0; row < view.frame().height; ++row)
    for (int col = 0; col < view.frame().width; ++col)
      if (const LabelPair pair = view.at(col, row); pair.state == PixelState::compared) visit(col, row, pair);
}
}  // namespace

LabelPlace whole_place(const LabelComparisonView& view) {
  PlaceCount count;
  for_compared(view, [&](int col, int row, const LabelPair& pair) { count.add(col, row, pair.right()); });
  return place_of(count, view.frame(), "all");
}

std::vector<LabelPlace> worst_places(const LabelComparisonView& view, int tile_px, std::size_t count) {
  const GridFrame& frame = view.frame();
  const int columns = (frame.width + tile_px - 1) / tile_px, rows = (frame.height + tile_px - 1) / tile_px;
  Raster<PlaceCount> tiles(columns, rows);
  for_compared(view, [&](int col, int row, const LabelPair& pair) {
    tiles.at(col / tile_px, row / tile_px).add(col, row, pair.right());
  });
  std::vector<LabelPlace> places;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < columns; ++col) {
      const PlaceCount& tile = tiles.at(col, row);
      if (tile.wrong == 0) continue;
      const int col0 = col * tile_px, row0 = row * tile_px;
      places.push_back({"column " + std::to_string(col0) + ", row " + std::to_string(row0),
                        box_of_pixels(frame, col0, row0, std::min(frame.width, col0 + tile_px),
                                      std::min(frame.height, row0 + tile_px)),
                        tile.pixels, tile.wrong});
    }
  std::stable_sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.wrong > b.wrong; });
  places.resize(std::min(places.size(), count));
  return places;
}

std::vector<LabelPlace> piece_places(const LabelComparisonView& view, const TruthPieces& pieces) {
  std::vector<PlaceCount> counts(pieces.names.size());
  if (counts.empty()) return {};
  for_compared(view, [&](int col, int row, const LabelPair& pair) {
    if (const std::uint16_t piece = pieces.index.at(col, row); piece != 0)
      counts[piece - std::size_t{1}].add(col, row, pair.right());
  });
  std::vector<LabelPlace> places;
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i].pixels > 0) places.push_back(place_of(counts[i], view.frame(), pieces.names[i]));
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.accuracy() < b.accuracy(); });
  return places;
}

std::vector<Color> error_colors(const std::vector<ClassInfo>& classes) {
  constexpr int least_chroma = 60;
  // Magenta first; the golden angle keeps the hues of further grey classes apart.
  double hue_deg = 310.0;
  std::vector<Color> colors;
  for (const ClassInfo& c : classes) {
    const auto [low, high] = std::minmax_element(c.color.begin(), c.color.end());
    Color color = c.color;
    if (*high - *low < least_chroma) {
      for (int k = 0; k < 3; ++k) {  // HSV with full value and 0.9 saturation
        const double t = std::fmod(hue_deg / 60.0 + std::array{5.0, 3.0, 1.0}[static_cast<std::size_t>(k)], 6.0);
        const double weight = std::clamp(std::min(t, 4.0 - t), 0.0, 1.0);
        color[static_cast<std::size_t>(k)] = static_cast<std::uint8_t>(std::lround(255.0 * (1.0 - 0.9 * weight)));
      }
      hue_deg = std::fmod(hue_deg + 137.508, 360.0);
    }
    colors.push_back(color);
  }
  return colors;
}

GridFrame picture_frame(const LabelComparisonView& view, const Box2& box, int max_px) {
  const double gsd_m = std::max(view.frame().gsd_m, std::max(box.width(), box.height()) / max_px);
  const auto pixels = [&](double length_m) { return std::max(1, static_cast<int>(std::lround(length_m / gsd_m))); };
  return {box.min_x, box.max_y, gsd_m, pixels(box.width()), pixels(box.height())};
}

namespace {
/// What the label pixels under a pixel of a picture say. Sampled at up to 8 x 8 of them.
struct Sampled {
  int taken = 0, compared = 0, wrong = 0;
  std::array<int, 3> sum{};  ///< of the colours that `color` gives
};
template <typename ColorOf>
Sampled sample(const LabelComparisonView& view, const GridFrame& frame, int col, int row, const ColorOf& color) {
  constexpr int most_taps = 8;
  const int taps = std::clamp(static_cast<int>(std::ceil(frame.gsd_m / view.frame().gsd_m - 1e-6)), 1, most_taps);
  Sampled sampled;
  for (int j = 0; j < taps; ++j)
    for (int i = 0; i < taps; ++i) {
      const Vec2 q =
          view.frame().pixel_from_world(frame.world_from_pixel(col + (i + 0.5) / taps, row + (j + 0.5) / taps));
      const int c = static_cast<int>(std::floor(q.x)), r = static_cast<int>(std::floor(q.y));
      if (c < 0 || r < 0 || c >= view.frame().width || r >= view.frame().height) continue;
      const LabelPair pair = view.at(c, r);
      if (pair.state != PixelState::compared) continue;
      ++sampled.compared;
      sampled.wrong += pair.right() ? 0 : 1;
      const Color* const picked = color(pair);
      if (!picked) continue;
      ++sampled.taken;
      for (std::size_t k = 0; k < 3; ++k) sampled.sum[k] += (*picked)[k];
    }
  return sampled;
}

template <typename Paint>
Canvas painted(const GridFrame& frame, const Paint& paint) {
  Canvas canvas{frame, Raster<std::uint8_t>(frame.width, frame.height, 3)};
  for (int row = 0; row < frame.height; ++row)
    for (int col = 0; col < frame.width; ++col) {
      const std::array<double, 3> color = paint(col, row);
      for (int k = 0; k < 3; ++k)
        canvas.rgb.at(col, row, k) =
            static_cast<std::uint8_t>(std::lround(std::clamp(color[static_cast<std::size_t>(k)], 0.0, 255.0)));
    }
  return canvas;
}
}  // namespace

Canvas picture_of_errors(const LabelComparisonView& view, const GridFrame& frame, const Photo* photo) {
  constexpr double color_weight = 0.75;  // the rest lets the photo shine through
  constexpr double pale = 0.65;
  const std::vector<Color> colors = error_colors(view.classes());
  return painted(frame, [&](int col, int row) -> std::array<double, 3> {
    const double grey = grey_at(photo, frame.center_of(col, row));
    const Sampled labels = sample(
        view, frame, col, row, [&](const LabelPair& pair) { return pair.right() ? nullptr : &colors[pair.predicted]; });
    std::array<double, 3> color{grey, grey, grey};
    if (labels.compared == 0)
      for (double& c : color) c = pale * 255.0 + (1.0 - pale) * c;
    if (labels.taken == 0) return color;
    const double weight = color_weight * std::sqrt(static_cast<double>(labels.wrong) / labels.compared);
    for (std::size_t k = 0; k < 3; ++k)
      color[k] += weight * (static_cast<double>(labels.sum[k]) / labels.taken - color[k]);
    return color;
  });
}

Canvas picture_of_classes(const LabelComparisonView& view, const GridFrame& frame, LabelSide side) {
  return painted(frame, [&](int col, int row) -> std::array<double, 3> {
    const Sampled labels = sample(view, frame, col, row, [&](const LabelPair& pair) {
      return &view.classes()[side == LabelSide::truth ? pair.expected : pair.predicted].color;
    });
    constexpr double nothing = 225.0;
    std::array<double, 3> color{nothing, nothing, nothing};
    for (std::size_t k = 0; k < 3 && labels.taken > 0; ++k)
      color[k] = static_cast<double>(labels.sum[k]) / labels.taken;
    return color;
  });
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/raster/photo_collar.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "orthodrive/io/raster/computed_photo.hpp"

namespace orthodrive::io {
namespace {

constexpr int core_tolerance = 6;     // grey levels: JPEG inside flat areas, averages of overviews
constexpr int fringe_tolerance = 40;  // grey levels: what JPEG and resampling leave at the rim of the collar
constexpr double least_border_share = 0.02, least_area_share = 0.001, least_flat_share = 0.9;
constexpr double one_colour_share = 0.99;
constexpr int most_cells = 1024;  // along the longer side

/// The extreme colour that a pixel is within the tolerance; 0: neither.
std::uint8_t extreme_of(const std::uint8_t* rgb, int tolerance) {
  const auto [least, most] = std::minmax({rgb[0], rgb[1], rgb[2]});
  if (most <= tolerance) return PhotoCollar::black;
  return least >= 255 - tolerance ? PhotoCollar::white : std::uint8_t{0};
}

/// A window of the photo, decimated; colours of pixels without data are grey. Empty where it cannot be read: whoever
/// reads the photo will say so.
Raster<std::uint8_t> decimated(GDALDataset& rgb, const ComputedWindow& window, int width, int height) {
  Raster<std::uint8_t> cells(width, height, 3), mask(width, height);
  const GdalErrors silent;
  int bands[3] = {1, 2, 3};
  if (rgb.RasterIO(GF_Read, window.col, window.row, window.width, window.height, cells.data.data(), width, height,
                   GDT_Byte, 3, bands, 3, GSpacing{3} * width, 1, nullptr) != CE_None)
    return {};
  if (rgb.GetRasterBand(1)->GetMaskFlags() & GMF_ALL_VALID) return cells;
  if (rgb.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Read, window.col, window.row, window.width, window.height,
                                                    mask.data.data(), width, height, GDT_Byte, 0, 0,
                                                    nullptr) != CE_None)
    return {};
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    if (mask.data[i] < 128) std::fill_n(&cells.data[3 * i], 3, std::uint8_t{127});
  return cells;
}

/// Whether enough of the outermost pixels are of an extreme colour. Row by row from the top: files of whole rows are
/// decoded once.
bool is_suspicious(GDALDataset& rgb, int cell_px) {
  const int width = rgb.GetRasterXSize(), height = rgb.GetRasterYSize(), columns = std::max(1, width / cell_px);
  std::array<std::size_t, 3> seen{};
  std::size_t border = 0;
  const auto look = [&](const ComputedWindow& window, int pixels) {
    const Raster<std::uint8_t> part = decimated(rgb, window, pixels, 1);
    for (std::size_t i = 0; i + 2 < part.data.size(); i += 3, ++border)
      ++seen[extreme_of(&part.data[i], core_tolerance)];
  };
  look({0, 0, width, 1}, columns);
  for (int row = cell_px / 2; row < height; row += cell_px) {
    look({0, row, 1, 1}, 1);
    look({width - 1, row, 1, 1}, 1);
  }
  look({0, height - 1, width, 1}, columns);
  return static_cast<double>(std::max(seen[PhotoCollar::black], seen[PhotoCollar::white])) >=
         least_border_share * static_cast<double>(border);
}

struct CollarPart {
  std::vector<std::pair<int, int>> cells;  ///< column, row
  std::size_t at_border = 0;
  double flat_share = 0.0;
};

bool could_be_collar(const CollarPart& part, const Raster<std::uint8_t>& cells) {
  const double border = 2.0 * (cells.width + cells.height), area = static_cast<double>(cells.width) * cells.height;
  return static_cast<double>(part.at_border) >= least_border_share * border &&
         static_cast<double>(part.cells.size()) >= least_area_share * area;
}

/// The share of one colour among the cells of a part that lie deep in it, since JPEG frays its rim; among all of them
/// where it is too thin for that.
double flat_share_of(const CollarPart& part, const Raster<std::uint8_t>& cells, int cell_px) {
  constexpr int block_px = 16;  // of JPEG with halved colours
  const int reach = 1 + block_px / cell_px;
  Raster<std::uint8_t> inside(cells.width, cells.height);
  for (const auto& [col, row] : part.cells) inside.at(col, row) = 1;
  const auto belongs = [&](int col, int row) { return !cells.inside(col, row) || inside.at(col, row) != 0; };
  std::map<std::uint32_t, std::size_t> all, deep;
  for (const auto& [col, row] : part.cells) {
    const std::uint8_t* rgb = &cells.at(col, row);
    const std::uint32_t color = (std::uint32_t{rgb[0]} << 16U) | (std::uint32_t{rgb[1]} << 8U) | rgb[2];
    ++all[color];
    if (belongs(col - reach, row) && belongs(col + reach, row) && belongs(col, row - reach) &&
        belongs(col, row + reach))
      ++deep[color];
  }
  std::size_t most = 0, counted = 0;
  for (const auto& [color, count] : deep.empty() ? all : deep) most = std::max(most, count), counted += count;
  return static_cast<double>(most) / static_cast<double>(counted);
}

/// The cells of one colour that hang together with one of them.
CollarPart grow_part(const Raster<std::uint8_t>& cells, Raster<std::uint8_t>& taken, std::pair<int, int> start,
                     int cell_px) {
  CollarPart part;
  const std::uint8_t wanted = extreme_of(&cells.at(start.first, start.second), core_tolerance);
  const auto take = [&](int col, int row) {
    if (!cells.inside(col, row) || taken.at(col, row)) return;
    if (extreme_of(&cells.at(col, row), core_tolerance) != wanted) return;
    taken.at(col, row) = 1;
    part.cells.emplace_back(col, row);
  };
  take(start.first, start.second);
  for (std::size_t next = 0; next < part.cells.size(); ++next) {
    const auto [col, row] = part.cells[next];
    part.at_border += col == 0 || row == 0 || col == cells.width - 1 || row == cells.height - 1 ? 1 : 0;
    take(col + 1, row), take(col - 1, row), take(col, row + 1), take(col, row - 1);
  }
  if (could_be_collar(part, cells)) part.flat_share = flat_share_of(part, cells, cell_px);
  return part;
}

void add_part(const CollarPart& part, std::uint8_t color, PhotoCollar& collar) {
  constexpr int fringe_px = 8;  // a block of JPEG
  const int reach = 2 + fringe_px / collar.cell_px;
  for (const auto& [col, row] : part.cells)
    for (int r = std::max(0, row - reach); r <= std::min(collar.zone.height - 1, row + reach); ++r)
      for (int c = std::max(0, col - reach); c <= std::min(collar.zone.width - 1, col + reach); ++c)
        collar.zone.at(c, r) |= color;
  (color == PhotoCollar::black ? collar.has_black : collar.has_white) = true;
}

Vec2 middle_of_part(const CollarPart& part, int cell_px) {
  Vec2 sum;
  for (const auto& [col, row] : part.cells) sum = sum + Vec2{col + 0.5, row + 0.5};
  return sum * (static_cast<double>(cell_px) / static_cast<double>(part.cells.size()));
}

std::vector<std::pair<int, int>> border_cells(const Raster<std::uint8_t>& cells) {
  std::vector<std::pair<int, int>> border;
  for (int col = 0; col < cells.width; ++col) border.emplace_back(col, 0), border.emplace_back(col, cells.height - 1);
  for (int row = 0; row < cells.height; ++row) border.emplace_back(0, row), border.emplace_back(cells.width - 1, row);
  return border;
}

}  // namespace

bool PhotoCollar::covers(int col, int row, std::uint8_t r, std::uint8_t g, std::uint8_t b) const {
  const std::uint8_t here = zone.at(std::min(col / cell_px, zone.width - 1), std::min(row / cell_px, zone.height - 1));
  const std::uint8_t rgb[3] = {r, g, b};
  return here != 0 && (here & extreme_of(rgb, fringe_tolerance)) != 0;
}

std::string PhotoCollar::colors() const {
  return has_black && has_white ? "black and white" : has_black ? "black" : "white";
}

std::optional<PhotoCollar> find_collar(GDALDataset& rgb) {
  const int width = rgb.GetRasterXSize(), height = rgb.GetRasterYSize();
  PhotoCollar collar{.cell_px = std::max(1, (std::max(width, height) + most_cells - 1) / most_cells)};
  if (!is_suspicious(rgb, collar.cell_px)) return std::nullopt;
  // Whole cells only: GDAL spreads the rest of a pixel over all of them.
  const int columns = std::max(1, width / collar.cell_px), rows = std::max(1, height / collar.cell_px);
  const Raster<std::uint8_t> cells = decimated(
      rgb, {0, 0, std::min(width, columns * collar.cell_px), std::min(height, rows * collar.cell_px)}, columns, rows);
  if (cells.empty()) return std::nullopt;
  collar.zone = Raster<std::uint8_t>(columns, rows);
  Raster<std::uint8_t> taken(columns, rows);
  std::size_t covered = 0, largest = 0;
  for (const auto& start : border_cells(cells)) {
    const std::uint8_t color = extreme_of(&cells.at(start.first, start.second), core_tolerance);
    if (color == 0 || taken.at(start.first, start.second)) continue;
    const CollarPart part = grow_part(cells, taken, start, collar.cell_px);
    if (part.flat_share < least_flat_share) continue;
    add_part(part, color, collar);
    covered += part.cells.size();
    if (part.cells.size() <= largest) continue;
    largest = part.cells.size();
    collar.middle_px = middle_of_part(part, collar.cell_px);
  }
  collar.share = static_cast<double>(covered) / (static_cast<double>(columns) * rows);
  if (covered == 0 || collar.share > one_colour_share) return std::nullopt;
  return collar;
}

namespace {
/// 255 where some band has data and the pixel is not of the collar.
bool compute_alpha(GDALDataset& rgb, const PhotoCollar& collar, const ComputedWindow& window, std::uint8_t* alpha) {
  const std::size_t size = static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
  std::array<std::vector<std::uint8_t>, 3> colors;
  std::vector<std::uint8_t> mask(size);
  std::fill_n(alpha, size, std::uint8_t{0});
  for (int band = 1; band <= 3; ++band) {
    std::vector<std::uint8_t>& color = colors[static_cast<std::size_t>(band - 1)];
    color.resize(size);
    if (!read_band(*rgb.GetRasterBand(band), window, color.data()) ||
        !read_band(*rgb.GetRasterBand(band)->GetMaskBand(), window, mask.data()))
      return false;
    for (std::size_t i = 0; i < size; ++i) alpha[i] = std::max(alpha[i], mask[i]);
  }
  std::size_t i = 0;
  for (int row = window.row; row < window.row + window.height; ++row)
    for (int col = window.col; col < window.col + window.width; ++col, ++i)
      if (collar.covers(col, row, colors[0][i], colors[1][i], colors[2][i])) alpha[i] = 0;
  return true;
}
}  // namespace

DatasetPtr without_collar(DatasetPtr own, GDALDataset& rgb, PhotoCollar collar) {
  const std::shared_ptr<GDALDataset> kept(own.release(), CloseDataset{});
  const auto shared = std::make_shared<const PhotoCollar>(std::move(collar));
  return computed_photo(rgb, 4, [kept, shared, &rgb](int band, const ComputedWindow& window, std::uint8_t* pixels) {
    return band < 4 ? read_band(*rgb.GetRasterBand(band), window, pixels) : compute_alpha(rgb, *shared, window, pixels);
  });
}

}  // namespace orthodrive::io

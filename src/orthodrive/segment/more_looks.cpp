// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/more_looks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "orthodrive/segment/mirror_beyond.hpp"
#include "orthodrive/segment/resample_photo.hpp"

namespace orthodrive {
namespace {

/// The two cells of a coarser or finer line of cells that a pixel lies between, and its share of the second.
struct Between {
  int first = 0, second = 0;
  float share = 0.0F;
};

/// For `count` pixels from `begin` on, in cells of `scale` pixels, counted from `cell`; `cells` are known.
std::vector<Between> between_cells(std::int64_t begin, int count, double scale, std::int64_t cell, int cells) {
  std::vector<Between> all(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double at = (static_cast<double>(begin + i) + 0.5) / scale - 0.5, floor = std::floor(at);
    const auto first = static_cast<std::int64_t>(floor) - cell, last = static_cast<std::int64_t>(cells) - 1;
    all[static_cast<std::size_t>(i)] = {static_cast<int>(std::clamp<std::int64_t>(first, 0, last)),
                                        static_cast<int>(std::clamp<std::int64_t>(first + 1, 0, last)),
                                        static_cast<float>(at - floor)};
  }
  return all;
}

/// The cells that the pixels of a box lie between.
PixelBox cells_around(const PixelBox& box, double scale, const GridFrame& frame) {
  const auto cell = [&](std::int64_t pixel) {
    return static_cast<std::int64_t>(std::floor((static_cast<double>(pixel) + 0.5) / scale - 0.5));
  };
  const std::int64_t col = cell(box.col), row = cell(box.row);
  return intersection({col, row, static_cast<int>(cell(box.end_col() - 1) + 2 - col),
                       static_cast<int>(cell(box.end_row() - 1) + 2 - row)},
                      pixels_of(frame));
}

/// Adds to the first channels of `scores`, as many as there are classes. `mirrored` has its columns from east to west.
void add_mirrored(const Raster<float>& mirrored, const std::vector<Between>& cols, const std::vector<Between>& rows,
                  int classes, Raster<float>& scores) {
  const int last = mirrored.width - 1;
  for (int row = 0; row < scores.height; ++row) {
    const Between& r = rows[static_cast<std::size_t>(row)];
    for (int col = 0; col < scores.width; ++col) {
      const Between& c = cols[static_cast<std::size_t>(col)];
      const float *nw = &mirrored.at(last - c.first, r.first), *ne = &mirrored.at(last - c.second, r.first),
                  *sw = &mirrored.at(last - c.first, r.second), *se = &mirrored.at(last - c.second, r.second);
      float* to = &scores.at(col, row);
      for (int k = 0; k < classes; ++k) {
        const float north = nw[k] + c.share * (ne[k] - nw[k]), south = sw[k] + c.share * (se[k] - sw[k]);
        to[k] += north + r.share * (south - north);
      }
    }
  }
}

}  // namespace

NetworkWindow network_window(const InferenceNetwork& network, const MapLines* map, const GridFrame& frame,
                             const PixelBox& seen, Raster<std::uint8_t> rgb) {
  NetworkWindow window{mirror_beyond(std::move(rgb), seen, frame), {}};
  if (network.sees_map())
    window.map = mirror_map_beyond(map->read(frame, intersection(seen, pixels_of(frame))), seen, frame);
  return window;
}

MoreLooks::MoreLooks(const PhotoSource& photo, double gsd_m) {
  for (const double scale : look_scales) photos_.push_back(resample_source(photo, scale * gsd_m));
}

void MoreLooks::average(const InferenceNetwork& network, const MapLines* map, const GridFrame& frame,
                        const PixelBox& box, Raster<float>& scores, CellMemory& memory) const {
  if (photos_.empty()) return;
  for (const PhotoSource& photo : photos_) {
    const double scale = photo.frame.gsd_m / frame.gsd_m;
    const PixelBox cells = cells_around(box, scale, photo.frame), seen = cells.grown(network.margin_px());
    NetworkWindow window =
        network_window(network, map, photo.frame, seen, photo.read(intersection(seen, pixels_of(photo.frame))).rgb);
    window = {mirrored(std::move(window.rgb)), mirrored_map(std::move(window.map))};
    Raster<float> found(cells.width, cells.height, network.output_channels());
    // Mirrored about the frame's western edge, so that the network's strides do not depend on the box.
    network.predict(window.input(), {-cells.end_col(), cells.row, cells.width, cells.height}, 1, found.data.data(),
                    memory);
    add_mirrored(found, between_cells(box.col, box.width, scale, cells.col, cells.width),
                 between_cells(box.row, box.height, scale, cells.row, cells.height), network.class_count(), scores);
  }
  const auto share = static_cast<float>(1.0 / (1.0 + static_cast<double>(photos_.size())));
  for (std::size_t i = 0; i < scores.data.size(); i += static_cast<std::size_t>(scores.channels))
    for (int k = 0; k < network.class_count(); ++k) scores.data[i + static_cast<std::size_t>(k)] *= share;
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/segment/mirror_beyond.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace orthodrive {
namespace {

/// Where `index` lies on the way to and fro, from 0 to 2 `count` - 1; from `count` on it is on the way back.
std::int64_t on_the_round(std::int64_t index, std::int64_t count) {
  const std::int64_t round = 2 * count;
  return ((index % round) + round) % round;
}
bool is_turned(std::int64_t index, std::int64_t count) { return on_the_round(index, count) >= count; }

/// 128 is no distance; what would be 256 becomes the farthest.
void turn(std::uint8_t& distance) {
  distance = static_cast<std::uint8_t>(std::min(255, 256 - static_cast<int>(distance)));
}

}  // namespace

std::int64_t mirrored_index(std::int64_t index, std::int64_t count) {
  const std::int64_t at = on_the_round(index, count);
  return at < count ? at : 2 * count - 1 - at;
}

Raster<std::uint8_t> mirror_beyond(Raster<std::uint8_t> inside, const PixelBox& box, const GridFrame& frame) {
  const PixelBox part = intersection(box, pixels_of(frame));
  if (part == box) return inside;
  const auto channels = static_cast<std::size_t>(inside.channels);
  Raster<std::uint8_t> whole(box.width, box.height, inside.channels);
  const int left = static_cast<int>(part.col - box.col);
  for (int row = 0; row < box.height; ++row) {
    const int from = static_cast<int>(mirrored_index(box.row + row, frame.height) - part.row);
    std::memcpy(&whole.at(left, row), &inside.at(0, from), channels * static_cast<std::size_t>(part.width));
    const auto fill = [&](int col) {
      const int seen = static_cast<int>(mirrored_index(box.col + col, frame.width) - part.col);
      std::copy_n(&inside.at(seen, from), channels, &whole.at(col, row));
    };
    for (int col = 0; col < left; ++col) fill(col);
    for (int col = left + part.width; col < box.width; ++col) fill(col);
  }
  return whole;
}

Raster<std::uint8_t> mirror_map_beyond(Raster<std::uint8_t> inside, const PixelBox& box, const GridFrame& frame) {
  Raster<std::uint8_t> whole = mirror_beyond(std::move(inside), box, frame);
  for (int row = 0; row < box.height; ++row)
    if (is_turned(box.row + row, frame.height))
      for (int col = 0; col < box.width; ++col) turn(whole.at(col, row, 1));
  for (int col = 0; col < box.width; ++col)
    if (is_turned(box.col + col, frame.width))
      for (int row = 0; row < box.height; ++row) turn(whole.at(col, row, 0));
  return whole;
}

Raster<std::uint8_t> mirrored(Raster<std::uint8_t> raster) {
  for (int row = 0; row < raster.height; ++row)
    for (int west = 0, east = raster.width - 1; west < east; ++west, --east)
      std::swap_ranges(&raster.at(west, row), &raster.at(west, row) + raster.channels, &raster.at(east, row));
  return raster;
}

Raster<std::uint8_t> mirrored_map(Raster<std::uint8_t> raster) {
  raster = mirrored(std::move(raster));
  for (int row = 0; row < raster.height; ++row)
    for (int col = 0; col < raster.width; ++col) turn(raster.at(col, row, 0));
  return raster;
}

}  // namespace orthodrive

#pragma once
// A rectangle of pixels of a mosaic.

#include <cstdint>

namespace orthodrive {

struct PixelBox {
  std::int64_t col = 0, row = 0;  ///< of its north-west pixel
  int width = 0, height = 0;
  friend bool operator==(const PixelBox&, const PixelBox&) = default;
};

}  // namespace orthodrive

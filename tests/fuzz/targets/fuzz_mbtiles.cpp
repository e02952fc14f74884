// SPDX-License-Identifier: Apache-2.0
// MBTiles files, as an earlier fetch left them, and stores of tiles that are not complete.

#include <cstdio>
#include <stdexcept>

#include "memory_file.hpp"
#include "orthodrive/remote/tiles/tile_store.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::MemoryFile file;
  try {
    std::size_t bytes = 0;
    (void)orthodrive::remote::visit_mbtiles(
        file.with(data, size), "plan", 4,
        [&](orthodrive::remote::TileAddress tile, const orthodrive::remote::StoredTile& stored) {
          bytes += stored.bytes.size() + static_cast<std::size_t>(tile.column != 0);
        });
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}

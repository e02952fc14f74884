// SPDX-License-Identifier: Apache-2.0
// What WMTS and WMS servers say of themselves, and the tiles that an area has in the grids they describe.

#include <stdexcept>

#include "memory_file.hpp"
#include "orthodrive/remote/http/url_template.hpp"
#include "orthodrive/remote/tiles/capabilities.hpp"
#include "orthodrive/remote/tiles/tile_matrix.hpp"

namespace {
using namespace orthodrive;

/// As remote/tile_services.cpp makes it, without a look at the CRS.
void address_tiles(const remote::WmtsMatrix& m) {
  remote::TileMatrixSet set{"set", {"EPSG:3857"}, {}};
  set.matrices.push_back({m.identifier, m.scale_denominator * 0.00028, m.corner[0], m.corner[1], m.tile_width,
                          m.tile_height, m.columns, m.rows});
  (void)remote::quad_zoom(set.matrices[0]);
  (void)remote::fine_enough(set, 0.5);
  for (const double size : {1.0, 1000.0, 1e9}) {
    const double x = 1747000.0, y = 6452000.0;
    const Polygon area{{{x, y}, {x + size, y}, {x + size, y + size}}, {}};
    const auto tiles = remote::tiles_over(set.matrices[0], area, 100);
    if (!tiles) continue;
    for (const remote::TileAddress tile : *tiles) {
      if (tile.column < 0 || tile.row < 0 || tile.column >= m.columns || tile.row >= m.rows) std::abort();
      (void)remote::bounds_of_tile(set.matrices[0], tile);
    }
  }
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);  // NOLINT: bytes are characters
  try {
    const remote::WmtsCapabilities found = remote::parse_wmts_capabilities(text, "a");
    for (const remote::WmtsMatrixSet& set : found.matrix_sets) {
      (void)remote::crs_code_of(set.crs);
      for (const remote::WmtsMatrix& matrix : set.matrices) address_tiles(matrix);
    }
    for (const remote::WmtsLayer& layer : found.layers) {
      (void)remote::by_likeness(layer.styles, layer.identifier);
      for (const auto& [format, pattern] : layer.resource_urls)
        (void)remote::filled(pattern, {{"TileRow", "1"}, {"Style", pattern}});
    }
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  try {
    for (const remote::WmsLayer& layer : remote::parse_wms_capabilities(text, "a").layers)
      for (const std::string& crs : layer.crs) (void)remote::crs_code_of(crs);
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}

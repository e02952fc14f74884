// SPDX-License-Identifier: Apache-2.0
// OpenCRG files, text or binary: read, made ready, asked.

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "memory_file.hpp"
#include "roadquery/crg/crg_grid.hpp"
#include "roadquery/crg/read_crg.hpp"

namespace {

void ask(const roadquery::CrgGrid& grid) {
  const double infinite = std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const double share : {-1e9, -0.3, 0.0, 0.37, 1.0, 1.6, 1e300, infinite, -infinite, std::nan("")}) {
    const double u = grid.u_first_m() + share * (grid.u_last_m() - grid.u_first_m());
    const double v = grid.v_first_m() + 0.8 * share * (grid.v_last_m() - grid.v_first_m());
    for (const auto part : {roadquery::CrgPart::grid, roadquery::CrgPart::whole}) {
      const roadquery::CrgHeight height = grid.evaluate(u, v, part);
      sum += height.z_m + height.dz_du + height.dz_dv;
    }
    const double x = grid.start_x_m() + share, y = grid.start_y_m() - share;
    if (const auto place = grid.place(x, y, u))
      sum += grid.evaluate(place->u_m, place->v_m, roadquery::CrgPart::whole).z_m;
    if (const auto place = grid.place(x, y)) sum += place->du_dx + place->dv_dy;
  }
  volatile double kept = sum;
  (void)kept;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const roadquery::CrgFile file =
        roadquery::parse_crg({reinterpret_cast<const char*>(data), size}, "a.crg");  // NOLINT: bytes are characters
    ask(roadquery::CrgGrid(file));
  } catch (const std::runtime_error& error) {
    fuzz::expect_one_line(error.what());
  }
  return 0;
}

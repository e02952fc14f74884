// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/geo/geoid.hpp"

#include <proj.h>

#include <cmath>

#include "orthodrive/geo/proj_operation.hpp"

namespace orthodrive {

Geoid::Geoid() : proj_(std::make_unique<ProjOperation>()) {
  for (const char* grid : {"us_nga_egm08_25.tif", "egm08_25.gtx", "us_nga_egm96_15.tif", "egm96_15.gtx"}) {
    const std::string shift = std::string("+proj=vgridshift +multiplier=1 +grids=") + grid;  // adds the grid's value
    proj_->operation = proj_create(proj_->context, shift.c_str());
    if (proj_->operation == nullptr) continue;
    grid_ = grid;
    return;
  }
}
Geoid::~Geoid() = default;
Geoid::Geoid(Geoid&&) noexcept = default;
Geoid& Geoid::operator=(Geoid&&) noexcept = default;

double Geoid::height_m(double longitude_deg, double latitude_deg) const {
  if (proj_->operation == nullptr) return 0.0;
  const PJ_COORD place = proj_coord(proj_torad(longitude_deg), proj_torad(latitude_deg), 0.0, HUGE_VAL);
  const double height = proj_trans(proj_->operation, PJ_FWD, place).xyz.z;
  return std::isfinite(height) ? height : 0.0;
}

}  // namespace orthodrive

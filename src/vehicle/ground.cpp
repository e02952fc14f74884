// SPDX-License-Identifier: Apache-2.0
#include "vehicle/ground.hpp"

#include <cmath>

namespace vehicle {

PlaneGround::PlaneGround(double z0_m, double gradient_x, double gradient_y, double friction)
    : z0_m_(z0_m), gradient_x_(gradient_x), gradient_y_(gradient_y) {
  const double length = std::sqrt(1.0 + gradient_x * gradient_x + gradient_y * gradient_y);
  point_.normal = {-gradient_x / length, -gradient_y / length, 1.0 / length};
  point_.friction = friction;
}

GroundPoint PlaneGround::at(int /*wheel*/, double x_m, double y_m, double /*z_guess_m*/) {
  point_.z_m = z0_m_ + gradient_x_ * x_m + gradient_y_ * y_m;
  return point_;
}

}  // namespace vehicle

// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a car asks of the world below it.

#include <array>

namespace vehicle {

/// The road under one wheel.
struct GroundPoint {
  double z_m = 0.0;                                ///< height at the (x, y) that was asked
  std::array<double, 3> normal = {0.0, 0.0, 1.0};  ///< unit, upwards
  double friction = 1.0;                           ///< scales the grip of the tyre: 1 = dry asphalt
  bool on_road = true;                             ///< false: beside the road; the height is still one to stand on
};

/// Answers where the road is. A car asks four times a step, always with the same index for the same wheel (0 front
/// left, 1 front right, 2 rear left, 3 rear right), so that an implementation can keep a cursor for each.
class Ground {
 public:
  Ground() = default;
  Ground(const Ground&) = default;
  Ground& operator=(const Ground&) = default;
  virtual ~Ground() = default;

  /// Height and normal at (x, y) in metres, world frame; z_guess_m is a height near the one that is wanted (it tells a
  /// deck from the road below). A height that is not finite means nothing is there: the wheel hangs in the air.
  [[nodiscard]] virtual GroundPoint at(int wheel, double x_m, double y_m, double z_guess_m) = 0;
};

/// An endless plane z = z0 + gradient_x x + gradient_y y.
class PlaneGround final : public Ground {
 public:
  explicit PlaneGround(double z0_m = 0.0, double gradient_x = 0.0, double gradient_y = 0.0, double friction = 1.0);
  [[nodiscard]] GroundPoint at(int wheel, double x_m, double y_m, double z_guess_m) override;

 private:
  double z0_m_, gradient_x_, gradient_y_;
  GroundPoint point_;
};

}  // namespace vehicle

// SPDX-License-Identifier: Apache-2.0
#pragma once
// The one rule of how overlapping roads make one surface: for the query and for the mesh.

#include <algorithm>
#include <cmath>

namespace roadquery {

/// Surfaces less than this apart in height are one level. Those of one junction differ by less, the floors of a car
/// park by more.
inline constexpr double same_level_m = 1.5;

inline bool is_same_level(double z, double level_z) { return std::abs(z - level_z) <= same_level_m; }

/// How much a road counts at a point `inside_m` from the nearest of its own edges and ends: a road fades in where it
/// begins. Not 0, so that a point on the very borders of all has a height, too.
inline double blend_weight(double inside_m) {
  constexpr double border_weight_m = 1e-6;
  return std::max(inside_m, 0.0) + border_weight_m;
}

/// The weighted mean of surfaces.
class Blend {
 public:
  void add(double inside_m, double z) {
    const double weight = blend_weight(inside_m);
    weight_ += weight, z_ += weight * z;
  }
  void add(double inside_m, double z, const double (&normal)[3]) {
    add(inside_m, z);
    const double weight = blend_weight(inside_m);
    for (int k = 0; k < 3; ++k) normal_[k] += weight * normal[k];
  }
  [[nodiscard]] double z() const { return z_ / weight_; }
  /// Unit.
  void get_normal(double (&normal)[3]) const {
    const double scale = 1.0 / std::sqrt(normal_[0] * normal_[0] + normal_[1] * normal_[1] + normal_[2] * normal_[2]);
    for (int k = 0; k < 3; ++k) normal[k] = normal_[k] * scale;
  }

 private:
  double weight_ = 0.0, z_ = 0.0;
  double normal_[3] = {0.0, 0.0, 0.0};
};

}  // namespace roadquery

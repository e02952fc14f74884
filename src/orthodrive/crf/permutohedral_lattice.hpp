// SPDX-License-Identifier: Apache-2.0
#pragma once
// Gaussian filtering of scattered values in D dimensions, in time linear in the number of points.
// Adams, Baek, Davis, Fast High-Dimensional Filtering Using the Permutohedral Lattice, 2010. A point lies in a simplex
// of the lattice; its value goes to the D + 1 corners (splat), is spread along the D + 1 axes by [1/2 1 1/2] (blur),
// and is collected from the same corners (slice). Vertices that no point touches do not exist and count as zero, as in
// the code of Kraehenbuehl and Koltun 2012.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace orthodrive {

/// Where a point lies: the corners of its simplex and its barycentric weights (or these times a factor of the point).
template <int D>
struct LatticePoint {
  std::uint32_t vertex[D + 1];
  float weight[D + 1];
};

/// The vertices that lie in a row along one axis. Vertices without any neighbour on the axis are left out: the blur
/// does not change them.
struct BlurAxis {
  std::vector<std::uint32_t> pairs;   ///< rows of two vertices, one after the other
  std::vector<std::uint32_t> chains;  ///< longer rows, each as its length and then its vertices
};

enum class BlurOrder { forward, transposed };

template <int D>
class PermutohedralLattice {
 public:
  static constexpr std::size_t block = 64;
  /// Writes the features of points [first, first + count), count <= block, to features[f * block + i], in standard
  /// deviations of the Gaussian. Called once for every point, in order.
  using FeatureSource = std::function<void(std::size_t first, std::size_t count, double* features)>;
  struct Range {
    std::array<double, D> low, high;  ///< every feature lies in between
  };

  PermutohedralLattice() = default;
  /// Vertices are numbered as they are first touched, so points that follow one another should lie close together.
  /// Throws OptionError when the range holds more lattice cells than 64 bits can tell apart.
  PermutohedralLattice(std::size_t points, const Range& range, const FeatureSource& source);

  [[nodiscard]] std::size_t vertices() const { return vertices_; }
  [[nodiscard]] const std::vector<LatticePoint<D>>& points() const { return points_; }
  [[nodiscard]] const std::array<BlurAxis, D + 1>& axes() const { return axes_; }

  /// Multiplies the weights of point i by factors[i]: filtering then gives F K F instead of K, F = diag(factors).
  void scale(std::span<const float> factors);

  /// splat, blur, slice of one value a point. The kernel is about exp(-|a - b|^2 / 2) times a constant.
  /// `transposed` blurs along the axes in reverse order: the exact transpose of `forward`. Both would be the same
  /// matrix if no vertices were missing.
  [[nodiscard]] std::vector<float> filter(std::span<const float> values, BlurOrder order = BlurOrder::forward) const;

 private:
  std::size_t vertices_ = 0;
  std::vector<LatticePoint<D>> points_;
  std::array<BlurAxis, D + 1> axes_;
};

extern template class PermutohedralLattice<2>;
extern template class PermutohedralLattice<5>;

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Junctions with a surface of their own, side by side in memory.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/tables/cell_index.hpp"
#include "roadquery/tables/large_vector.hpp"

namespace roadquery {

/// A junction's own surface under a point.
struct JunctionOver {
  std::uint32_t junction = no_index;  ///< index into RoadMap::junctions; no_index: none
  JunctionHeight at;
};

class JunctionIndex {
 public:
  JunctionIndex() = default;
  /// Throws std::runtime_error for a junction wider than 5 km.
  explicit JunctionIndex(const RoadMap& map);

  [[nodiscard]] bool empty() const { return areas_.empty(); }
  /// As contains() of junction_surface.hpp, from a few edges of the boundary.
  [[nodiscard]] bool contains(std::uint32_t junction, double x, double y) const;
  /// Of the surfaces over (x, y), a point of the cell, the one nearest to z_hint (NaN: the highest).
  [[nodiscard]] JunctionOver over(const Cell& cell, double x, double y, double z_hint) const;
  /// The surface of one junction, where it is under (x, y).
  [[nodiscard]] JunctionOver over(std::uint32_t junction, double x, double y) const;
  /// Lets the memory that over() will read come while other work is done; call both, with some work before each.
  void fetch_first(const Cell& cell) const;
  void fetch_second(const Cell& cell, double x, double y) const;
  /// Indices of the connecting roads of a junction.
  [[nodiscard]] const std::vector<std::uint32_t>& roads(std::uint32_t junction) const { return roads_[junction]; }

 private:
  /// The boundary is cut into horizontal strips, each with the edges that pass it.
  struct alignas(64) Area {
    double west = 1.0, east = -1.0, south = 1.0, north = -1.0;
    double strips_per_m = 0.0;
    std::uint32_t strips = 1, first_strip = 0;  ///< in strip_begin_
    std::uint32_t z = 0, arms = 0;              ///< first in z_ and arms_
    double x = 0.0, y = 0.0, spacing_m = 1.0;
    std::int32_t columns = 0, rows = 0;
    std::uint32_t arm_count = 0;
    std::uint32_t inner = 0;  ///< first in inner_
    double inverse_spacing = 1.0;
  };
  static_assert(sizeof(Area) == 128);
  struct Edge {
    double x0, y0, x1, y1;
  };
  void add(const JunctionSurface& surface);
  /// What is known of a cell. From first_arm on: all of it lies inside, and of the arms only number (value - first_arm)
  /// counts there.
  enum Inner : std::uint8_t { unknown, no_arm, several_arms, first_arm };
  void find_inner(const JunctionSurface& surface, std::uint32_t junction);
  void cut_into_strips(std::span<const std::array<double, 2>> ring, Area& area);

  LargeVector<Area> areas_;  // of each junction; empty when none has a surface
  LargeVector<std::uint32_t> strip_begin_;
  LargeVector<Edge> edges_;
  LargeVector<double> z_;
  LargeVector<JunctionArm> arms_;
  LargeVector<std::uint8_t> inner_;  // of each cell of the field, by its first node: see Inner
  std::vector<std::vector<std::uint32_t>> roads_;
};

}  // namespace roadquery

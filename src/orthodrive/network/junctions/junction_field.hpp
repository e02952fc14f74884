// SPDX-License-Identifier: Apache-2.0
#pragma once
// The height field of a junction: as smooth as the roads that meet there allow.

#include <vector>

#include "orthodrive/network/junctions/road_cover.hpp"

namespace orthodrive::network {

struct FieldGrid {
  Vec2 origin;  ///< of the first node: south-west corner
  double spacing_m = 1.0;
  int columns = 0, rows = 0;
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  [[nodiscard]] Vec2 node(std::size_t i) const {
    const auto n = static_cast<std::size_t>(columns);
    const std::size_t row = i / n, column = i - row * n;
    return origin + Vec2{static_cast<double>(column), static_cast<double>(row)} * spacing_m;
  }
};

/// What a node should have. `smoothing_m`: where the field has to leave the target it comes back over about this
/// length; 0: the node is fixed. Infinite: nothing is known.
struct NodeTarget {
  double z = 0.0, smoothing_m = INFINITY;
};

/// Minimises the bending energy of a thin plate with springs to the targets,
///
///     sum (z_xx^2 + 2 z_xy^2 + z_yy^2) h^2 + sum (z - target)^2 / smoothing^4 h^2,
///
/// by second differences over the grid (Terzopoulos, The computation of visible-surface representations, IEEE Trans.
/// PAMI 10, 1988), solved by sparse Cholesky. Free at the border: without targets there the field goes on straight.
/// Exact for planes. Where the targets leave it undetermined (fewer than three, or on one line) the mean of the targets
/// or the plane through them is taken. `asked`: nodes that are solved, all where it is empty; the others get the plane.
[[nodiscard]] std::vector<double> bend_least(const FieldGrid& grid, const std::vector<NodeTarget>& targets,
                                             const std::vector<char>& asked = {});

/// How the field follows a road.
enum class RoadRole {
  arm,       ///< outside the junction: fixed
  beside,    ///< no road of the junction, but one of its roads lies on it: fixed where no arm is
  main,      ///< the way straight on that keeps its shape, crown included
  straight,  ///< another way straight on: gives way to what it crosses
  turning,   ///< weak: only where nothing else says anything
};
/// A road over the grid: its height at every node that it covers, by node.
struct FieldRoad {
  RoadRole role = RoadRole::turning;
  struct Node {
    std::size_t node = 0;
    double z = 0.0;
  };
  std::vector<Node> nodes;
};

/// Arms count with their sidewalks. Of the nodes `asked`, all where it is empty.
[[nodiscard]] FieldRoad over_grid(const FieldGrid& grid, const RoadCover& cover, RoadRole role,
                                  const std::vector<char>& asked = {});

/// Targets from the roads that cover each node: the strongest role that covers it, the mean where several do.
/// `entries`: arms in the grid's coordinates; where no way straight on leads in, their strips go on straight, strongly
/// at first, for the length over which the surface turns into them (junction_surface.hpp).
[[nodiscard]] std::vector<NodeTarget> field_targets(const FieldGrid& grid, const std::vector<FieldRoad>& roads,
                                                    const std::vector<roadquery::JunctionArm>& entries);

}  // namespace orthodrive::network

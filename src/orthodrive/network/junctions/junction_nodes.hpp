// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which nodes of a grid a boundary needs: a field is bicubic, a place takes the sixteen nodes about it.

#include <vector>

#include "orthodrive/network/junctions/junction_field.hpp"

namespace orthodrive::network {

/// Per node 1 or 0: whether it lies inside the ring (even-odd rule).
[[nodiscard]] std::vector<char> nodes_inside(const FieldGrid& grid, const Ring& boundary);

/// Nodes that some place inside the ring takes its height from.
[[nodiscard]] std::vector<char> nodes_for(const FieldGrid& grid, const Ring& boundary);

/// With the neighbours up to so many nodes away, diagonal ones, too.
[[nodiscard]] std::vector<char> grown(const FieldGrid& grid, std::vector<char> nodes, int steps);

/// Heights go on straight for 4 m beyond the nodes: for grids of wider spacing, which need nodes further away.
void extend(const FieldGrid& grid, std::vector<char> nodes, std::vector<double>& z);

}  // namespace orthodrive::network

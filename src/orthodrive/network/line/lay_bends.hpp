// SPDX-License-Identifier: Apache-2.0
#pragma once
// Heights of bends that were eased. Easing draws the nodes of a corner together: with the heights that they had, a rise
// of ten metres of road would lie on two. So the bend gets the plane that its nodes lay in.

#include "orthodrive/network/line/chain_line.hpp"

namespace orthodrive::network {

/// `nodes` were `before` until a bend was eased; node i was before[was[i]], ascending. Where they moved they get height
/// and banking of the plane through what the carriageway was there; what this changes at the ends of the bend fades out
/// beside it. Closed lines end with a copy of their first node.
void lay_bends(std::vector<ChainLineNode>& nodes, const std::vector<ChainLineNode>& before,
               const std::vector<std::size_t>& was, bool closed);

}  // namespace orthodrive::network

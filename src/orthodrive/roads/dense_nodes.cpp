// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/roads/dense_nodes.hpp"

#include <cassert>
#include <cmath>
#include <utility>

#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive {

RoadNetwork with_nodes_every(RoadNetwork roads, double step_m) {
  assert(step_m > 0.0);
  for (RoadPath& path : roads.paths) {
    std::vector<RoadNode> dense;
    for (std::size_t n = 0; n + 1 < path.nodes.size(); ++n) {
      const RoadNode &a = path.nodes[n], &b = path.nodes[n + 1];
      dense.push_back(a);
      const int parts = static_cast<int>(std::ceil(distance(a.p, b.p) / step_m));
      for (int i = 1; i < parts; ++i) {
        const double f = static_cast<double>(i) / parts;
        RoadNode& node = dense.emplace_back(a);
        const auto between = [&](auto member) { node.*member = a.*member + (b.*member - a.*member) * f; };
        node.osm_node = no_osm_node;
        node.kerb_radius_m = 0.0;
        node.p = a.p + (b.p - a.p) * f;
        for (double RoadNode::*const member :
             {&RoadNode::s_m, &RoadNode::offset_m, &RoadNode::width_m, &RoadNode::sigma_offset_m,
              &RoadNode::sigma_width_m, &RoadNode::z_m, &RoadNode::gradient, &RoadNode::banking, &RoadNode::crown,
              &RoadNode::sigma_z_m, &RoadNode::sigma_banking})
          between(member);
      }
    }
    if (!path.nodes.empty()) dense.push_back(path.nodes.back());
    path.nodes = std::move(dense);
  }
  return roads;
}

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/roads/inner_ways.hpp"

#include <algorithm>
#include <utility>

namespace orthodrive::network {
namespace {

constexpr double inner_look_m = 8.0;  // over which an inner way of a joined junction has its direction

InnerWay inner_way(const NetworkPlan& plan, const Stretch& stretch) {
  const Chain& chain = plan.topology.chains[stretch.chain];
  const ChainGeometry& geometry = plan.geometry[stretch.chain];
  InnerWay inner{
      .vertex0 = stretch.vertex0, .vertex1 = stretch.vertex1, .leg = {stretch.chain, stretch.s0, stretch.s1}};
  const auto place = [&](double s) { return pose_at(geometry.plan, std::clamp(s, stretch.s0, stretch.s1)).p; };
  inner.direction0 = normalized(place(stretch.s0 + inner_look_m) - place(stretch.s0));
  inner.direction1 = normalized(place(stretch.s1) - place(stretch.s1 - inner_look_m));
  for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
    if (geometry.vertex_s[k] < stretch.s0 || geometry.vertex_s[k + 1] > stretch.s1) continue;
    const DirectedPiece part = chain.pieces[k];
    const RoadPath& path = plan.roads.paths[plan.topology.pieces[part.piece].path];
    if (!inner.ways.empty()) inner.nodes.push_back(plan.topology.vertices[start_vertex(plan.topology, part)].osm_node);
    inner.ways.push_back(path.osm_id);
    if (path.oneway != Oneway::no) (part.reversed ? inner.forward : inner.backward) = false;
  }
  return inner;
}

}  // namespace

std::vector<std::vector<InnerWay>> inner_ways(const NetworkPlan& plan, std::size_t junctions) {
  std::vector<std::vector<InnerWay>> ways(junctions);
  for (const Stretch& stretch : plan.junctions.stretches)
    if (stretch.inside && stretch.vertex0 && stretch.vertex1)
      ways[as_index(plan.junctions.junction_of_vertex[stretch.vertex0])].push_back(inner_way(plan, stretch));
  return ways;
}

std::int64_t node_of(const NetworkPlan& plan, VertexIndex vertex) { return plan.topology.vertices[vertex].osm_node; }

std::optional<DrivenWay> driven_over(const TurnRules& rules, DrivenWay driven, std::int64_t node, const InnerWay& inner,
                                     bool forward) {
  const std::size_t count = inner.ways.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t way = inner.ways[forward ? i : count - 1 - i];
    if (i > 0) node = inner.nodes[forward ? i - 1 : count - 1 - i];
    if (rules.forbid(driven, node, way)) return std::nullopt;
    driven = rules.drive_on(driven, node, way);
  }
  return driven;
}

InnerWay way_to_cut(const NetworkPlan& plan, const TurnRules& rules, const JunctionEnd& end) {
  InnerWay inner;
  if (!rules.are_told()) {
    inner.ways.push_back(plan.roads.paths[end.path].osm_id);
    return inner;
  }
  const Stretch& stretch = plan.junctions.stretches[end.stretch];
  const Chain& chain = plan.topology.chains[stretch.chain];
  const ChainGeometry& geometry = plan.geometry[stretch.chain];
  const double s0 = end.at_begin ? stretch.s0 : end.chain_s, s1 = end.at_begin ? end.chain_s : stretch.s1;
  constexpr double touches_m = 1e-6;
  for (std::size_t k = 0; k < chain.pieces.size(); ++k) {
    if (geometry.vertex_s[k] > s1 - touches_m || geometry.vertex_s[k + 1] < s0 + touches_m) continue;
    const DirectedPiece part = chain.pieces[k];
    if (!inner.ways.empty()) inner.nodes.push_back(node_of(plan, start_vertex(plan.topology, part)));
    inner.ways.push_back(plan.roads.paths[plan.topology.pieces[part.piece].path].osm_id);
  }
  if (inner.ways.empty()) inner.ways.push_back(plan.roads.paths[end.path].osm_id);
  if (end.at_begin) return inner;
  std::ranges::reverse(inner.ways), std::ranges::reverse(inner.nodes);
  return inner;
}

std::optional<DrivenWay> driven_in(const TurnRules& rules, const InnerWay& to_cut) {
  return driven_over(rules, {to_cut.ways.back(), {}}, 0, to_cut, false);
}

std::vector<Arrival> arrivals_from(const NetworkPlan& plan, const std::vector<InnerWay>& inside, const TurnRules& rules,
                                   Arrival start) {
  constexpr std::size_t most_arrivals = 4096;  // against maps whose restrictions are made to harm
  std::vector<Arrival> arrivals{std::move(start)};
  for (const bool round : {false, true})
    for (std::size_t next = 0; next < arrivals.size() && arrivals.size() < most_arrivals; ++next) {
      const Arrival here = arrivals[next];
      const auto drive = [&](bool forward, VertexIndex from, Vec2 into, Arrival there) {
        const InnerWay& inner = *there.on;
        if (!(forward ? inner.forward : inner.backward) || from != here.vertex || here.on == there.on) return;
        const std::optional<DrivenWay> driven =
            driven_over(rules, here.driven, node_of(plan, here.vertex), inner, forward);
        if (!driven) return;
        there.driven = *driven;
        there.turned = here.turned || turns_round(here.direction, into);
        const auto known = [&](const Arrival& a) {
          return a.vertex == there.vertex && a.on == there.on && a.driven == there.driven;
        };
        if (there.turned && !round) return;
        if (std::ranges::any_of(arrivals, known)) return;
        there.legs.insert(there.legs.begin(), here.legs.begin(), here.legs.end());
        arrivals.push_back(there);
      };
      for (const InnerWay& w : inside) {
        drive(true, w.vertex0, w.direction0, {w.vertex1, {}, w.direction1, &w, false, {w.leg}});
        drive(false, w.vertex1, w.direction1 * -1.0,
              {w.vertex0, {}, w.direction0 * -1.0, &w, false, {{w.leg.chain, w.leg.s1, w.leg.s0}}});
      }
    }
  return arrivals;
}

}  // namespace orthodrive::network

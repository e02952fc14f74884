// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fields of fitted chains and junctions that processes which share a network hand each other
// (core/byte_archive.hpp).

#include "orthodrive/model/archived_fields.hpp"
#include "orthodrive/network/junctions/junction_members.hpp"
#include "orthodrive/network/line/chain_geometry.hpp"
#include "roadquery/map/road_map.hpp"

namespace roadquery {

template <typename Archive>
void fields(Archive& /*archive*/, Line& /*line*/) {}
template <typename Archive>
void fields(Archive& archive, Arc& a) {
  archive(a.curvature);
}
template <typename Archive>
void fields(Archive& archive, Spiral& s) {
  archive(s.curvature_start, s.curvature_end);
}
template <typename Archive>
void fields(Archive& archive, ParamPoly3& p) {
  archive(p.a_u, p.b_u, p.c_u, p.d_u, p.a_v, p.b_v, p.c_v, p.d_v, p.normalized);
}
template <typename Archive>
void fields(Archive& archive, PlanElement& e) {
  archive(e.s, e.x, e.y, e.hdg, e.length, e.shape);
}
template <typename Archive>
void fields(Archive& archive, Cubic& c) {
  archive(c.s, c.a, c.b, c.c, c.d);
}
/// Without arms: join_arms() finds them.
template <typename Archive>
void fields(Archive& archive, JunctionSurface& s) {
  archive(s.boundary, s.x, s.y, s.spacing_m, s.columns, s.rows, s.z);
}

}  // namespace roadquery

namespace orthodrive::network {

template <typename Archive>
void fields(Archive& archive, ProfileSample& s) {
  archive(s.s, s.value);
}
template <typename Archive>
void fields(Archive& archive, ChainGeometry& g) {
  archive(g.closed, g.length_m, g.plan, g.elevation, g.superelevation, g.crown, g.vertex_s, g.widths,
          g.max_plan_deviation_m, g.max_elevation_error_m, g.eased_nodes, g.findings);
}
template <typename Archive>
void fields(Archive& archive, JunctionGround& g) {
  archive(g.boundary, g.origin, g.area_m2);
}

}  // namespace orthodrive::network

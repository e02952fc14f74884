// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small road networks drawn by hand, and what must hold for every map.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "orthodrive/network/build_network.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::network_test {

inline const Vec2 site_origin{650000.0, 6400000.0};  // UTM, where single digits of a double count

struct PathOptions {
  std::int64_t osm_id = 1;
  std::string highway = "residential";
  double width_m = 6.0;
  Oneway oneway = Oneway::no;
  int lanes = 0;
  bool roundabout = false;
  std::function<double(Vec2)> height;     ///< none: no heights
  std::function<double(double)> banking;  ///< of s
};

/// A path through `corners`, sampled about every 2 m. ids[i] > 0 marks corner i as an OSM node.
inline RoadPath make_path(const std::vector<Vec2>& corners, const std::vector<std::int64_t>& ids,
                          const PathOptions& o = {}) {
  RoadPath path;
  path.osm_id = o.osm_id, path.highway = o.highway, path.oneway = o.oneway, path.lanes = o.lanes;
  path.roundabout = o.roundabout;
  double s = 0.0;
  const auto add = [&](Vec2 p, std::int64_t id) {
    if (!path.nodes.empty()) s += distance(path.nodes.back().p, p + site_origin);
    RoadNode node{.p = p + site_origin, .osm_node = id, .s_m = s, .width_m = o.width_m};
    if (o.height) node.z_m = o.height(p);
    if (o.banking) node.banking = o.banking(s);
    path.nodes.push_back(node);
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i > 0) {
      const int steps = std::max(1, static_cast<int>(std::round(distance(corners[i - 1], corners[i]) / 2.0)));
      for (int k = 1; k < steps; ++k)
        add(corners[i - 1] + (corners[i] - corners[i - 1]) * (static_cast<double>(k) / steps), 0);
    }
    add(corners[i], i < ids.size() ? ids[i] : 0);
  }
  return path;
}

/// Points of a circle arc, about 2 m apart, from `from_rad` over `turn_rad` (positive = counter-clockwise).
inline std::vector<Vec2> circle_points(Vec2 center, double radius_m, double from_rad, double turn_rad) {
  const int steps = std::max(2, static_cast<int>(std::ceil(std::abs(turn_rad) * radius_m / 2.0)));
  std::vector<Vec2> points;
  for (int i = 0; i <= steps; ++i) {
    const double a = from_rad + turn_rad * i / steps;
    points.push_back(center + Vec2{std::cos(a), std::sin(a)} * radius_m);
  }
  return points;
}

inline RoadNetwork network_of(std::vector<RoadPath> paths) { return {{"EPSG:32633"}, std::move(paths)}; }

inline const roadquery::Road* road_by_id(const roadquery::RoadMap& map, int id) {
  const auto road = std::lower_bound(map.roads.begin(), map.roads.end(), id,
                                     [](const roadquery::Road& r, int wanted) { return r.id < wanted; });
  return road != map.roads.end() && road->id == id ? &*road : nullptr;
}

/// How roads differ where they are linked.
struct JointGaps {
  double position_m = 0.0, heading_rad = 0.0, curvature = 0.0, z_m = 0.0, gradient = 0.0, banking_rad = 0.0,
         edge_m = 0.0;
  int joints = 0;
};

struct EndPose {
  double x, y, heading, curvature, z, gradient, banking, left_t, right_t;
};

/// A road's end seen in the direction in which it is left (`leaving`) or entered.
inline EndPose end_pose(const roadquery::Road& road, roadquery::ContactPoint contact, bool leaving) {
  const bool at_end = contact == roadquery::ContactPoint::end, along = at_end == leaving;
  const double s = at_end ? road.length : 0.0, sign = along ? 1.0 : -1.0;
  const roadquery::PlanPoint q = roadquery::reference_point(road, s);
  const roadquery::Edges edges = roadquery::road_edges(road, s);
  return {q.x,
          q.y,
          q.hdg + (along ? 0.0 : M_PI),
          sign * q.curvature,
          roadquery::elevation(road, s),
          sign * roadquery::gradient(road, s),
          sign * roadquery::superelevation(road, s),
          along ? edges.left_t : -edges.right_t,
          along ? edges.right_t : -edges.left_t};
}

inline void measure(const EndPose& a, const EndPose& b, bool edges, JointGaps& gaps) {
  gaps.position_m = std::max(gaps.position_m, std::hypot(a.x - b.x, a.y - b.y));
  gaps.heading_rad = std::max(gaps.heading_rad, std::abs(std::remainder(a.heading - b.heading, 2.0 * M_PI)));
  if (edges) gaps.curvature = std::max(gaps.curvature, std::abs(a.curvature - b.curvature));
  gaps.z_m = std::max(gaps.z_m, std::abs(a.z - b.z));
  gaps.gradient = std::max(gaps.gradient, std::abs(a.gradient - b.gradient));
  gaps.banking_rad = std::max(gaps.banking_rad, std::abs(a.banking - b.banking));
  if (edges) gaps.edge_m = std::max({gaps.edge_m, std::abs(a.left_t - b.left_t), std::abs(a.right_t - b.right_t)});
  ++gaps.joints;
}

/// Heights and cross slopes at five places across what both roads cover.
inline void measure_surface(const roadquery::Road& from, roadquery::ContactPoint from_contact,
                            const roadquery::Road& to, roadquery::ContactPoint to_contact, JointGaps& gaps) {
  const EndPose a = end_pose(from, from_contact, true), b = end_pose(to, to_contact, false);
  const double left = std::min(a.left_t, b.left_t), right = std::max(a.right_t, b.right_t);
  ASSERT_GT(left, right) << "road " << from.id << " and road " << to.id << " lie beside each other";
  const auto height = [](const roadquery::Road& road, roadquery::ContactPoint contact, bool leaving, double t) {
    const bool at_end = contact == roadquery::ContactPoint::end;
    return roadquery::surface_height(road, at_end ? road.length : 0.0, at_end == leaving ? t : -t);
  };
  double last_a = 0.0, last_b = 0.0;
  for (int k = 0; k <= 4; ++k) {
    const double t = right + (left - right) * k / 4.0;
    const double z_a = height(from, from_contact, true, t), z_b = height(to, to_contact, false, t);
    gaps.z_m = std::max(gaps.z_m, std::abs(z_a - z_b));
    if (k > 0)
      gaps.banking_rad = std::max(gaps.banking_rad, std::abs((z_a - last_a) - (z_b - last_b)) * 4.0 / (left - right));
    last_a = z_a, last_b = z_b;
  }
}

/// A connecting road may have its reference line beside that of the road that it goes on from, where its lanes would
/// fold: then it must lie on that road's surface at the same places, in position, heading and height.
inline void measure_beside(const roadquery::Road& from, roadquery::ContactPoint from_contact, const roadquery::Road& to,
                           roadquery::ContactPoint to_contact, double t_m, JointGaps& gaps) {
  const EndPose a = end_pose(from, from_contact, true), b = end_pose(to, to_contact, false);
  gaps.heading_rad = std::max(gaps.heading_rad, std::abs(std::remainder(a.heading - b.heading, 2.0 * M_PI)));
  const auto point = [](const roadquery::Road& road, roadquery::ContactPoint contact, bool leaving, double t) {
    const bool at_end = contact == roadquery::ContactPoint::end;
    return roadquery::surface_point(road, at_end ? road.length : 0.0, at_end == leaving ? t : -t);
  };
  for (const double t : {a.left_t, a.right_t}) {
    const roadquery::SurfacePoint p = point(from, from_contact, true, t), q = point(to, to_contact, false, t + t_m);
    gaps.position_m = std::max(gaps.position_m, std::hypot(p.x - q.x, p.y - q.y));
    gaps.z_m = std::max(gaps.z_m, std::abs(p.z - q.z));
  }
  ++gaps.joints;
}

/// Over all road links. Edges and curvature are compared for links outside junctions: a connecting road holds one
/// direction only and may be made of biarcs.
inline JointGaps joint_gaps(const roadquery::RoadMap& map) {
  using roadquery::ContactPoint;
  JointGaps gaps;
  for (const roadquery::Road& road : map.roads) {
    const auto check = [&](const roadquery::RoadLink& link, ContactPoint own) {
      if (link.kind != roadquery::LinkKind::road) return;
      const roadquery::Road* other = road_by_id(map, link.id);
      ASSERT_NE(other, nullptr) << "road " << road.id << " is linked to road " << link.id;
      const EndPose a = end_pose(road, own, true), b = end_pose(*other, link.contact, false);
      const double beside = -std::sin(a.heading) * (a.x - b.x) + std::cos(a.heading) * (a.y - b.y);
      if (road.junction >= 0 && std::abs(beside) > 0.1) {
        measure_beside(road, own, *other, link.contact, beside, gaps);
        return;
      }
      measure(a, b, road.junction < 0, gaps);
      measure_surface(road, own, *other, link.contact, gaps);
    };
    check(road.successor, ContactPoint::end);
    check(road.predecessor, ContactPoint::start);
  }
  return gaps;
}

/// Largest gap between the elements of a road.
inline JointGaps element_gaps(const roadquery::RoadMap& map) {
  JointGaps gaps;
  for (const roadquery::Road& road : map.roads) {
    for (std::size_t i = 1; i < road.plan.size(); ++i) {
      const roadquery::PlanPoint a = roadquery::evaluate(road.plan[i - 1], road.plan[i - 1].length);
      const roadquery::PlanPoint b = roadquery::evaluate(road.plan[i], 0.0);
      gaps.position_m = std::max(gaps.position_m, std::hypot(a.x - b.x, a.y - b.y));
      gaps.heading_rad = std::max(gaps.heading_rad, std::abs(std::remainder(a.hdg - b.hdg, 2.0 * M_PI)));
      if (road.junction < 0) gaps.curvature = std::max(gaps.curvature, std::abs(a.curvature - b.curvature));
    }
    for (std::size_t i = 1; i < road.elevation.size(); ++i) {
      const roadquery::Cubic &a = road.elevation[i - 1], &b = road.elevation[i];
      const double ds = b.s - a.s;
      gaps.z_m = std::max(gaps.z_m, std::abs(a.a + ds * (a.b + ds * (a.c + ds * a.d)) - b.a));
      gaps.gradient = std::max(gaps.gradient, std::abs(a.b + ds * (2.0 * a.c + ds * 3.0 * a.d) - b.b));
    }
  }
  return gaps;
}

/// CommonRoad refuses spirals of almost one curvature.
inline void expect_no_almost_arc(const roadquery::Road& road) {
  for (const roadquery::PlanElement& e : road.plan)
    if (const auto* spiral = std::get_if<roadquery::Spiral>(&e.shape); spiral && e.length < 3.0) {
      EXPECT_GT(std::abs(spiral->curvature_end - spiral->curvature_start), 1.4e-6) << "road " << road.id << ", " << e.s;
    }
}

/// What must hold for any map: finite, gap-free, smooth, every id resolves, every lane link resolves.
inline void expect_sound(const roadquery::RoadMap& map) {
  const JointGaps joints = joint_gaps(map), elements = element_gaps(map);
  EXPECT_LT(joints.position_m, 1e-6);
  EXPECT_LT(joints.heading_rad, 1e-6);
  EXPECT_LT(joints.curvature, 1e-6);
  EXPECT_LT(elements.curvature, 1e-6);
  EXPECT_LT(joints.z_m, 1e-6);
  EXPECT_LT(joints.gradient, 1e-6);
  EXPECT_LT(joints.banking_rad, 1e-6);
  EXPECT_LT(joints.edge_m, 1e-6);
  EXPECT_LT(elements.position_m, 1e-6);
  EXPECT_LT(elements.heading_rad, 1e-6);
  EXPECT_LT(elements.z_m, 1e-6);
  EXPECT_LT(elements.gradient, 1e-6);
  const auto has_lane = [](const roadquery::Road& road, int id) {
    const auto& side = id > 0 ? road.sections.front().left : road.sections.front().right;
    return id != 0 && static_cast<std::size_t>(std::abs(id)) <= side.size();
  };
  int last_id = 0;
  for (const roadquery::Road& road : map.roads) {
    expect_no_almost_arc(road);
    EXPECT_GT(road.id, last_id);
    last_id = road.id;
    ASSERT_FALSE(road.plan.empty());
    ASSERT_EQ(road.sections.size(), 1u);
    EXPECT_GT(road.length, 0.0);
    EXPECT_NEAR(road.length, road.plan.back().s + road.plan.back().length, 1e-7);
    for (double s = 0.0; s < road.length; s += 1.0) {
      const roadquery::PlanPoint q = roadquery::reference_point(road, s);
      ASSERT_TRUE(std::isfinite(q.x) && std::isfinite(q.hdg) && std::isfinite(roadquery::elevation(road, s)));
      const roadquery::Edges edges = roadquery::road_edges(road, s);
      ASSERT_GT(edges.left_t, edges.right_t) << "road " << road.id << " at " << s;
    }
    const auto check_lane = [&](const roadquery::Lane& lane) {
      const auto check = [&](const roadquery::RoadLink& link, const std::optional<int>& id) {
        if (!id) return;
        ASSERT_EQ(link.kind, roadquery::LinkKind::road);
        EXPECT_TRUE(has_lane(*road_by_id(map, link.id), *id));
      };
      check(road.predecessor, lane.predecessor);
      check(road.successor, lane.successor);
    };
    for (const roadquery::Lane& lane : road.sections.front().left) check_lane(lane);
    for (const roadquery::Lane& lane : road.sections.front().right) check_lane(lane);
  }
  for (const roadquery::Junction& junction : map.junctions) {
    EXPECT_FALSE(junction.connections.empty());
    for (const roadquery::Connection& connection : junction.connections) {
      const roadquery::Road *in = road_by_id(map, connection.incoming_road),
                            *via = road_by_id(map, connection.connecting_road);
      ASSERT_TRUE(in && via);
      EXPECT_EQ(via->junction, junction.id);
      EXPECT_FALSE(connection.lane_links.empty());
      for (const roadquery::LaneLink& link : connection.lane_links)
        EXPECT_TRUE(has_lane(*in, link.from) && has_lane(*via, link.to));
    }
  }
}

inline std::vector<const roadquery::Road*> plain_roads(const roadquery::RoadMap& map) {
  std::vector<const roadquery::Road*> roads;
  for (const roadquery::Road& road : map.roads)
    if (road.junction < 0) roads.push_back(&road);
  return roads;
}
inline std::vector<const roadquery::Road*> connecting_roads(const roadquery::RoadMap& map) {
  std::vector<const roadquery::Road*> roads;
  for (const roadquery::Road& road : map.roads)
    if (road.junction >= 0) roads.push_back(&road);
  return roads;
}

}  // namespace orthodrive::network_test

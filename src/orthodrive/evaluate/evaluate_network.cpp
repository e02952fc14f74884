#include "orthodrive/evaluate/evaluate_network.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "orthodrive/geo/vec.hpp"
#include "roadquery/road_surface.hpp"

namespace orthodrive {
namespace {
using roadquery::ContactPoint;
using roadquery::LinkKind;
using roadquery::Road;
using roadquery::RoadMap;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void count_elements(const RoadMap& map, NetworkScores& scores) {
  constexpr const char* kinds[] = {"line", "arc", "spiral", "paramPoly3"};  // order of roadquery::PlanShape
  for (const char* kind : kinds) scores.elements[kind] = 0;
  scores.roads = map.roads.size();
  scores.junctions = map.junctions.size();
  for (const Road& road : map.roads) {
    scores.connecting_roads += road.junction >= 0 ? 1 : 0;
    scores.length_m += road.length;
    for (const roadquery::PlanElement& element : road.plan) ++scores.elements[kinds[element.shape.index()]];
    if (road.junction >= 0) continue;
    scores.road_length_m += road.length;
    scores.road_elements += road.plan.size();
  }
  scores.mean_road_element_m =
      scores.road_elements > 0 ? scores.road_length_m / static_cast<double>(scores.road_elements) : nan;
}

/// Of clothoids exactly, of cubics in 20 steps.
double curvature_rate(const roadquery::PlanElement& element) {
  if (std::holds_alternative<roadquery::Line>(element.shape) || std::holds_alternative<roadquery::Arc>(element.shape))
    return 0.0;
  const int steps = std::holds_alternative<roadquery::Spiral>(element.shape) ? 1 : 20;
  const double step_m = element.length / steps;
  double largest = 0.0;
  for (int i = 0; i < steps; ++i)
    largest = std::max(largest, std::abs(roadquery::evaluate(element, (i + 1) * step_m).curvature -
                                         roadquery::evaluate(element, i * step_m).curvature) /
                                    step_m);
  return largest;
}

double gradient_kink(const Road& road) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < road.elevation.size(); ++i) {
    const roadquery::Cubic &before = road.elevation[i], &after = road.elevation[i + 1];
    const double ds = after.s - before.s;
    largest = std::max(largest, std::abs(after.b - (before.b + ds * (2.0 * before.c + 3.0 * ds * before.d))));
  }
  return largest;
}

// ---- joints
// ----------------------------------------------------------------------------------------------------------

double element_gap_m(const Road& road) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < road.plan.size(); ++i) {
    const roadquery::PlanPoint end = roadquery::evaluate(road.plan[i], road.plan[i].length);
    largest = std::max(largest, std::hypot(end.x - road.plan[i + 1].x, end.y - road.plan[i + 1].y));
  }
  return largest;
}

struct RoadEnd {
  const Road* road = nullptr;
  ContactPoint contact = ContactPoint::start;
  [[nodiscard]] double s() const { return contact == ContactPoint::start ? 0.0 : road->length; }
  [[nodiscard]] const roadquery::LaneSection& section() const {
    return contact == ContactPoint::start ? road->sections.front() : road->sections.back();
  }
};

const roadquery::Lane* find_lane(const roadquery::LaneSection& section, int id) {
  for (const auto* side : {&section.left, &section.right})
    for (const roadquery::Lane& lane : *side)
      if (lane.id == id) return &lane;
  return nullptr;
}

/// Inner border of a lane at the end of its road.
roadquery::SurfacePoint inner_border(const RoadEnd& end, int lane_id) {
  const roadquery::LaneSection& section = end.section();
  double t = roadquery::evaluate(end.road->lane_offset, end.s());
  for (const roadquery::Lane& lane : lane_id > 0 ? section.left : section.right)
    if (std::abs(lane.id) < std::abs(lane_id))
      t += (lane_id > 0 ? 1.0 : -1.0) * roadquery::lane_width(lane, end.s() - section.s);
  return roadquery::surface_point(*end.road, end.s(), t);
}

double distance_m(const roadquery::SurfacePoint& a, const roadquery::SurfacePoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

/// Where lanes are linked the best of them counts: a connecting road's reference line need not meet that of the road,
/// and lanes of different width have one common border at most. A gap of the roads shows in all lanes.
double link_gap_m(const RoadEnd& from, const RoadEnd& to) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto* side : {&from.section().left, &from.section().right})
    for (const roadquery::Lane& lane : *side) {
      const std::optional<int>& linked = from.contact == ContactPoint::start ? lane.predecessor : lane.successor;
      if (linked && find_lane(to.section(), *linked))
        smallest = std::min(smallest, distance_m(inner_border(from, lane.id), inner_border(to, *linked)));
    }
  if (std::isfinite(smallest)) return smallest;
  return distance_m(roadquery::surface_point(*from.road, from.s(), 0.0),
                    roadquery::surface_point(*to.road, to.s(), 0.0));
}

class RoadsById {
 public:
  explicit RoadsById(const RoadMap& map) {
    for (std::size_t i = 0; i < map.roads.size(); ++i) index_.emplace(map.roads[i].id, i);
  }
  [[nodiscard]] std::optional<std::size_t> find(int id) const {
    const auto at = index_.find(id);
    return at == index_.end() ? std::nullopt : std::optional(at->second);
  }

 private:
  std::unordered_map<int, std::size_t> index_;
};

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

void measure_plan(const Road& road, NetworkScores& scores) {
  if (road.junction < 0)
    for (const roadquery::PlanElement& element : road.plan)
      scores.max_curvature_rate = std::max(scores.max_curvature_rate, curvature_rate(element));
  for (std::size_t i = 0; i + 1 < road.plan.size(); ++i) {
    const roadquery::PlanPoint a = roadquery::evaluate(road.plan[i], road.plan[i].length);
    const roadquery::PlanPoint b = roadquery::evaluate(road.plan[i + 1], 0.0);
    scores.max_heading_jump_rad = std::max(scores.max_heading_jump_rad, std::abs(wrapped(a.hdg - b.hdg)));
    if (road.junction < 0)
      scores.max_curvature_jump = std::max(scores.max_curvature_jump, std::abs(a.curvature - b.curvature));
  }
}

/// Heading, gradient and curvature of a car that goes from one road to the other.
void measure_link(const RoadEnd& from, const RoadEnd& to, NetworkScores& scores) {
  const auto pose = [](const RoadEnd& end, bool leaving) {
    const bool along = (end.contact == ContactPoint::end) == leaving;
    const double sign = along ? 1.0 : -1.0;
    const roadquery::PlanPoint p = roadquery::reference_point(*end.road, end.s());
    return std::tuple{p.hdg + (along ? 0.0 : std::numbers::pi), sign * roadquery::gradient(*end.road, end.s()), sign * p.curvature};
  };
  const auto [heading_a, gradient_a, curvature_a] = pose(from, true);
  const auto [heading_b, gradient_b, curvature_b] = pose(to, false);
  scores.max_heading_jump_rad = std::max(scores.max_heading_jump_rad, std::abs(wrapped(heading_a - heading_b)));
  scores.max_gradient_kink = std::max(scores.max_gradient_kink, std::abs(gradient_a - gradient_b));
  if (from.road->junction < 0 && to.road->junction < 0)
    scores.max_curvature_jump = std::max(scores.max_curvature_jump, std::abs(curvature_a - curvature_b));
}

void measure_joints(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  std::set<int> junctions;
  for (const roadquery::Junction& junction : map.junctions) junctions.insert(junction.id);
  for (const Road& road : map.roads) {
    scores.max_gradient_kink = std::max(scores.max_gradient_kink, gradient_kink(road));
    scores.max_joint_gap_m = std::max(scores.max_joint_gap_m, element_gap_m(road));
    measure_plan(road, scores);
    for (const ContactPoint contact : {ContactPoint::start, ContactPoint::end}) {
      const roadquery::RoadLink& link = contact == ContactPoint::start ? road.predecessor : road.successor;
      if (link.kind == LinkKind::junction && junctions.count(link.id) == 0) ++scores.broken_links;
      if (link.kind != LinkKind::road) continue;
      const auto other = by_id.find(link.id);
      if (!other) {
        ++scores.broken_links;
        continue;
      }
      const RoadEnd from{&road, contact}, to{&map.roads[*other], link.contact};
      scores.max_joint_gap_m = std::max(scores.max_joint_gap_m, link_gap_m(from, to));
      measure_link(from, to, scores);
      // The other side answers: with this road, or from a connecting road with its junction.
      const roadquery::RoadLink& back = link.contact == ContactPoint::start ? to.road->predecessor : to.road->successor;
      const bool answered = road.junction >= 0 ? back.kind == LinkKind::junction && back.id == road.junction
                                               : back.kind == LinkKind::road && back.id == road.id && back.contact == contact;
      if (!answered) ++scores.broken_links;
    }
  }
}

// ---- lanes

bool drives_along(const Road& road, int lane) { return (lane < 0) != road.left_hand_traffic; }

/// A lane that has narrowed to nothing has merged with the one beside it and is not dead.
void add_dead_lane(const RoadEnd& end, const roadquery::Lane& lane, NetworkScores& scores) {
  constexpr double merged_m = 0.01;
  if (roadquery::lane_width(lane, end.s() - end.section().s) < merged_m) return;
  const roadquery::SurfacePoint p = inner_border(end, lane.id);
  scores.dead_lane_places.push_back({end.road->id, lane.id, p.x, p.y});
  ++scores.dead_lanes;
}

/// Lanes of a road end against those that they are linked to.
void check_end_lanes(const RoadEnd& from, const RoadEnd* to, bool in_junction, NetworkScores& scores) {
  using roadquery::LaneType;
  for (const auto* side : {&from.section().left, &from.section().right})
    for (const roadquery::Lane& lane : *side) {
      const bool at_end = from.contact == ContactPoint::end;
      const std::optional<int>& linked = at_end ? lane.successor : lane.predecessor;
      if (!linked) {
        const bool leaves = drives_along(*from.road, lane.id) == at_end;
        if (to && leaves && lane.type == LaneType::driving && !in_junction) add_dead_lane(from, lane, scores);
        continue;
      }
      const roadquery::Lane* other = to ? find_lane(to->section(), *linked) : nullptr;
      if (!other || other->type != lane.type) {
        ++scores.lane_link_errors;
        continue;
      }
      const bool same_s = (from.contact == ContactPoint::end) != (to->contact == ContactPoint::end);
      if ((drives_along(*from.road, lane.id) == drives_along(*to->road, *linked)) != same_s) ++scores.lane_link_errors;
      if (in_junction || to->road->junction >= 0) continue;
      const std::optional<int>& back = to->contact == ContactPoint::end ? other->successor : other->predecessor;
      if (back != lane.id) ++scores.lane_link_errors;
    }
}

/// At its start, middle or end: many lanes taper.
double widest_m(const roadquery::Lane& lane, double length) {
  return std::max({roadquery::lane_width(lane, 0.0), roadquery::lane_width(lane, 0.5 * length),
                   roadquery::lane_width(lane, length)});
}

void check_lanes(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  scores.min_lane_width_m = nan;
  for (const Road& road : map.roads) {
    for (const ContactPoint contact : {ContactPoint::start, ContactPoint::end}) {
      const roadquery::RoadLink& link = contact == ContactPoint::start ? road.predecessor : road.successor;
      const auto other = link.kind == LinkKind::road ? by_id.find(link.id) : std::nullopt;
      const RoadEnd from{&road, contact}, to{other ? &map.roads[*other] : nullptr, link.contact};
      check_end_lanes(from, other ? &to : nullptr, road.junction >= 0, scores);
    }
    if (road.junction >= 0) continue;
    for (const roadquery::LaneSection& section : road.sections)
      for (const auto* side : {&section.left, &section.right})
        for (const roadquery::Lane& lane : *side)
          if (lane.type == roadquery::LaneType::driving)
            scores.min_lane_width_m = std::fmin(scores.min_lane_width_m, widest_m(lane, road.length - section.s));
  }
  for (const roadquery::Junction& junction : map.junctions) {
    std::map<int, std::set<int>> fed;  // lanes of the roads that lead in
    for (const roadquery::Connection& connection : junction.connections) {
      const auto incoming = by_id.find(connection.incoming_road), via = by_id.find(connection.connecting_road);
      if (!incoming || !via) {
        ++scores.broken_links;
        continue;
      }
      const RoadEnd connecting{&map.roads[*via], connection.contact};
      for (const roadquery::LaneLink& link : connection.lane_links) {
        const roadquery::Lane* lane = find_lane(connecting.section(), link.to);
        const std::optional<int> expected = !lane ? std::nullopt
                                            : connection.contact == ContactPoint::start ? lane->predecessor : lane->successor;
        if (expected != link.from) ++scores.lane_link_errors;
        fed[connection.incoming_road].insert(link.from);
      }
    }
    for (const auto& [id, lanes] : fed) {
      const Road& road = map.roads[*by_id.find(id)];
      for (const ContactPoint contact : {ContactPoint::start, ContactPoint::end}) {
        const roadquery::RoadLink& link = contact == ContactPoint::start ? road.predecessor : road.successor;
        if (link.kind != LinkKind::junction || link.id != junction.id) continue;
        const RoadEnd end{&road, contact};
        for (const auto* side : {&end.section().left, &end.section().right})
          for (const roadquery::Lane& lane : *side)
            if (lane.type == roadquery::LaneType::driving && drives_along(road, lane.id) == (contact == ContactPoint::end) &&
                lanes.count(lane.id) == 0)
              add_dead_lane(end, lane, scores);
      }
    }
  }
}

// ---- what hangs together
// ---------------------------------------------------------------------------------------------

double connected_share(const RoadMap& map, const RoadsById& by_id) {
  std::vector<std::size_t> parent(map.roads.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto join = [&](std::size_t a, std::optional<std::size_t> b) {
    if (b) parent[root(a)] = root(*b);
  };
  for (std::size_t i = 0; i < map.roads.size(); ++i)
    for (const roadquery::RoadLink* link : {&map.roads[i].predecessor, &map.roads[i].successor})
      if (link->kind == LinkKind::road) join(i, by_id.find(link->id));
  for (const roadquery::Junction& junction : map.junctions)
    for (const roadquery::Connection& connection : junction.connections)
      if (const auto incoming = by_id.find(connection.incoming_road))
        join(*incoming, by_id.find(connection.connecting_road));
  std::vector<double> length_m(map.roads.size());
  double total_m = 0.0;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    length_m[root(i)] += map.roads[i].length;
    total_m += map.roads[i].length;
  }
  return total_m > 0.0 ? *std::max_element(length_m.begin(), length_m.end()) / total_m : nan;
}

// ---- bridges
// ---------------------------------------------------------------------------------------------------------

/// A piece of a reference line.
struct Piece {
  std::size_t road = 0;
  Vec3 a, b;
};

std::vector<Piece> pieces_of(const RoadMap& map) {
  constexpr double step_m = 5.0;  // a clothoid of 15 m radius leaves its chord by 0.2 m: nothing in height
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const Road& road = map.roads[i];
    const auto at = [&](double s) {
      const roadquery::PlanPoint p = roadquery::reference_point(road, s);
      return Vec3{p.x, p.y, roadquery::elevation(road, s)};
    };
    const int n = std::max(1, static_cast<int>(std::ceil(road.length / step_m)));
    for (int k = 0; k < n; ++k) pieces.push_back({i, at(road.length * k / n), at(road.length * (k + 1) / n)});
  }
  return pieces;
}

/// Roads that meet at a joint or in a junction touch there; that is no bridge.
bool meet(const Road& a, const Road& b) {
  const auto leads_to = [](const Road& from, const Road& to) {
    for (const roadquery::RoadLink* link : {&from.predecessor, &from.successor}) {
      if (link->kind == LinkKind::road && link->id == to.id) return true;
      if (link->kind != LinkKind::junction) continue;
      if (to.junction == link->id) return true;
      for (const roadquery::RoadLink* other : {&to.predecessor, &to.successor})
        if (other->kind == LinkKind::junction && other->id == link->id) return true;
    }
    return false;
  };
  return leads_to(a, b) || leads_to(b, a) || (a.junction >= 0 && a.junction == b.junction);
}

struct Layers {
  int low = 0, high = 0;
};
/// A connecting road may lead from one layer to another: it lies on both.
std::vector<Layers> layers_of(const RoadMap& map, const RoadsById& by_id) {
  std::vector<Layers> layers;
  for (const Road& road : map.roads) {
    Layers& own = layers.emplace_back(Layers{road.layer, road.layer});
    if (road.junction < 0) continue;
    for (const roadquery::RoadLink* link : {&road.predecessor, &road.successor})
      if (const auto other = link->kind == LinkKind::road ? by_id.find(link->id) : std::nullopt)
        own = {std::min(own.low, map.roads[*other].layer), std::max(own.high, map.roads[*other].layer)};
  }
  return layers;
}

/// Sweep over x: pieces are short, so few overlap at a time.
void measure_clearance(const RoadMap& map, const RoadsById& by_id, NetworkScores& scores) {
  constexpr double two_levels_m = 1.0;  // of one layer and nearer: a junction that the map lacks, as in evaluate_heights
  scores.min_clearance_m = nan;
  const std::vector<Layers> layers = layers_of(map, by_id);
  std::vector<Piece> pieces = pieces_of(map);
  const auto min_x = [](const Piece& p) { return std::min(p.a.x, p.b.x); };
  const auto max_x = [](const Piece& p) { return std::max(p.a.x, p.b.x); };
  std::sort(pieces.begin(), pieces.end(),
            [&](const Piece& p, const Piece& q) { return std::pair(min_x(p), p.road) < std::pair(min_x(q), q.road); });
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (std::size_t k = i + 1; k < pieces.size() && min_x(pieces[k]) <= max_x(pieces[i]); ++k) {
      const Piece &p = pieces[i], &q = pieces[k];
      const Road &first = map.roads[p.road], &second = map.roads[q.road];
      const Vec2 d{p.b.x - p.a.x, p.b.y - p.a.y}, e{q.b.x - q.a.x, q.b.y - q.a.y},
          between{q.a.x - p.a.x, q.a.y - p.a.y};
      const double denominator = cross(d, e);
      if (denominator == 0.0) continue;
      const double u = cross(between, e) / denominator, v = cross(between, d) / denominator;
      if (u < 0.0 || u >= 1.0 || v < 0.0 || v >= 1.0 || meet(first, second)) continue;
      const double above = p.a.z + u * (p.b.z - p.a.z) - q.a.z - v * (q.b.z - q.a.z);
      const Layers &a = layers[p.road], &b = layers[q.road];
      if (a.low <= b.high && b.low <= a.high && std::abs(above) < two_levels_m) continue;
      const Road &upper = above >= 0.0 ? first : second, &lower = above >= 0.0 ? second : first;
      scores.crossing_places.push_back({upper.id, lower.id, upper.osm_id, lower.osm_id, upper.highway, lower.highway,
                                        upper.layer, lower.layer, upper.bridge, p.a.x + u * d.x, p.a.y + u * d.y,
                                        std::abs(above)});
    }
  std::sort(scores.crossing_places.begin(), scores.crossing_places.end(),
            [](const LevelCrossing& a, const LevelCrossing& b) {
              return std::tuple(a.clearance_m, a.upper_road, a.lower_road) <
                     std::tuple(b.clearance_m, b.upper_road, b.lower_road);
            });
  scores.crossings = scores.crossing_places.size();
  if (scores.crossings > 0) scores.min_clearance_m = scores.crossing_places.front().clearance_m;
}
}  // namespace

NetworkScores evaluate_network(const RoadMap& map) {
  NetworkScores scores;
  const RoadsById by_id(map);
  count_elements(map, scores);
  measure_joints(map, by_id, scores);
  check_lanes(map, by_id, scores);
  measure_clearance(map, by_id, scores);
  scores.connected_share = connected_share(map, by_id);
  return scores;
}

}  // namespace orthodrive

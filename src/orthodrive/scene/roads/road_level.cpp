// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/roads/road_level.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <span>
#include <utility>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/segment.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "roadquery/surface/junction_surface.hpp"
#include "roadquery/surface/road_surface.hpp"

namespace orthodrive::scene {
namespace {

constexpr double min_piece_area_m2 = 1e-5;
// Holes of the union that are smaller or thinner than this are gaps between edges that should have met.
constexpr double min_hole_area_m2 = 1.0, min_hole_width_m = 0.15;
constexpr double end_bulge_m = 2.0 * plan_grid_m;  // survives the plan grid

Vec2 plan_of_point(const Vec3& p) { return {p.x, p.y}; }

/// The convex hull of the four corners between two sections: unlike the quadrilateral, it is simple where the inner
/// edge of a tight bend runs backwards.
Ring piece_ring(const CrossSection& a, const CrossSection& b) {
  return convex_hull({snap_to_grid(plan_of_point(a.left)), snap_to_grid(plan_of_point(a.right)),
                      snap_to_grid(plan_of_point(b.left)), snap_to_grid(plan_of_point(b.right))});
}

/// A point on the reference line just beyond an end: a crown's ridge reaches an open end only if there is a corner.
void bulge(Ring& ring, const roadquery::Road& road, const CrossSection& end, double outwards) {
  const auto at = roadquery::reference_point(road, end.s_m);
  const Vec2 p = Vec2{at.x, at.y} + Vec2{std::cos(at.hdg), std::sin(at.hdg)} * (outwards * end_bulge_m);
  ring.push_back(snap_to_grid(p));
  ring = convex_hull(std::move(ring));
}

/// The corners of a strip's ends are those of its joints.
void move_to_joints(const EndPoints& joints, std::vector<CrossSection>& strip) {
  const auto move = [](std::span<const Vec2> points, CrossSection& section) {
    if (points.empty()) return;
    section.right.x = points.front().x, section.right.y = points.front().y;
    section.left.x = points.back().x, section.left.y = points.back().y;
  };
  if (strip.size() < 2) return;
  move(joints.start, strip.front());
  move(joints.end, strip.back());
}

/// The strip between its sections, piece by piece.
std::vector<Polygon> strip_pieces(const roadquery::Road& road, const std::vector<CrossSection>& strip,
                                  const EndPoints& joints) {
  std::vector<Polygon> pieces;
  for (std::size_t i = 1; i < strip.size(); ++i) {
    Ring ring = piece_ring(strip[i - 1], strip[i]);
    if (i == 1 && joints.start.size() > 1) {  // counter-clockwise: from the left corner to the right one
      const auto inner = joints.start.subspan(1, joints.start.size() - 2);
      insert_between(ring, joints.start.back(), joints.start.front(), {inner.rbegin(), inner.rend()});
    } else if (i == 1 && !road.shape.empty()) {
      bulge(ring, road, strip.front(), -1.0);
    }
    if (i + 1 == strip.size() && joints.end.size() > 1) {
      const auto inner = joints.end.subspan(1, joints.end.size() - 2);
      insert_between(ring, joints.end.front(), joints.end.back(), {inner.begin(), inner.end()});
    } else if (i + 1 == strip.size() && !road.shape.empty()) {
      bulge(ring, road, strip.back(), 1.0);
    }
    if (ring.size() >= 3 && signed_area_m2(ring) > min_piece_area_m2) pieces.push_back({std::move(ring), {}});
  }
  return pieces;
}

/// What the road query takes for road beyond the ends of a strip: 0.25 m.
std::vector<Polygon> end_pieces(const roadquery::Road& road, const std::vector<CrossSection>& strip) {
  constexpr double beyond_m = 0.26;
  std::vector<Polygon> pieces;
  if (strip.size() < 2) return pieces;
  for (const auto& [end, outwards] : {std::pair(&strip.front(), -1.0), std::pair(&strip.back(), 1.0)}) {
    const double hdg = roadquery::reference_point(road, end->s_m).hdg;
    const Vec2 step = Vec2{std::cos(hdg), std::sin(hdg)} * (outwards * beyond_m);
    Ring ring =
        convex_hull({snap_to_grid(plan_of_point(end->left)), snap_to_grid(plan_of_point(end->right)),
                     snap_to_grid(plan_of_point(end->left) + step), snap_to_grid(plan_of_point(end->right) + step)});
    if (ring.size() >= 3 && signed_area_m2(ring) > min_piece_area_m2) pieces.push_back({std::move(ring), {}});
  }
  return pieces;
}

/// What a road of another level covers up to its joint with a junction, at most half of it: no junction lies there.
/// Wider away from the joint: nothing of the junction touches the side of that road.
Ring before_joint(const roadquery::Road& road, bool at_end, std::span<const Vec2> across) {
  constexpr double furthest_m = 3.0, overlap_m = 0.05, spread = 0.1;
  const double reach_m = std::min(furthest_m, 0.5 * road.length + overlap_m);
  const double hdg = roadquery::reference_point(road, at_end ? road.length : 0.0).hdg;
  const Vec2 along{std::cos(hdg), std::sin(hdg)};
  const Vec2 step = along * (at_end ? -reach_m : reach_m), aside = left_normal(along) * (spread * reach_m);
  Ring ring(across.begin(), across.end());  // from the right edge to the left one
  ring.push_back(snap_to_grid(across.back() + step + aside));
  ring.push_back(snap_to_grid(across.front() + step - aside));
  if (!at_end) std::ranges::reverse(ring);
  return ring;
}

/// The union of counter-clockwise pieces that meet in common edges: what is left of all edges once those that run in
/// both directions are taken out. Where that is one simple ring it winds once around every place inside, and so each
/// lies in one piece only. Nothing otherwise: pieces overlap, where an inner edge runs backwards.
std::optional<Polygon> joined_at_edges(std::span<const Polygon> pieces) {
  using Corner = std::pair<double, double>;
  std::map<std::pair<Corner, Corner>, int> edges;
  for (const Polygon& piece : pieces) {
    for (std::size_t i = 0; i < piece.outer.size(); ++i) {
      const Vec2 a = piece.outer[i], b = piece.outer[(i + 1) % piece.outer.size()];
      const Corner from{a.x, a.y}, to{b.x, b.y};
      if (edges.erase({to, from}) == 0 && ++edges[{from, to}] > 1) return std::nullopt;
    }
  }
  std::map<Corner, Corner> next;
  for (const auto& [edge, unused] : edges)
    if (!next.emplace(edge).second) return std::nullopt;
  Polygon joined;
  Corner at = next.begin()->first;
  do {
    joined.outer.push_back({at.first, at.second});
    const auto found = next.find(at);
    if (found == next.end() || joined.outer.size() > next.size()) return std::nullopt;
    at = found->second;
  } while (at != next.begin()->first);
  if (joined.outer.size() != next.size() || !is_simple(joined.outer)) return std::nullopt;
  return joined;
}

bool is_sliver(const Ring& ring) {
  double perimeter_m = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) perimeter_m += distance(ring[i], ring[(i + 1) % ring.size()]);
  const double area = std::abs(signed_area_m2(ring));
  return area < min_hole_area_m2 || area < 0.5 * perimeter_m * min_hole_width_m;
}

std::shared_ptr<const roadquery::RoadQuery> query_of(const std::vector<const roadquery::Road*>& roads) {
  roadquery::RoadMap map;
  for (const roadquery::Road* road : roads) map.roads.push_back(*road);
  return std::make_shared<const roadquery::RoadQuery>(std::move(map));
}

}  // namespace

RoadLevel::RoadLevel(std::vector<const roadquery::Road*> roads, const Polygon& area, const RoadLevelOptions& options)
    : roads_(std::move(roads)), query_(options.query ? options.query : query_of(roads_)), strips_(roads_.size()) {
  is_on_level_.assign(query_->map().roads.size(), options.query == nullptr);
  if (options.query)
    for (const roadquery::Road* road : roads_)
      is_on_level_[static_cast<std::size_t>(road - query_->map().roads.data())] = true;
  std::vector<std::vector<Polygon>> pieces(roads_.size());
  std::vector<MultiPolygon> unions(roads_.size());
  parallel_for(roads_.size(), options.threads, [&](std::size_t i) {
    const std::size_t index = options.query ? static_cast<std::size_t>(roads_[i] - query_->map().roads.data()) : i;
    strips_[i] = cross_sections(*query_, index, options.strip);
    EndPoints joints;
    if (options.joints) joints = options.joints->across(index);
    move_to_joints(joints, strips_[i]);
    pieces[i] = strip_pieces(*roads_[i], strips_[i], joints);
    if (pieces[i].empty()) return;
    if (auto joined = joined_at_edges(pieces[i])) {
      unions[i].push_back(std::move(*joined));
    } else {
      unions[i] = union_of(pieces[i], plan_grid_m);
    }
  });
  MultiPolygon all;
  for (const MultiPolygon& part : unions) all.insert(all.end(), part.begin(), part.end());
  for (auto& part : pieces) std::move(part.begin(), part.end(), std::back_inserter(pieces_));
  for (Polygon& area_of_junction : junction_areas(options.joints)) {
    all.push_back(area_of_junction);
    pieces_.push_back(std::move(area_of_junction));
  }
  paved_pieces_ = pieces_.size();
  for (std::size_t i = 0; i < roads_.size(); ++i)
    std::ranges::move(end_pieces(*roads_[i], strips_[i]), std::back_inserter(pieces_));
  std::vector<Box2> boxes;
  boxes.reserve(pieces_.size());
  for (const Polygon& piece : pieces_) boxes.push_back(bounds_of(piece.outer));
  piece_index_ = SpatialIndex(boxes);
  MultiPolygon joined = all.empty() ? MultiPolygon{} : union_of(all, plan_grid_m);
  for (Polygon& polygon : joined) std::erase_if(polygon.holes, is_sliver);
  polygons_ = joined.empty() ? MultiPolygon{} : intersection_of(joined, {area}, plan_grid_m);
  outline_ = Outline(
      polygons_, options.reach_m,
      [&](Vec2 p) {
        const auto on = sample(p);
        return on ? on->z_m : 0.0;
      },
      options.threads);
}

MultiPolygon RoadLevel::paved_near(const Box2& box, Vec2 from) const {
  MultiPolygon near;
  for (const std::uint32_t i : piece_index_.touching(box))
    if (i < paved_pieces_) near.push_back(moved(pieces_[i], from * -1.0));
  return near;
}

MultiPolygon RoadLevel::driven_near(const Box2& box, Vec2 from) const {
  MultiPolygon near;
  for (const std::uint32_t i : piece_index_.touching(box)) near.push_back(moved(pieces_[i], from * -1.0));
  return near;
}

MultiPolygon RoadLevel::junction_areas(const RoadJoints* joints) {
  MultiPolygon areas;
  std::vector<Box2> boxes;
  const roadquery::RoadMap& map = query_->map();
  std::map<int, MultiPolygon> arms_elsewhere;  // what arms of other levels cover, by junction
  for (std::size_t i = 0; joints != nullptr && i < map.roads.size(); ++i) {
    if (is_on_level_[i]) continue;
    const roadquery::Road& road = map.roads[i];
    MultiPolygon covered;
    for (const bool at_end : {false, true}) {
      const std::span<const Vec2> across = at_end ? joints->across(i).end : joints->across(i).start;
      if (across.size() < 2) continue;
      if (Ring ring = before_joint(road, at_end, across); signed_area_m2(ring) > min_piece_area_m2)
        covered.push_back({std::move(ring), {}});
    }
    for (const roadquery::RoadLink& link : {road.predecessor, road.successor})
      if (link.kind == roadquery::LinkKind::junction)
        std::ranges::copy(covered, std::back_inserter(arms_elsewhere[link.id]));
  }
  for (const roadquery::Junction& junction : map.junctions) {
    const std::optional<roadquery::JunctionSurface>& own = junction.surface;
    if (!own) continue;
    const roadquery::JunctionSurface& surface = *own;
    const auto is_on_level = [&](const roadquery::Road& road) {
      return road.junction == junction.id && is_on_level_[static_cast<std::size_t>(&road - map.roads.data())];
    };
    if (std::ranges::none_of(map.roads, is_on_level)) continue;
    Polygon paved;
    for (const auto& [x, y] : surface.boundary) paved.outer.push_back(snap_to_grid({x, y}));
    if (paved.outer.size() < 3 || !(signed_area_m2(paved.outer) > min_piece_area_m2)) continue;
    junctions_.push_back(&surface);
    boxes.push_back(bounds_of(paved.outer));
    const MultiPolygon& arms = arms_elsewhere[junction.id];
    if (arms.empty())
      areas.push_back(std::move(paved));
    else  // its border lies a little beyond the ends of arms
      std::ranges::move(difference_of({paved}, union_of(arms, plan_grid_m), plan_grid_m), std::back_inserter(areas));
  }
  junction_index_ = SpatialIndex(boxes);
  return areas;
}

std::optional<SurfaceSample> RoadLevel::sample(Vec2 p, double reach_m) const {
  // A corner of the mesh may lie beside all surfaces by a chord. At a junction's boundary the junction goes on, not the
  // roads that lie in it: their own surfaces are others.
  constexpr double chord_m = 0.03;
  auto on = query_->sample(p.x, p.y, 0.0, is_on_level_);
  if (!on && reach_m > 0.0) {
    if (const auto beside = beside_junction(p, std::min(chord_m, reach_m))) return beside;
    on = query_->sample(p.x, p.y, reach_m, is_on_level_);
  }
  if (!on) return reach_m > 0.0 ? beside_junction(p, reach_m) : std::nullopt;
  return SurfaceSample{on->z, {on->normal[0], on->normal[1], on->normal[2]}, on->inside_m};
}

/// A corner of a junction's area lies on its boundary, but for the plan grid, and there may be no road near it: the
/// nearest junction's surface goes on over its boundary.
std::optional<SurfaceSample> RoadLevel::beside_junction(Vec2 p, double reach_m) const {
  const roadquery::JunctionSurface* nearest = nullptr;
  for (const std::uint32_t i : junction_index_.near(p, reach_m)) {
    const auto& boundary = junctions_[i]->boundary;
    for (std::size_t k = 0; k < boundary.size(); ++k) {
      const std::array<double, 2>&a = boundary[k], &b = boundary[(k + 1) % boundary.size()];
      const double away_m = distance_to_segment({a[0], a[1]}, {b[0], b[1]}, p);
      if (away_m < reach_m) nearest = junctions_[i], reach_m = away_m;
    }
  }
  if (nearest == nullptr) return std::nullopt;
  const roadquery::JunctionHeight at = roadquery::evaluate(*nearest, p.x, p.y);
  const double length = std::hypot(at.dz_dx, at.dz_dy, 1.0);
  return SurfaceSample{at.z, {-at.dz_dx / length, -at.dz_dy / length, 1.0 / length}, 0.0};
}

}  // namespace orthodrive::scene

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/buildings/roof.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/create_straight_skeleton_2.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>

#include "orthodrive/geo/narrowest_rectangle.hpp"
#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/scene/plan/plan_grid.hpp"
#include "orthodrive/scene/plan/triangulate.hpp"

namespace orthodrive::scene {
namespace {

constexpr std::size_t max_skeleton_corners = 40, max_corners = 200;
constexpr double join_m = 0.02, least_m2 = 1e-9;
constexpr double right_angle_cosine = 0.21;  // 12 degrees off
constexpr double gabled_fill = 0.85;         // of the narrowest rectangle around
constexpr double mansard_share = 0.25, mansard_rise = 0.7;

using RoofKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Skeleton = CGAL::Straight_skeleton_2<RoofKernel>;

/// Whether rings neither cross nor touch themselves or each other. Overlays give polygons that may touch in points, of
/// which there is no skeleton.
bool is_strictly_simple(const Polygon& footprint) {
  std::vector<std::array<double, 2>> corners;
  const auto add = [&](const Ring& ring) {
    for (const Vec2 p : ring) corners.push_back({p.x, p.y});
    return is_simple(ring);
  };
  if (!add(footprint.outer) || !std::ranges::all_of(footprint.holes, add)) return false;
  std::ranges::sort(corners);
  return std::ranges::adjacent_find(corners) == corners.end();
}

std::size_t corners_of(const Polygon& footprint) {
  std::size_t count = footprint.outer.size();
  for (const Ring& hole : footprint.holes) count += hole.size();
  return count;
}

/// Points of the plan, each once, with its height.
struct Raised {
  std::vector<Vec2> points;
  std::vector<double> heights_m;
  std::vector<std::array<std::uint32_t, 2>> lines;

  std::uint32_t add(Vec2 p, double height_m) {
    const auto [at, is_new] = index_.try_emplace({p.x, p.y}, static_cast<std::uint32_t>(points.size()));
    if (is_new) points.push_back(p), heights_m.push_back(height_m);
    return at->second;
  }

 private:
  std::map<std::array<double, 2>, std::uint32_t> index_;
};

/// The triangles between the lines that lie in the footprint.
std::vector<std::array<Vec3, 3>> slopes_between(const Raised& raised, const Polygon& footprint) {
  const Triangulation t = triangulate(raised.points, raised.lines);
  std::vector<std::array<Vec3, 3>> slopes;
  if (t.points.size() != raised.points.size()) return slopes;  // lines cross: no roof
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (!contains(footprint, t.region_points[t.regions[i]])) continue;
    const auto& [a, b, c] = t.triangles[i];
    if (cross(t.points[b] - t.points[a], t.points[c] - t.points[a]) < least_m2) continue;  // three points of an edge
    std::array<Vec3, 3> slope;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = t.triangles[i][k];
      slope[k] = {t.points[v].x, t.points[v].y, raised.heights_m[v]};
    }
    slopes.push_back(slope);
  }
  return slopes;
}

void add_rings(const Polygon& footprint, Raised& raised) {
  const auto add = [&](const Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i)
      raised.lines.push_back({raised.add(ring[i], 0.0), raised.add(ring[(i + 1) % ring.size()], 0.0)});
  };
  add(footprint.outer);
  for (const Ring& hole : footprint.holes) add(hole);
}

Roof flat_roof(const Polygon& footprint) {
  Raised raised;
  add_rings(footprint, raised);
  return {.slopes = slopes_between(raised, footprint)};
}

double rise_of(const RoofWish& wish, double natural_m) {
  return wish.rise_m > 0.0 ? wish.rise_m : std::min(wish.max_rise_m, natural_m);
}

bool is_rectangle(const Polygon& footprint) {
  const Ring& r = footprint.outer;
  if (r.size() != 4 || !footprint.holes.empty()) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 a = normalized(r[(i + 1) % 4] - r[i]), b = normalized(r[(i + 2) % 4] - r[(i + 1) % 4]);
    if (std::abs(dot(a, b)) > right_angle_cosine) return false;
  }
  return true;
}

/// Four corners whose first and third edges the ridge lies along; a skillion roof is high at the first one.
Ring ridge_frame(const Polygon& footprint, const RoofWish& wish) {
  Ring frame = is_rectangle(footprint) ? footprint.outer : narrowest_rectangle(footprint.outer);
  if (frame.size() != 4) return {};
  const auto edge = [&](std::size_t i) { return frame[(i + 1) % 4] - frame[i % 4]; };
  std::size_t first = length(edge(0)) + length(edge(2)) < length(edge(1)) + length(edge(3)) ? 1 : 0;
  if (wish.ridge_across) first = 1 - first;
  if (wish.downwards) {
    const auto down = [&](std::size_t i) { return dot(left_normal(normalized(edge(i))), *wish.downwards); };
    for (std::size_t i = 0; i < 4; ++i)
      if (down(i) > down(first) + 1e-9) first = i;
  }
  std::ranges::rotate(frame, frame.begin() + static_cast<std::ptrdiff_t>(first));
  return frame;
}

/// A corner of the profile across a roof: share of the width, share of the rise.
struct RoofStation {
  double share, height;
};

std::vector<RoofStation> profile_of(RoofShape shape) {
  switch (shape) {
    case RoofShape::skillion:
      return {{0.0, 1.0}, {1.0, 0.0}};
    case RoofShape::gambrel:
      return {{0.0, 0.0}, {0.2, 0.6}, {0.5, 1.0}, {0.8, 0.6}, {1.0, 0.0}};
    case RoofShape::saltbox:
      return {{0.0, 0.0}, {0.35, 1.0}, {1.0, 0.0}};
    case RoofShape::round: {
      std::vector<RoofStation> arc;
      constexpr int pieces = 6;
      for (int k = 0; k <= pieces; ++k) {
        const double angle = std::numbers::pi * k / pieces;
        arc.push_back({0.5 * (1.0 - std::cos(angle)), k == 0 || k == pieces ? 0.0 : std::sin(angle)});
      }
      return arc;
    }
    default:
      return {{0.0, 0.0}, {0.5, 1.0}, {1.0, 0.0}};
  }
}

/// A roof whose height is a concave function of the share of the way from one side of the frame to the opposite one.
class ProfileRoof {
 public:
  ProfileRoof(const Polygon& footprint, const Ring& frame, std::vector<RoofStation> profile, double rise_m)
      : footprint_(footprint),
        profile_(std::move(profile)),
        rise_m_(rise_m),
        near_(frame[0]),
        far_(frame[2]),
        inwards_near_(left_normal(normalized(frame[1] - frame[0]))),
        inwards_far_(left_normal(normalized(frame[3] - frame[2]))) {}

  [[nodiscard]] Roof build(RoofShape shape) {
    std::vector<std::vector<Vec2>> on_line(profile_.size());
    const auto add_ring = [&](const Ring& ring, Ring& with_breaks) {
      for (std::size_t i = 0; i < ring.size(); ++i)
        add_edge(ring[i], ring[(i + 1) % ring.size()], on_line, with_breaks);
    };
    Polygon with_breaks;
    add_ring(footprint_.outer, with_breaks.outer);
    for (const Ring& hole : footprint_.holes) add_ring(hole, with_breaks.holes.emplace_back());
    for (std::vector<Vec2>& points : on_line) add_break(points);
    roof_.slopes = slopes_between(raised_, with_breaks);
    roof_.shape = shape;
    for (const double height_m : raised_.heights_m) roof_.rise_m = std::max(roof_.rise_m, height_m);
    return std::move(roof_);
  }

 private:
  static constexpr double on_line_m = 0.02;  // corners that are this near to a line lie on it
  static constexpr double least_m = 0.03;    // less is an eave

  /// Signed distance from the line of a share; linear over the plan.
  [[nodiscard]] double beyond(Vec2 p, double share) const {
    return (1.0 - share) * dot(p - near_, inwards_near_) - share * dot(p - far_, inwards_far_);
  }
  [[nodiscard]] double height_m(Vec2 p) const {
    const double before = std::max(0.0, dot(p - near_, inwards_near_)),
                 behind = std::max(0.0, dot(p - far_, inwards_far_));
    const double share = before + behind > 0.0 ? before / (before + behind) : 0.0;
    std::size_t k = 1;
    while (k + 1 < profile_.size() && share > profile_[k].share) ++k;
    const RoofStation &a = profile_[k - 1], &b = profile_[k];
    const double height = a.height + (b.height - a.height) * (share - a.share) / (b.share - a.share);
    return rise_m_ * height < least_m ? 0.0 : rise_m_ * height;
  }

  /// An edge of the footprint with the places where the profile breaks, and the gable over it.
  void add_edge(Vec2 a, Vec2 b, std::vector<std::vector<Vec2>>& on_line, Ring& with_breaks) {
    std::vector<std::pair<double, Vec2>> breaks;
    for (std::size_t k = 1; k + 1 < profile_.size(); ++k) {
      const double at_a = beyond(a, profile_[k].share), at_b = beyond(b, profile_[k].share);
      if (std::abs(at_a) < on_line_m) on_line[k].push_back(a);
      if (std::abs(at_a) < on_line_m || std::abs(at_b) < on_line_m || at_a * at_b > 0.0) continue;
      const double along = at_a / (at_a - at_b);
      const Vec2 p = a + (b - a) * along;  // on the edge, not on the grid: gables stand upright
      if (distance(p, a) < on_line_m || distance(p, b) < on_line_m) {
        on_line[k].push_back(distance(p, a) < distance(p, b) ? a : b);
        continue;
      }
      breaks.emplace_back(along, p);
      on_line[k].push_back(p);
    }
    std::ranges::sort(breaks, {}, &std::pair<double, Vec2>::first);
    std::vector<Vec2> chain = {a};
    for (const auto& [along, p] : breaks) chain.push_back(p);
    with_breaks.insert(with_breaks.end(), chain.begin(), chain.end());
    chain.push_back(b);
    std::vector<Vec3> gable = {{a.x, a.y, 0.0}, {b.x, b.y, 0.0}};
    for (std::size_t i = chain.size(); i-- > 0;) {
      const double z = height_m(chain[i]);
      const std::uint32_t v = raised_.add(chain[i], z);
      if (i + 1 < chain.size()) raised_.lines.push_back({v, raised_.add(chain[i + 1], 0.0)});
      if (z > 0.0) gable.push_back({chain[i].x, chain[i].y, z});
    }
    for (std::size_t k = 2; k < gable.size(); ++k) roof_.gables.push_back({gable[0], gable[k - 1], gable[k]});
  }

  /// The lines across the footprint where the profile breaks.
  void add_break(std::vector<Vec2>& points) {
    const Vec2 along = left_normal(inwards_near_);
    std::ranges::sort(points, {}, [&](Vec2 p) { return dot(p, along); });
    for (std::size_t i = 1; i < points.size(); ++i) {
      const Vec2 a = points[i - 1], b = points[i];
      if (distance(a, b) < on_line_m || !contains(footprint_, (a + b) * 0.5)) continue;
      const std::array<std::uint32_t, 2> line = {raised_.add(a, height_m(a)), raised_.add(b, height_m(b))};
      const auto is_same = [&](const auto& other) { return other == line || other == std::array{line[1], line[0]}; };
      if (std::ranges::none_of(raised_.lines, is_same)) raised_.lines.push_back(line);
      if (distance(a, b) > distance({roof_.ridge[0].x, roof_.ridge[0].y}, {roof_.ridge[1].x, roof_.ridge[1].y}) &&
          height_m(a) > 0.99 * rise_m_)
        roof_.ridge = {Vec3{a.x, a.y, height_m(a)}, Vec3{b.x, b.y, height_m(b)}};
    }
  }

  const Polygon& footprint_;
  std::vector<RoofStation> profile_;
  double rise_m_;
  Vec2 near_, far_, inwards_near_, inwards_far_;
  Raised raised_;
  Roof roof_;
};

double width_of(const Ring& frame) { return 0.5 * (distance(frame[1], frame[2]) + distance(frame[3], frame[0])); }

Roof profiled_roof(const Polygon& footprint, const Ring& frame, const RoofWish& wish) {
  const double run = wish.shape == RoofShape::skillion ? 0.25 : wish.shape == RoofShape::saltbox ? 0.35 : 0.5;
  return ProfileRoof(footprint, frame, profile_of(wish.shape), rise_of(wish, run * width_of(frame) * wish.pitch))
      .build(wish.shape);
}

/// Over a rectangle: gables up to half of the rise, small hips above.
Roof half_hipped_roof(const Ring& frame, const RoofWish& wish) {
  const double half_m = 0.5 * width_of(frame), rise_m = rise_of(wish, half_m * wish.pitch);
  const Vec2 a = frame[0], b = frame[1], c = frame[2], d = frame[3];
  const auto between = [](Vec2 p, Vec2 q, double share) { return p + (q - p) * share; };
  const auto raised = [](Vec2 p, double z) { return Vec3{p.x, p.y, z}; };
  const double hip_m = std::min(0.5 * half_m, 0.3 * distance(a, b));
  const Vec2 bc = between(b, c, 0.5), da = between(d, a, 0.5);
  const Vec3 left = raised(between(da, bc, hip_m / distance(da, bc)), rise_m),
             right = raised(between(bc, da, hip_m / distance(da, bc)), rise_m);
  const Vec3 a0 = raised(a, 0), b0 = raised(b, 0), c0 = raised(c, 0), d0 = raised(d, 0);
  const Vec3 ab = raised(between(d, a, 0.75), 0.5 * rise_m), ba = raised(between(b, c, 0.25), 0.5 * rise_m),
             cb = raised(between(b, c, 0.75), 0.5 * rise_m), dc = raised(between(d, a, 0.25), 0.5 * rise_m);
  Roof roof{.shape = RoofShape::half_hipped, .rise_m = rise_m, .ridge = {left, right}};
  roof.slopes = {{a0, b0, ba},   {a0, ba, right},   {a0, right, left}, {a0, left, ab},  {c0, d0, dc},
                 {c0, dc, left}, {c0, left, right}, {c0, right, cb},   {ba, cb, right}, {dc, ab, left}};
  roof.gables = {{b0, c0, cb}, {b0, cb, ba}, {d0, a0, ab}, {d0, ab, dc}};
  return roof;
}

Vec2 centroid_of(const Ring& ring) {
  Vec2 sum;
  double twice = 0.0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
    sum = sum + (a + b) * cross(a, b);
    twice += cross(a, b);
  }
  return snap_to_grid(ring[0] + sum * (1.0 / (3.0 * twice)));
}

bool sees_every_edge(Vec2 p, const Ring& ring) {
  constexpr double least_m2 = 0.02;
  for (std::size_t i = 0; i < ring.size(); ++i)
    if (cross(ring[i] - p, ring[(i + 1) % ring.size()] - p) < least_m2) return false;
  return true;
}

/// Rings of the footprint's shape one over the other, and the tip. Stations: share of the way in, share of the rise.
Roof roof_around(const Ring& ring, Vec2 middle, std::span<const RoofStation> rings, double rise_m) {
  Roof roof{.rise_m = rise_m};
  const auto at = [&](std::size_t level, std::size_t i) {
    const Vec2 p = ring[i % ring.size()];
    if (level == 0) return Vec3{p.x, p.y, 0.0};
    const Vec2 q = snap_to_grid(middle + (p - middle) * (1.0 - rings[level - 1].share));
    return Vec3{q.x, q.y, rise_m * rings[level - 1].height};
  };
  const Vec3 tip{middle.x, middle.y, rise_m};
  for (std::size_t i = 0; i < ring.size(); ++i) {
    for (std::size_t level = 0; level < rings.size(); ++level) {
      roof.slopes.push_back({at(level, i), at(level, i + 1), at(level + 1, i + 1)});
      roof.slopes.push_back({at(level, i), at(level + 1, i + 1), at(level + 1, i)});
    }
    roof.slopes.push_back({at(rings.size(), i), at(rings.size(), i + 1), tip});
  }
  roof.ridge = {tip, tip};
  return roof;
}

std::optional<Roof> centered_roof(const Polygon& footprint, const RoofWish& wish) {
  if (!footprint.holes.empty()) return std::nullopt;
  const Vec2 middle = centroid_of(footprint.outer);
  if (!sees_every_edge(middle, footprint.outer)) return std::nullopt;
  const double radius_m = std::sqrt(area_m2(footprint) / std::numbers::pi);
  std::vector<RoofStation> rings;
  double natural_m = radius_m * wish.pitch;
  if (wish.shape == RoofShape::dome) {
    for (const double angle : {0.125, 0.25, 0.375})
      rings.push_back({1.0 - std::cos(std::numbers::pi * angle), std::sin(std::numbers::pi * angle)});
    natural_m = radius_m;
  } else if (wish.shape == RoofShape::onion) {
    rings = {{-0.12, 0.12}, {-0.08, 0.26}, {0.25, 0.45}, {0.65, 0.62}, {0.88, 0.8}};
    natural_m = 2.0 * radius_m;
  }
  Roof roof = roof_around(footprint.outer, middle, rings, rise_of(wish, natural_m));
  roof.shape = wish.shape;
  return roof;
}

/// Of each node the one that stands for it: nodes at both ends of a very short line become one, because triangles
/// between them would be slivers.
std::map<int, int> joined_nodes(const Skeleton& skeleton) {
  std::map<int, int> joined;
  for (auto v = skeleton.vertices_begin(); v != skeleton.vertices_end(); ++v) joined[v->id()] = v->id();
  for (auto h = skeleton.halfedges_begin(); h != skeleton.halfedges_end(); ++h) {
    const auto from = h->opposite()->vertex(), to = h->vertex();
    if (from->is_contour() || to->is_contour()) continue;
    const double length_m = std::hypot(from->point().x() - to->point().x(), from->point().y() - to->point().y());
    const int a = joined[from->id()], b = joined[to->id()];
    if (length_m >= join_m || a == b) continue;
    for (auto& [node, stands] : joined)
      if (stands == std::max(a, b)) stands = std::min(a, b);
  }
  return joined;
}

/// The line through an edge of the footprint: dot(inwards, p) - beyond is the distance from it.
struct EdgeLine {
  Vec2 inwards;
  double beyond_m = 0.0;
  friend auto operator<=>(const EdgeLine& a, const EdgeLine& b) {
    return std::tie(a.inwards.x, a.inwards.y, a.beyond_m) <=> std::tie(b.inwards.x, b.inwards.y, b.beyond_m);
  }
};

/// A node of the skeleton: what lies as far from all these edges.
struct SkeletonNode {
  Vec2 p;
  double distance_m = 0.0;
  std::set<EdgeLine> edges{};
};

/// Where several events come at one time, the last digits of the node that they make depend in CGAL on where its memory
/// lies. The same node by least squares over all of its edges, sorted, does not. What edges in nearly one line leave
/// open stays as it is.
void settle(SkeletonNode& node) {
  constexpr double most_m = 0.005;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const EdgeLine& edge : node.edges) {
    const Eigen::Vector3d row(edge.inwards.x, edge.inwards.y, -1.0);
    normal += row * row.transpose();
    right += edge.beyond_m * row;
  }
  const Eigen::Vector3d found = normal.ldlt().solve(right);
  const Vec2 p{found.x(), found.y()};
  if (!(distance(p, node.p) < most_m) || !(std::abs(found.z() - node.distance_m) < most_m)) return;
  node.p = p, node.distance_m = found.z();
}

Roof hipped_roof(const Polygon& footprint, const RoofWish& wish) {
  const auto cgal_ring = [](const Ring& ring) {
    std::vector<RoofKernel::Point_2> points;
    points.reserve(ring.size());
    for (const Vec2 p : ring) points.emplace_back(p.x, p.y);
    return points;
  };
  std::vector<std::vector<RoofKernel::Point_2>> holes;
  holes.reserve(footprint.holes.size());
  for (const Ring& hole : footprint.holes) holes.push_back(cgal_ring(hole));
  const auto outer = cgal_ring(footprint.outer);
  const auto skeleton =
      CGAL::create_interior_straight_skeleton_2(outer.begin(), outer.end(), holes.begin(), holes.end(), RoofKernel());
  if (!skeleton) return flat_roof(footprint);
  const std::map<int, int> joined = joined_nodes(*skeleton);
  std::map<int, SkeletonNode> nodes;
  for (auto v = skeleton->vertices_begin(); v != skeleton->vertices_end(); ++v)
    if (joined.at(v->id()) == v->id())
      nodes[v->id()] = {.p = {v->point().x(), v->point().y()}, .distance_m = v->time()};
  const auto vec = [](const auto& vertex) { return Vec2{vertex->point().x(), vertex->point().y()}; };
  for (auto h = skeleton->halfedges_begin(); h != skeleton->halfedges_end(); ++h) {
    if (h->is_border() || h->vertex()->is_contour()) continue;
    const auto edge = h->defining_contour_edge();
    const Vec2 a = vec(edge->opposite()->vertex()), inwards = left_normal(normalized(vec(edge->vertex()) - a));
    nodes.at(joined.at(h->vertex()->id())).edges.insert({inwards, dot(inwards, a)});
  }
  double highest_m = 0.0;
  for (auto& [id, node] : nodes) {
    if (!node.edges.empty()) settle(node);
    highest_m = std::max(highest_m, node.distance_m);
  }
  if (!(highest_m > 0.0)) return flat_roof(footprint);
  const double pitch = rise_of(wish, highest_m * wish.pitch) / highest_m;
  std::vector<std::pair<std::array<double, 3>, int>> in_order;  // ids are given by chance, too
  in_order.reserve(nodes.size());
  for (const auto& [id, node] : nodes) in_order.push_back({{node.p.x, node.p.y, node.distance_m}, id});
  std::ranges::sort(in_order);
  std::map<int, std::uint32_t> points;
  Raised raised;
  for (const auto& [at, id] : in_order) points[id] = raised.add(snap_to_grid({at[0], at[1]}), at[2] * pitch);
  for (auto h = skeleton->halfedges_begin(); h != skeleton->halfedges_end(); ++h) {
    if (h->id() > h->opposite()->id()) continue;
    const std::uint32_t from = points.at(joined.at(h->opposite()->vertex()->id()));
    const std::uint32_t to = points.at(joined.at(h->vertex()->id()));
    if (from != to) raised.lines.push_back({std::min(from, to), std::max(from, to)});
  }
  std::ranges::sort(raised.lines);
  Roof roof{.shape = RoofShape::hipped, .slopes = slopes_between(raised, footprint)};
  const auto highest = std::ranges::max_element(raised.heights_m);
  const Vec2 top = raised.points[static_cast<std::size_t>(highest - raised.heights_m.begin())];
  roof.rise_m = *highest;
  roof.ridge.fill({top.x, top.y, *highest});
  return roof.slopes.empty() ? flat_roof(footprint) : roof;
}

/// Every corner moved in by the distance from both of its edges; nothing where edges would turn round.
std::optional<Polygon> inset(const Polygon& footprint, double by_m) {
  if (!footprint.holes.empty()) return std::nullopt;
  const Ring& ring = footprint.outer;
  const std::size_t count = ring.size();
  Polygon inner;
  for (std::size_t i = 0; i < count; ++i) {
    const auto inwards = [&](std::size_t k) {
      return left_normal(normalized(ring[(k + 1) % count] - ring[k % count]));
    };
    inner.outer.push_back(snap_to_grid(ring[i] + mitre(inwards(i + count - 1), inwards(i)) * by_m));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2 before = ring[(i + 1) % count] - ring[i], after = inner.outer[(i + 1) % count] - inner.outer[i];
    if (dot(before, after) <= 0.05 * dot(before, before)) return std::nullopt;
  }
  if (!is_simple(inner.outer) || signed_area_m2(inner.outer) < 0.05 * signed_area_m2(ring)) return std::nullopt;
  return inner;
}

/// A steep slope around, a hipped roof on what it leaves.
Roof mansard_roof(const Polygon& footprint, const RoofWish& wish) {
  const double width_m = width_of(narrowest_rectangle(footprint.outer));
  const double shorter_m = std::min(width_m, area_m2(footprint) / std::max(width_m, 1.0));
  const double rise_m = rise_of(wish, 0.5 * shorter_m * wish.pitch);
  const std::optional<Polygon> inner = inset(footprint, 0.5 * mansard_share * shorter_m);
  if (!inner) return hipped_roof(footprint, wish);
  RoofWish above = wish;
  above.rise_m = (1.0 - mansard_rise) * rise_m;
  Roof roof = hipped_roof(*inner, above);
  const double low_m = mansard_rise * rise_m;
  for (auto& slope : roof.slopes)
    for (Vec3& p : slope) p.z += low_m;
  for (Vec3& p : roof.ridge) p.z += low_m;
  for (std::size_t i = 0; i < inner->outer.size(); ++i) {
    const std::size_t k = (i + 1) % inner->outer.size();
    const auto at = [](Vec2 p, double z) { return Vec3{p.x, p.y, z}; };
    const Vec3 a = at(footprint.outer[i], 0.0), b = at(footprint.outer[k], 0.0), c = at(inner->outer[k], low_m),
               d = at(inner->outer[i], low_m);
    roof.slopes.push_back({a, b, c});
    roof.slopes.push_back({a, c, d});
  }
  roof.shape = RoofShape::mansard;
  roof.rise_m += low_m;
  return roof;
}

}  // namespace

std::optional<RoofShape> roof_shape_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, RoofShape>, 20> names = {{
      {"flat", RoofShape::flat},          {"skillion", RoofShape::skillion},
      {"gabled", RoofShape::gabled},      {"half-hipped", RoofShape::half_hipped},
      {"hipped", RoofShape::hipped},      {"pyramidal", RoofShape::pyramidal},
      {"gambrel", RoofShape::gambrel},    {"mansard", RoofShape::mansard},
      {"saltbox", RoofShape::saltbox},    {"round", RoofShape::round},
      {"dome", RoofShape::dome},          {"onion", RoofShape::onion},
      {"cone", RoofShape::pyramidal},     {"conical", RoofShape::pyramidal},
      {"lean_to", RoofShape::skillion},   {"half_hipped", RoofShape::half_hipped},
      {"side_hipped", RoofShape::hipped}, {"double_saltbox", RoofShape::gabled},
      {"barrel", RoofShape::round},       {"gabled_row", RoofShape::gabled},
  }};
  const auto found = std::ranges::find(names, name, &std::pair<std::string_view, RoofShape>::first);
  return found == names.end() ? std::nullopt : std::optional(found->second);
}

Roof make_roof(const Polygon& footprint, const RoofWish& wish) {
  const std::size_t corners = corners_of(footprint);
  if (wish.shape == RoofShape::flat || corners > max_corners || !is_strictly_simple(footprint))
    return flat_roof(footprint);
  const bool is_rect = is_rectangle(footprint);
  switch (wish.shape) {
    case RoofShape::pyramidal:
    case RoofShape::dome:
    case RoofShape::onion:
      if (auto roof = centered_roof(footprint, wish)) return std::move(*roof);
      break;
    case RoofShape::half_hipped:
      if (is_rect) return half_hipped_roof(ridge_frame(footprint, wish), wish);
      break;
    case RoofShape::skillion:
    case RoofShape::gabled:
    case RoofShape::gambrel:
    case RoofShape::saltbox:
    case RoofShape::round: {
      const Ring frame = ridge_frame(footprint, wish);
      if (frame.size() != 4) break;
      const bool fills = is_rect || area_m2(footprint) > gabled_fill * signed_area_m2(frame);
      if (!fills && wish.shape != RoofShape::skillion) break;
      Roof roof = profiled_roof(footprint, frame, wish);
      return roof.slopes.empty() ? flat_roof(footprint) : roof;
    }
    default:
      break;
  }
  if (corners > max_skeleton_corners) return flat_roof(footprint);
  return wish.shape == RoofShape::mansard ? mansard_roof(footprint, wish) : hipped_roof(footprint, wish);
}

}  // namespace orthodrive::scene

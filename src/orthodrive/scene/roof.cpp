#include "orthodrive/scene/roof.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/create_straight_skeleton_2.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "orthodrive/geo/overlay.hpp"
#include "orthodrive/scene/plan_grid.hpp"
#include "orthodrive/scene/triangulate.hpp"

namespace orthodrive::scene {
namespace {

constexpr std::size_t max_corners = 40;
constexpr double join_m = 0.02;
constexpr double right_angle_cosine = 0.21;  // 12 degrees off

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Skeleton = CGAL::Straight_skeleton_2<Kernel>;

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
  return {RoofShape::flat, 0.0, slopes_between(raised, footprint), {}};
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

Roof gabled_roof(const Polygon& footprint, double pitch, double max_rise_m) {
  Ring r = footprint.outer;
  if (distance(r[0], r[1]) + distance(r[2], r[3]) < distance(r[1], r[2]) + distance(r[3], r[0]))
    std::rotate(r.begin(), r.begin() + 1, r.end());  // the first edge is a longer one
  const double half_m = 0.25 * (distance(r[1], r[2]) + distance(r[3], r[0]));
  const double rise_m = std::min(max_rise_m, half_m * pitch);
  const auto eave = [](Vec2 p) { return Vec3{p.x, p.y, 0.0}; };
  const auto ridge = [&](Vec2 a, Vec2 b) { return Vec3{0.5 * (a.x + b.x), 0.5 * (a.y + b.y), rise_m}; };
  const Vec3 a = eave(r[0]), b = eave(r[1]), c = eave(r[2]), d = eave(r[3]);
  const Vec3 bc = ridge(r[1], r[2]), da = ridge(r[3], r[0]);
  return {RoofShape::gabled, rise_m, {{a, b, bc}, {a, bc, da}, {c, d, da}, {c, da, bc}}, {{b, c, bc}, {d, a, da}}};
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

Roof hipped_roof(const Polygon& footprint, double pitch, double max_rise_m) {
  const auto cgal_ring = [](const Ring& ring) {
    std::vector<Kernel::Point_2> points;
    for (const Vec2 p : ring) points.emplace_back(p.x, p.y);
    return points;
  };
  std::vector<std::vector<Kernel::Point_2>> holes;
  for (const Ring& hole : footprint.holes) holes.push_back(cgal_ring(hole));
  const auto outer = cgal_ring(footprint.outer);
  const auto skeleton =
      CGAL::create_interior_straight_skeleton_2(outer.begin(), outer.end(), holes.begin(), holes.end(), Kernel());
  if (!skeleton) return flat_roof(footprint);
  double rise_m = 0.0;
  for (auto v = skeleton->vertices_begin(); v != skeleton->vertices_end(); ++v)
    rise_m = std::max(rise_m, v->time() * pitch);
  const double factor = rise_m > max_rise_m ? max_rise_m / rise_m : 1.0;
  const std::map<int, int> joined = joined_nodes(*skeleton);
  std::map<int, std::uint32_t> points;
  Raised raised;
  for (auto v = skeleton->vertices_begin(); v != skeleton->vertices_end(); ++v)
    if (joined.at(v->id()) == v->id())
      points[v->id()] = raised.add(snap_to_grid({v->point().x(), v->point().y()}), v->time() * pitch * factor);
  for (auto h = skeleton->halfedges_begin(); h != skeleton->halfedges_end(); ++h) {
    if (h->id() > h->opposite()->id()) continue;
    const std::uint32_t from = points.at(joined.at(h->opposite()->vertex()->id()));
    const std::uint32_t to = points.at(joined.at(h->vertex()->id()));
    if (from != to) raised.lines.push_back({from, to});
  }
  Roof roof{RoofShape::hipped, *std::ranges::max_element(raised.heights_m), slopes_between(raised, footprint), {}};
  return roof.slopes.empty() ? flat_roof(footprint) : roof;
}

}  // namespace

Roof make_roof(const Polygon& footprint, RoofShape wanted, double pitch, double max_rise_m) {
  if (wanted == RoofShape::flat || corners_of(footprint) > max_corners) return flat_roof(footprint);
  if (wanted == RoofShape::gabled && is_rectangle(footprint)) return gabled_roof(footprint, pitch, max_rise_m);
  return is_strictly_simple(footprint) ? hipped_roof(footprint, pitch, max_rise_m) : flat_roof(footprint);
}

}  // namespace orthodrive::scene

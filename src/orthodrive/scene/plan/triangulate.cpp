// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plan/triangulate.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "orthodrive/scene/plan/plan_grid.hpp"

namespace orthodrive::scene {
namespace {

constexpr std::uint32_t unset = std::numeric_limits<std::uint32_t>::max();
struct Index {
  std::uint32_t value = unset;
};
struct FaceInfo {
  std::uint32_t region = unset;
  bool is_listed = false;  // to be tested
};
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<FaceInfo, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Cdt =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::Exact_predicates_tag>;

Vec2 vec(const Cdt::Point& p) { return {p.x(), p.y()}; }

double area2(Vec2 a, Vec2 b, Vec2 c) { return cross(b - a, c - a); }

/// Spreads the region of `start` over all faces that no constraint separates from it.
void fill_region(const Cdt& cdt, Cdt::Face_handle start, std::uint32_t region) {
  std::vector<Cdt::Face_handle> open = {start};
  start->info().region = region;
  while (!open.empty()) {
    const Cdt::Face_handle face = open.back();
    open.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Cdt::Face_handle next = face->neighbor(i);
      if (face->is_constrained(i) || cdt.is_infinite(next) || next->info().region != unset) continue;
      next->info().region = region;
      open.push_back(next);
    }
  }
}

struct SortedFace {
  std::array<std::uint32_t, 3> corners;
  Cdt::Face_handle face;
};

std::vector<SortedFace> sorted_faces(const Cdt& cdt) {
  std::vector<SortedFace> faces;
  for (const auto f : cdt.finite_face_handles()) {
    std::array<std::uint32_t, 3> t = {f->vertex(0)->info().value, f->vertex(1)->info().value,
                                      f->vertex(2)->info().value};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    faces.push_back({t, f});
  }
  std::ranges::sort(faces, {}, &SortedFace::corners);
  return faces;
}

/// Numbers the regions and returns a point of each.
std::vector<Vec2> find_regions(const Cdt& cdt) {
  std::vector<Vec2> points;
  std::vector<double> largest;
  for (const auto& [unused, face] : sorted_faces(cdt)) {
    if (face->info().region == unset) {
      fill_region(cdt, face, static_cast<std::uint32_t>(points.size()));
      largest.push_back(-1.0);
      points.emplace_back();
    }
    const std::uint32_t region = face->info().region;
    const Vec2 a = vec(face->vertex(0)->point()), b = vec(face->vertex(1)->point()), c = vec(face->vertex(2)->point());
    if (const double area = area2(a, b, c); area > largest[region]) {
      largest[region] = area;
      points[region] = (a + b + c) * (1.0 / 3.0);
    }
  }
  return points;
}

/// Adds points to regions until their triangles keep to the surface. Points of a pass are chosen from the triangulation
/// before it and added in an order of their own: the result depends on neither that of faces nor that of points.
class Refinement {
 public:
  Refinement(Cdt& cdt, const SurfaceToKeep& surface, const std::vector<Vec2>& region_points)
      : cdt_(cdt), surface_(surface) {
    for (const Vec2 p : region_points) is_kept_.push_back(surface.is_kept(p));
    for (const auto v : cdt.finite_vertex_handles()) {
      vertices_.resize(std::max<std::size_t>(vertices_.size(), v->info().value + 1));
      vertices_[v->info().value] = v;
    }
    heights_m_.resize(vertices_.size());
    is_known_.resize(vertices_.size(), false);
  }

  void run() {
    std::vector<Face> faces;
    for (const auto f : cdt_.finite_face_handles())
      if (is_kept(f)) faces.push_back(f);
    for (int pass = 0; pass < most_passes && !faces.empty(); ++pass) {
      std::vector<Candidate> candidates;
      for (const Face f : faces) {
        f->info().is_listed = false;
        if (const auto candidate = worst_of(f)) candidates.push_back(*candidate);
      }
      std::ranges::sort(candidates, {}, [](const Candidate& c) { return std::tuple(c.at.x, c.at.y, c.corners); });
      faces.clear();
      for (const Candidate& candidate : candidates) add(candidate, faces);
    }
  }

 private:
  using Face = Cdt::Face_handle;
  using Vertex = Cdt::Vertex_handle;
  static constexpr int most_passes = 24;
  static constexpr double shortest_m = 0.04;  // of edges that are split

  /// The middle of an edge (the third corner is unset) or of a triangle.
  struct Candidate {
    Vec2 at;
    std::array<std::uint32_t, 3> corners;
  };

  [[nodiscard]] bool is_kept(Face f) const { return is_kept_[f->info().region]; }

  [[nodiscard]] std::optional<double> vertex_height_m(Vertex v) {
    const std::uint32_t i = v->info().value;
    if (!is_known_[i]) heights_m_[i] = surface_.height_m(vec(v->point())), is_known_[i] = true;
    return heights_m_[i];
  }

  /// How far the plane is off at p, which has the mean height of its vertices.
  [[nodiscard]] double error_m(Vec2 p, std::span<const Vertex> around) {
    const auto z = surface_.height_m(p);
    if (!z) return 0.0;
    double mean = 0.0;
    for (const Vertex v : around) {
      const auto at = vertex_height_m(v);
      if (!at) return 0.0;
      mean += *at / static_cast<double>(around.size());
    }
    return std::abs(*z - mean);
  }

  /// Of a face: the middle of the edge that is furthest off, or else that of the face.
  [[nodiscard]] std::optional<Candidate> worst_of(Face f) {
    std::array<Vertex, 3> around = {f->vertex(0), f->vertex(1), f->vertex(2)};
    // Sums and what is first of equals depend on places alone.
    std::ranges::sort(around, {}, [](Vertex v) { return std::pair(v->point().x(), v->point().y()); });
    std::optional<Candidate> worst;
    double most_m = surface_.tolerance_m, longest_m = 0.0;
    for (const auto& [i, k] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      const std::array edge = {around[static_cast<std::size_t>(i)], around[static_cast<std::size_t>(k)]};
      const Vec2 a = vec(edge[0]->point()), b = vec(edge[1]->point());
      longest_m = std::max(longest_m, distance(a, b));
      if (distance(a, b) < shortest_m || !surface_.may_split(a, b)) continue;
      const Vec2 middle = snap_to_grid((a + b) * 0.5);
      const double off_m = error_m(middle, edge);
      if (off_m > most_m) most_m = off_m, worst = {middle, {edge[0]->info().value, edge[1]->info().value, unset}};
    }
    if (worst || longest_m < 2.0 * shortest_m) return worst;
    const Vec2 middle =
        snap_to_grid((vec(around[0]->point()) + vec(around[1]->point()) + vec(around[2]->point())) * (1.0 / 3.0));
    if (error_m(middle, around) > most_m)
      worst = {middle, {around[0]->info().value, around[1]->info().value, around[2]->info().value}};
    return worst;
  }

  /// Unless a point before it has taken the edge or triangle apart.
  void add(const Candidate& candidate, std::vector<Face>& changed) {
    const auto& [p, corners] = candidate;
    const Vertex a = vertices_[corners[0]], b = vertices_[corners[1]];
    Face f;
    int i = 0;
    if (corners[2] == unset) {
      if (!cdt_.is_edge(a, b, f, i)) return;
      const Face g = f->neighbor(i);
      if (cdt_.is_infinite(f) || cdt_.is_infinite(g)) return;
      const Vertex c = f->vertex(i), d = g->vertex(g->index(f)), left = f->vertex(Cdt::cw(i)),
                   right = f->vertex(Cdt::ccw(i));
      // p lies beside the edge by what the plan grid takes.
      for (const auto& [from, to] : {std::pair{c, right}, {right, d}, {d, left}, {left, c}})
        if (!is_left_of(from, to, p)) return;
      const std::uint32_t own = f->info().region, other = g->info().region;
      finish(cdt_.insert({p.x, p.y}, Cdt::EDGE, f, i), left, right, own, other, changed);
      return;
    }
    if (!cdt_.is_face(a, b, vertices_[corners[2]], f)) return;
    for (int k = 0; k < 3; ++k)
      if (!is_left_of(f->vertex(Cdt::ccw(k)), f->vertex(Cdt::cw(k)), p)) return;
    const std::uint32_t own = f->info().region;
    finish(cdt_.insert({p.x, p.y}, Cdt::FACE, f, 0), {}, {}, own, own, changed);
  }

  [[nodiscard]] static bool is_left_of(Vertex from, Vertex to, Vec2 p) {
    return CGAL::orientation(from->point(), to->point(), Cdt::Point(p.x, p.y)) == CGAL::LEFT_TURN;
  }

  /// Names the new point and the faces around it, which no constraint but that of its edge parts: from `start` on,
  /// counter-clockwise, `own`, from `end` on the other region.
  void finish(Vertex v, Vertex start, Vertex end, std::uint32_t own, std::uint32_t other, std::vector<Face>& changed) {
    v->info().value = static_cast<std::uint32_t>(vertices_.size());
    vertices_.push_back(v);
    heights_m_.emplace_back();
    is_known_.push_back(false);
    Cdt::Face_circulator f = cdt_.incident_faces(v);
    if (own != other)
      while (f->vertex(Cdt::ccw(f->index(v))) != start) ++f;
    const Cdt::Face_circulator first = f;
    std::uint32_t region = own;
    do {
      if (own != other && f->vertex(Cdt::ccw(f->index(v))) == end) region = other;
      f->info().region = region;
      if (is_kept(f)) {
        if (!f->info().is_listed) changed.push_back(f);
        f->info().is_listed = true;
      }
    } while (++f != first);
  }

  Cdt& cdt_;
  const SurfaceToKeep& surface_;
  std::vector<bool> is_kept_;  // by region
  std::vector<Vertex> vertices_;
  std::vector<std::optional<double>> heights_m_;
  std::vector<bool> is_known_;
};

}  // namespace

Triangulation triangulate(std::span<const Vec2> points, std::span<const std::array<std::uint32_t, 2>> constraints,
                          const SurfaceToKeep& surface) {
  std::vector<std::pair<Cdt::Point, Index>> input;
  input.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    input.push_back({Cdt::Point(points[i].x, points[i].y), Index{static_cast<std::uint32_t>(i)}});
  Cdt cdt;
  cdt.insert(input.begin(), input.end());
  std::vector<Cdt::Vertex_handle> vertices(points.size());
  for (const auto v : cdt.finite_vertex_handles()) vertices[v->info().value] = v;
  for (const auto& [a, b] : constraints) cdt.insert_constraint(vertices[a], vertices[b]);

  auto count = static_cast<std::uint32_t>(points.size());
  for (const auto v : cdt.finite_vertex_handles())
    if (v->info().value == unset) v->info().value = count++;
  Triangulation result;
  result.region_points = find_regions(cdt);
  if (surface.is_kept) Refinement(cdt, surface, result.region_points).run();
  result.points.resize(cdt.number_of_vertices());
  for (const auto v : cdt.finite_vertex_handles()) result.points[v->info().value] = vec(v->point());
  for (const auto& [corners, face] : sorted_faces(cdt)) {
    result.triangles.push_back(corners);
    result.regions.push_back(face->info().region);
  }
  return result;
}

}  // namespace orthodrive::scene

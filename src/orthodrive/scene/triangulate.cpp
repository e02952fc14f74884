#include "orthodrive/scene/triangulate.hpp"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace orthodrive::scene {
namespace {

constexpr std::uint32_t unset = std::numeric_limits<std::uint32_t>::max();
struct Index {
  std::uint32_t value = unset;
};
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
using FaceBase =
    CGAL::Triangulation_face_base_with_info_2<Index, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>;
using Cdt =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>,
                                               CGAL::Exact_predicates_tag>;

Vec2 vec(const Cdt::Point& p) { return {p.x(), p.y()}; }

/// Spreads the region of `start` over all faces that no constraint separates from it.
void fill_region(const Cdt& cdt, Cdt::Face_handle start, std::uint32_t region) {
  std::vector<Cdt::Face_handle> open = {start};
  start->info().value = region;
  while (!open.empty()) {
    const Cdt::Face_handle face = open.back();
    open.pop_back();
    for (int i = 0; i < 3; ++i) {
      const Cdt::Face_handle next = face->neighbor(i);
      if (face->is_constrained(i) || cdt.is_infinite(next) || next->info().value != unset) continue;
      next->info().value = region;
      open.push_back(next);
    }
  }
}

}  // namespace

Triangulation triangulate(std::span<const Vec2> points, std::span<const std::array<std::uint32_t, 2>> constraints) {
  std::vector<std::pair<Cdt::Point, Index>> input;
  for (std::size_t i = 0; i < points.size(); ++i)
    input.push_back({Cdt::Point(points[i].x, points[i].y), Index{static_cast<std::uint32_t>(i)}});
  Cdt cdt;
  cdt.insert(input.begin(), input.end());
  std::vector<Cdt::Vertex_handle> vertices(points.size());
  for (const auto v : cdt.finite_vertex_handles()) vertices[v->info().value] = v;
  for (const auto& [a, b] : constraints) cdt.insert_constraint(vertices[a], vertices[b]);

  Triangulation result;
  result.points.assign(points.begin(), points.end());
  for (const auto v : cdt.finite_vertex_handles()) {
    if (v->info().value != unset) continue;
    v->info().value = static_cast<std::uint32_t>(result.points.size());
    result.points.push_back(vec(v->point()));
  }
  std::vector<std::pair<std::array<std::uint32_t, 3>, Cdt::Face_handle>> faces;
  for (const auto f : cdt.finite_face_handles()) {
    std::array<std::uint32_t, 3> t = {f->vertex(0)->info().value, f->vertex(1)->info().value,
                                      f->vertex(2)->info().value};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    faces.push_back({t, f});
  }
  std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> largest;
  for (const auto& [t, face] : faces) {
    if (face->info().value == unset) {
      fill_region(cdt, face, static_cast<std::uint32_t>(largest.size()));
      largest.push_back(-1.0);
      result.region_points.emplace_back();
    }
    const std::uint32_t region = face->info().value;
    const Vec2 a = result.points[t[0]], b = result.points[t[1]], c = result.points[t[2]];
    if (const double area = cross(b - a, c - a); area > largest[region]) {
      largest[region] = area;
      result.region_points[region] = (a + b + c) * (1.0 / 3.0);
    }
    result.triangles.push_back(t);
    result.regions.push_back(region);
  }
  return result;
}

}  // namespace orthodrive::scene

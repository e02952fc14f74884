// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/scene/plan/drape.hpp"

#include <algorithm>
#include <cmath>

#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive::scene {
namespace {

constexpr double min_drape_m2 = 1e-5;  // smaller pieces are rounding at the edges of triangles

using Corners = std::array<Vec2, 3>;

/// The part of a convex polygon to the left of a -> b (Sutherland and Hodgman 1974).
std::vector<Vec2> left_part(const std::vector<Vec2>& polygon, Vec2 a, Vec2 b) {
  std::vector<Vec2> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
    const double dp = cross(b - a, p - a), dq = cross(b - a, q - a);
    if (dp >= 0.0) result.push_back(p);
    if ((dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0)) result.push_back(p + (q - p) * (dp / (dp - dq)));
  }
  return result;
}

double area_m2(const std::vector<Vec2>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 2; i < polygon.size(); ++i) twice += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  return 0.5 * twice;
}

/// Weights of the corners at p.
std::array<double, 3> barycentric(const Corners& t, Vec2 p) {
  const double area = cross(t[1] - t[0], t[2] - t[0]);
  const double u = cross(t[1] - p, t[2] - p) / area, v = cross(t[2] - p, t[0] - p) / area;
  return {u, v, 1.0 - u - v};
}

}  // namespace

void cut_at_mesh(const TriMesh& mesh, std::size_t first_index, std::span<const std::array<Vec2, 4>> polygons,
                 const std::function<void(std::size_t, std::span<const DrapedCorner>)>& use) {
  if (polygons.empty() || first_index >= mesh.indices.size()) return;
  const auto corners = [&](std::size_t first) {
    Corners result;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& p = mesh.positions[mesh.indices[first + k]];
      result[k] = {p[0], p[1]};
    }
    return result;
  };
  std::vector<Box2> boxes;
  for (std::size_t i = first_index; i < mesh.indices.size(); i += 3) {
    const Corners t = corners(i);
    boxes.push_back({std::min({t[0].x, t[1].x, t[2].x}), std::min({t[0].y, t[1].y, t[2].y}),
                     std::max({t[0].x, t[1].x, t[2].x}), std::max({t[0].y, t[1].y, t[2].y})});
  }
  const SpatialIndex index(boxes);
  const auto blend = [&](const auto& values, std::size_t first, const std::array<double, 3>& w, std::size_t k) {
    double sum = 0.0;
    for (std::size_t c = 0; c < 3; ++c) sum += w[c] * static_cast<double>(values[mesh.indices[first + c]][k]);
    return sum;
  };
  std::vector<DrapedCorner> draped;
  for (std::size_t number = 0; number < polygons.size(); ++number) {
    const auto& polygon = polygons[number];
    Box2 box{polygon[0].x, polygon[0].y, polygon[0].x, polygon[0].y};
    for (const Vec2 p : polygon)
      box = {std::min(box.min_x, p.x), std::min(box.min_y, p.y), std::max(box.max_x, p.x), std::max(box.max_y, p.y)};
    for (const std::uint32_t triangle : index.touching(box)) {
      const std::size_t first = first_index + 3 * static_cast<std::size_t>(triangle);
      const Corners t = corners(first);
      std::vector<Vec2> part(polygon.begin(), polygon.end());
      for (std::size_t k = 0; k < 3 && part.size() >= 3; ++k) part = left_part(part, t[k], t[(k + 1) % 3]);
      if (part.size() < 3 || area_m2(part) < min_drape_m2) continue;
      draped.clear();
      for (const Vec2 p : part) {
        const auto w = barycentric(t, p);
        std::array<double, 3> n = {blend(mesh.normals, first, w, 0), blend(mesh.normals, first, w, 1),
                                   blend(mesh.normals, first, w, 2)};
        const double length = std::hypot(n[0], n[1], n[2]);
        for (double& v : n) v /= length;
        draped.push_back({p, blend(mesh.positions, first, w, 2), n});
      }
      use(number, draped);
    }
  }
}

void drape(const TriMesh& mesh, std::size_t first_index, std::span<const std::array<Vec2, 4>> polygons, double lift_m,
           TriMesh& target) {
  cut_at_mesh(mesh, first_index, polygons, [&](std::size_t, std::span<const DrapedCorner> part) {
    const auto base = static_cast<std::uint32_t>(target.positions.size());
    const auto f = [](double v) { return static_cast<float>(v); };
    for (const DrapedCorner& c : part) {
      target.positions.push_back({f(c.p.x), f(c.p.y), f(c.z + lift_m)});
      target.normals.push_back({f(c.normal[0]), f(c.normal[1]), f(c.normal[2])});
    }
    for (std::uint32_t k = 2; k < part.size(); ++k)
      target.indices.insert(target.indices.end(), {base, base + k - 1, base + k});
  });
}

}  // namespace orthodrive::scene

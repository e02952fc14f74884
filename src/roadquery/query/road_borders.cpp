// SPDX-License-Identifier: Apache-2.0
#include "roadquery/query/road_borders.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "roadquery/roads/road_structures.hpp"

namespace roadquery {
namespace {

constexpr double step_m = 1.0, sagitta_m = 0.002;
constexpr double probe_m = 0.02;        // beyond the border: is another road there?
constexpr double beyond_seam_m = 0.27;  // a surface goes on 0.25 m beyond the end of its road, where nothing else is
constexpr double level_of_borders_m = 1.5;  // as for the query
constexpr double most_cells = 4e6;

/// Stations 0 ... length, so near each other that the chords of the outer edge are within the sagitta.
std::vector<double> stations(const Road& road) {
  std::vector<double> s = {0.0};
  while (s.back() < road.length) {
    const double k = std::abs(reference_point(road, s.back()).curvature);
    const double step = std::min(step_m, std::sqrt(8.0 * sagitta_m / std::max(k, 1e-6)));
    s.push_back(s.back() + std::max(step, 0.05));
  }
  s.back() = road.length;
  return s;
}

}  // namespace

RoadBorders::RoadBorders(const RoadQuery& query, double reach_m) : reach_m_(reach_m) {
  for (std::size_t i = 0; i < query.map().roads.size(); ++i) {
    const Road& road = query.map().roads[i];
    if (road.bridge || road.tunnel) continue;  // of others the parts that are neither
    add_edges(query, static_cast<int>(i));
    add_ends(query, static_cast<int>(i));
  }
  fill_grid();
}

void RoadBorders::add_edges(const RoadQuery& query, int index) {
  const Road& road = query.map().roads[static_cast<std::size_t>(index)];
  const std::vector<double> s = stations(road);
  for (const double side : {1.0, -1.0}) {
    SurfacePoint last{};
    for (std::size_t i = 0; i < s.size(); ++i) {
      const Edges edges = road_edges(road, s[i]);
      const SurfacePoint point = surface_point(road, s[i], side > 0.0 ? edges.left_t : edges.right_t);
      const double hdg = reference_point(road, s[i]).hdg;
      if (i > 0 && !is_on_structure(road, 0.5 * (s[i - 1] + s[i])))
        add(query, index, {last.x, last.y, last.z, point.x, point.y, point.z}, -side * std::sin(hdg),
            side * std::cos(hdg));
      last = point;
    }
  }
}

void RoadBorders::add_ends(const RoadQuery& query, int index) {
  const Road& road = query.map().roads[static_cast<std::size_t>(index)];
  for (const bool at_end : {false, true}) {
    if (is_on_structure(road, at_end ? road.length : 0.0)) continue;
    const double s = at_end ? road.length : 0.0, hdg = reference_point(road, s).hdg + (at_end ? 0.0 : M_PI);
    const double out_x = std::cos(hdg), out_y = std::sin(hdg);
    const Edges edges = road_edges(road, s);
    const int count = 1 + static_cast<int>((edges.left_t - edges.right_t) / step_m);
    const auto at = [&](int i) {
      SurfacePoint p = surface_point(road, s, edges.right_t + (edges.left_t - edges.right_t) * i / count);
      p.x += beyond_seam_m * out_x, p.y += beyond_seam_m * out_y;
      return p;
    };
    for (int i = 0; i < count; ++i) {
      const SurfacePoint p = at(i), q = at(i + 1);
      add(query, index, {p.x, p.y, p.z, q.x, q.y, q.z}, out_x, out_y);
    }
  }
}

/// (out_x, out_y): unit, away from the road.
void RoadBorders::add(const RoadQuery& query, int road, Segment segment, double out_x, double out_y) {
  const double x = 0.5 * (segment.x0 + segment.x1), y = 0.5 * (segment.y0 + segment.y1);
  const double z = 0.5 * (segment.z0 + segment.z1);
  Cursor cursor;
  const auto beyond = query.find(x + probe_m * out_x, y + probe_m * out_y, z, cursor);
  if (beyond && std::abs(beyond->z - z) <= level_of_borders_m) return;
  const auto blended = [&](double px, double py, double own_z) {
    Cursor inside{road, 0.0};
    const auto hit = query.find(px - probe_m * out_x, py - probe_m * out_y, own_z, inside);
    return hit && std::abs(hit->z - own_z) <= level_of_borders_m ? hit->z : own_z;
  };
  segment.z0 = blended(segment.x0, segment.y0, segment.z0);
  segment.z1 = blended(segment.x1, segment.y1, segment.z1);
  segments_.push_back(segment);
}

void RoadBorders::fill_grid() {
  if (segments_.empty()) return;
  double east = -std::numeric_limits<double>::infinity(), north = east;
  west_ = south_ = std::numeric_limits<double>::infinity();
  for (const Segment& p : segments_) {
    west_ = std::min({west_, p.x0, p.x1}), south_ = std::min({south_, p.y0, p.y1});
    east = std::max({east, p.x0, p.x1}), north = std::max({north, p.y0, p.y1});
  }
  cell_m_ = std::max({reach_m_, 1.0, std::sqrt((east - west_) * (north - south_) / most_cells),
                      (east - west_) / most_cells, (north - south_) / most_cells});
  columns_ = 1 + static_cast<int>((east - west_) / cell_m_);
  rows_ = 1 + static_cast<int>((north - south_) / cell_m_);
  const auto for_cells = [&](const Segment& p, auto&& visit) {
    const auto column = [&](double x) { return static_cast<int>((x - west_) / cell_m_); };
    const auto row = [&](double y) { return static_cast<int>((y - south_) / cell_m_); };
    for (int r = row(std::min(p.y0, p.y1)); r <= row(std::max(p.y0, p.y1)); ++r)
      for (int c = column(std::min(p.x0, p.x1)); c <= column(std::max(p.x0, p.x1)); ++c)
        visit(static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c));
  };
  cell_begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const Segment& p : segments_) for_cells(p, [&](std::size_t cell) { ++cell_begin_[cell + 1]; });
  for (std::size_t i = 1; i < cell_begin_.size(); ++i) cell_begin_[i] += cell_begin_[i - 1];
  cell_segments_.resize(cell_begin_.back());
  std::vector<std::uint32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  for (std::uint32_t i = 0; i < segments_.size(); ++i)
    for_cells(segments_[i], [&](std::size_t cell) { cell_segments_[next[cell]++] = i; });
}

std::optional<NearestBorder> RoadBorders::nearest(double x, double y) const {
  if (segments_.empty()) return std::nullopt;
  const double c0 = std::floor((x - reach_m_ - west_) / cell_m_), c1 = std::floor((x + reach_m_ - west_) / cell_m_);
  const double r0 = std::floor((y - reach_m_ - south_) / cell_m_), r1 = std::floor((y + reach_m_ - south_) / cell_m_);
  if (!(c1 >= 0.0 && c0 < columns_ && r1 >= 0.0 && r0 < rows_)) return std::nullopt;
  double best = reach_m_ * reach_m_;
  std::optional<NearestBorder> found;
  const int last_column = static_cast<int>(std::min(c1, columns_ - 1.0)),
            last_row = static_cast<int>(std::min(r1, rows_ - 1.0));
  for (int r = static_cast<int>(std::max(r0, 0.0)); r <= last_row; ++r) {
    for (int c = static_cast<int>(std::max(c0, 0.0)); c <= last_column; ++c) {
      const std::size_t cell =
          static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
      for (std::uint32_t i = cell_begin_[cell]; i < cell_begin_[cell + 1]; ++i) {
        const Segment& p = segments_[cell_segments_[i]];
        const double dx = p.x1 - p.x0, dy = p.y1 - p.y0, dz = p.z1 - p.z0, square = dx * dx + dy * dy;
        const double foot = square > 0.0 ? ((x - p.x0) * dx + (y - p.y0) * dy) / square : -1.0;
        const double u = std::clamp(foot, 0.0, 1.0);
        const double fx = p.x0 + u * dx, fy = p.y0 + u * dy, d = (x - fx) * (x - fx) + (y - fy) * (y - fy);
        if (d >= best) continue;
        best = d;
        const double slope = foot == u ? dz / square : 0.0;  // beside a corner the height is the corner's
        found = NearestBorder{std::sqrt(d), fx, fy, p.z0 + u * dz, slope * dx, slope * dy};
      }
    }
  }
  return found;
}

}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/evaluate/roads/path_shape.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "orthodrive/evaluate/labels/no_value.hpp"

namespace orthodrive::evaluate {
namespace {

/// Points at equal distances along the line, `steps` + 1 of them.
Polyline resampled(const Polyline& line, const std::vector<double>& s, std::size_t steps) {
  Polyline points;
  std::size_t i = 0;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double at = s.back() * static_cast<double>(k) / static_cast<double>(steps);
    while (i + 2 < line.size() && s[i + 1] < at) ++i;
    const double run = s[i + 1] - s[i];
    points.push_back(line[i] + (line[i + 1] - line[i]) * (run > 0.0 ? std::clamp((at - s[i]) / run, 0.0, 1.0) : 0.0));
  }
  return points;
}

struct Jump {
  double per_m;
  Vec2 where;
};

std::optional<Jump> largest_jump(const RoadPath& path, const ScoreRegion& region, double step_m) {
  const Polyline line = centerline(path);
  const std::vector<double> s = arc_lengths_m(line);
  if (line.size() < 2 || s.back() < 4.0 * step_m) return {};
  const auto steps = static_cast<std::size_t>(std::lround(s.back() / step_m));
  const double run_m = s.back() / static_cast<double>(steps);
  Polyline points = resampled(line, s, steps);
  const bool closed = line.front() == line.back();
  if (closed)  // three more steps: the samples across the joint
    for (std::size_t k = 1; k <= 3; ++k) points.push_back(points[k]);
  std::vector<double> curvature;  // at the points from the second to the last but one
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vec2 in = points[i] - points[i - 1], out = points[i + 1] - points[i];
    curvature.push_back(std::atan2(cross(in, out), dot(in, out)) / run_m);
  }
  std::optional<Jump> largest;
  for (std::size_t k = 1; k + 1 < curvature.size(); ++k) {
    const double jump = std::abs(curvature[k + 1] - curvature[k - 1]);
    const Vec2 where = points[k + 1];
    if (region.contains(where) && (!largest || jump > largest->per_m)) largest = Jump{jump, where};
  }
  return largest;
}
}  // namespace

double width_variance_m2(const RoadNetwork& roads, const ScoreRegion& region) {
  double sum = 0.0;
  std::size_t paths = 0;
  for (const RoadPath& path : roads.paths) {
    std::vector<double> widths;
    for (const RoadNode& node : path.nodes)
      if (region.contains(node.p)) widths.push_back(node.width_m);
    if (widths.size() < 2) continue;
    const auto n = static_cast<double>(widths.size());
    double mean = 0.0, squares = 0.0;
    for (const double width : widths) mean += width / n;
    for (const double width : widths) squares += (width - mean) * (width - mean) / n;
    sum += squares;
    ++paths;
  }
  return paths == 0 ? no_value : sum / static_cast<double>(paths);
}

CurvatureJump largest_curvature_jump(const RoadNetwork& roads, const ScoreRegion& region, double step_m) {
  CurvatureJump largest{.per_m = no_value, .mean_per_m = no_value};
  double sum = 0.0;
  std::size_t paths = 0;
  for (const RoadPath& path : roads.paths) {
    const auto jump = largest_jump(path, region, step_m);
    if (!jump) continue;
    sum += jump->per_m;
    if (paths++ == 0 || jump->per_m > largest.per_m) largest = {jump->per_m, path.osm_id, jump->where};
  }
  if (paths > 0) largest.mean_per_m = sum / static_cast<double>(paths);
  return largest;
}

}  // namespace orthodrive::evaluate

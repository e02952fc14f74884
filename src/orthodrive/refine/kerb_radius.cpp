// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/kerb_radius.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "orthodrive/roads/path_junctions.hpp"

namespace orthodrive {
namespace {

constexpr double largest_corner_m = 12.0;    // wider corners are forecourts and squares
constexpr double least_corner_angle = 0.7;   // rad between two edges that make a corner; as far from half a turn
constexpr double most_wrong_share = 0.2;     // share of the visible pixels that contradict a radius, at most
constexpr double least_visible_share = 0.6;  // share of the corner's pixels that nothing hides, at least

enum class Vote : std::uint8_t { hidden, paved, unpaved };

Vote vote_of(const ClassInfo& info) {
  if (info.role == Role::road) return Vote::paved;
  const bool hides = info.role == Role::vegetation || info.role == Role::maybe_road || info.role == Role::other;
  return hides ? Vote::hidden : Vote::unpaved;
}

/// A road that leaves a junction, as its straight edges a little way off.
struct Leaving {
  Vec2 through, outwards;  ///< a point of the centre line and its direction
  double width_m = 0.0;
  [[nodiscard]] Vec2 edge(double side) const { return through + left_normal(outwards) * (side * 0.5 * width_m); }
};

/// Between the two distances the edges of a road are straight and no longer those of the junction.
constexpr double near_m = 8.0, far_m = 20.0;

std::optional<Leaving> leaving(const RoadPath& path, std::size_t node, int step) {
  double walked = 0.0;
  std::optional<std::size_t> near;
  const auto last = static_cast<std::ptrdiff_t>(path.nodes.size()) - 1;
  for (auto i = static_cast<std::ptrdiff_t>(node); i + step >= 0 && i + step <= last; i += step) {
    const auto here = static_cast<std::size_t>(i), next = static_cast<std::size_t>(i + step);
    walked += distance(path.nodes[here].p, path.nodes[next].p);
    if (!near && walked >= near_m) near = next;
    if (near && walked >= 0.5 * (near_m + far_m) && (walked >= far_m || next == 0 || next == path.nodes.size() - 1)) {
      const RoadNode& from = path.nodes[*near];
      return Leaving{from.p, normalized(path.nodes[next].p - from.p), from.width_m};
    }
  }
  return std::nullopt;
}

/// Labels and what each says.
struct View {
  const LabelMap& labels;
  std::vector<Vote> votes;
  [[nodiscard]] Vote at(int column, int row) const {
    if (!labels.labels.inside(column, row)) return Vote::hidden;
    const std::uint8_t label = labels.labels.at(column, row);
    return label < votes.size() ? votes[label] : Vote::hidden;
  }
};

/// Whether the labels know the road: a road that they miss would have corners of no radius.
bool is_seen(const Leaving& arm, const View& view) {
  constexpr double least_paved = 0.7;
  int paved = 0, visible = 0;
  for (double s = 0.0; s <= far_m - near_m; s += 1.0) {
    const Vec2 q = view.labels.frame.pixel_from_world(arm.through + arm.outwards * s);
    const Vote vote = view.at(static_cast<int>(std::floor(q.x)), static_cast<int>(std::floor(q.y)));
    visible += vote == Vote::hidden ? 0 : 1;
    paved += vote == Vote::paved ? 1 : 0;
  }
  return paved > 0 && paved >= least_paved * visible;
}

std::vector<Leaving> arms_of(const RoadNetwork& roads, const PathJunction& junction) {
  std::vector<Leaving> arms;
  for (const JunctionArm& arm : junction.arms)
    for (const int step : {-1, 1})
      if (const auto one = leaving(roads.paths[arm.path], arm.node, step)) arms.push_back(*one);
  std::sort(arms.begin(), arms.end(), [](const Leaving& a, const Leaving& b) {
    return std::atan2(a.outwards.y, a.outwards.x) < std::atan2(b.outwards.y, b.outwards.x);
  });
  return arms;
}

/// Where the left edge of one arm and the right edge of the next one to the left meet.
struct Corner {
  Vec2 p, right_edge, left_edge;  ///< unit vectors along the edges, away from the junction
  double angle = 0.0;
};

std::optional<Corner> corner_of(const Leaving& a, const Leaving& b, Vec2 junction) {
  constexpr double farthest_m = 15.0;
  const double sine = cross(a.outwards, b.outwards), angle = std::atan2(sine, dot(a.outwards, b.outwards));
  if (angle < least_corner_angle || angle > M_PI - least_corner_angle) return std::nullopt;
  const Vec2 from = a.edge(1.0);
  const Vec2 p = from + a.outwards * (cross(b.edge(-1.0) - from, b.outwards) / sine);
  if (distance(p, junction) > farthest_m) return std::nullopt;
  return Corner{p, a.outwards, b.outwards, angle};
}

/// The radius that just paves the place `w` beside a corner.
double paving_radius_m(Vec2 w, Vec2 bisector, double k) {
  const double along = k * dot(w, bisector), rest = k * k - 1.0;
  return (along + std::sqrt(std::max(along * along - rest * dot(w, w), 0.0))) / rest;
}

struct CornerPixel {
  double radius_m = 0.0;
  bool paved = false;
};

/// Visible pixels beside the corner that a radius within the bound paves, and as far again, with the share that is
/// visible.
std::vector<CornerPixel> pixels_of(const Corner& corner, const View& view, double& visible) {
  const GridFrame& frame = view.labels.frame;
  const double k = 1.0 / std::sin(0.5 * corner.angle);
  const Vec2 bisector = normalized(corner.right_edge + corner.left_edge);
  // The arc touches the edges this far from the corner.
  const double reach_m = largest_corner_m / std::tan(0.5 * corner.angle);
  const Vec2 middle = frame.pixel_from_world(corner.p);
  const int reach = static_cast<int>(std::ceil(reach_m / frame.gsd_m));
  const int column = static_cast<int>(std::floor(middle.x)), row = static_cast<int>(std::floor(middle.y));
  std::vector<CornerPixel> pixels;
  double all = 0.0;
  for (int r = row - reach; r <= row + reach; ++r)
    for (int c = column - reach; c <= column + reach; ++c) {
      const Vec2 w = frame.center_of(c, r) - corner.p;
      if (cross(corner.right_edge, w) <= 0.0 || cross(w, corner.left_edge) <= 0.0) continue;
      const double radius = paving_radius_m(w, bisector, k);
      if (radius > largest_corner_m) continue;
      all += 1.0;
      const Vote vote = view.at(c, r);
      if (vote != Vote::hidden) pixels.push_back({radius, vote == Vote::paved});
    }
  visible = all > 0.0 ? static_cast<double>(pixels.size()) / all : 0.0;
  return pixels;
}

/// The split that the fewest pixels contradict; none where it says nothing.
std::optional<double> split_of(std::vector<CornerPixel> pixels) {
  std::sort(pixels.begin(), pixels.end(),
            [](const CornerPixel& a, const CornerPixel& b) { return a.radius_m < b.radius_m; });
  auto wrong = static_cast<double>(std::count_if(pixels.begin(), pixels.end(), [](const auto& p) { return p.paved; }));
  double least = wrong, radius = 0.0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    wrong += pixels[i].paved ? -1.0 : 1.0;
    if (wrong >= least) continue;
    least = wrong;
    radius = i + 1 < pixels.size() ? 0.5 * (pixels[i].radius_m + pixels[i + 1].radius_m) : pixels[i].radius_m;
  }
  const bool is_open = radius > 0.95 * largest_corner_m;  // paved as far as one looks
  if (is_open || least > most_wrong_share * static_cast<double>(pixels.size())) return std::nullopt;
  return radius;
}

double middle_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

std::vector<double> radii_of(const RoadNetwork& roads, const PathJunction& junction, const View& view) {
  const std::vector<Leaving> arms = arms_of(roads, junction);
  std::vector<double> radii;
  for (std::size_t i = 0; arms.size() > 2 && i < arms.size(); ++i) {
    const Leaving &right = arms[i], &left = arms[(i + 1) % arms.size()];
    const auto corner = corner_of(right, left, junction.p);
    if (!corner || !is_seen(right, view) || !is_seen(left, view)) continue;
    double visible = 0.0;
    std::vector<CornerPixel> pixels = pixels_of(*corner, view, visible);
    if (visible < least_visible_share) continue;
    if (const auto radius = split_of(std::move(pixels))) radii.push_back(*radius);
  }
  return radii;
}

}  // namespace

int measure_kerb_radii(RoadNetwork& roads, const LabelMap& labels) {
  constexpr double least_m = 0.5;  // a kerb has some; 0 would say that nothing is known
  View view{labels, {}};
  for (const ClassInfo& info : labels.classes.classes) view.votes.push_back(vote_of(info));
  for (RoadPath& path : roads.paths)
    for (RoadNode& node : path.nodes) node.kerb_radius_m = 0.0;
  int measured = 0;
  for (const PathJunction& junction : find_junctions(roads, link_path_ends(roads))) {
    const std::vector<double> radii = radii_of(roads, junction, view);
    if (radii.empty()) continue;
    for (const JunctionArm& arm : junction.arms)
      roads.paths[arm.path].nodes[arm.node].kerb_radius_m = std::max(middle_of(radii), least_m);
    ++measured;
  }
  return measured;
}

}  // namespace orthodrive

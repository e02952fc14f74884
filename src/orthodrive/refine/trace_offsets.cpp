// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/trace_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "orthodrive/core/parallel.hpp"
#include "orthodrive/geo/spatial_index.hpp"

namespace orthodrive::refine {
namespace {

constexpr double reach_m = 12.0;           // the map is off by up to 8 m, the receiver by some metres
constexpr double least_alignment = 0.866;  // cos 30 degrees: lines that cross are not the same road
constexpr double gps_sigma_m = 3.0;        // of a receiver's position to each side, as consumers have them
constexpr double standing_m = 3.0, direction_m = 10.0;
constexpr double least_chord =
    0.4;  // of the way driven: a hairpin of 4 m radius has it, a receiver that wanders has not
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Directions over +-direction_m around the middle of each segment.
std::vector<Vec2> directions_of(const Polyline& line) {
  const std::vector<double> s = arc_lengths_m(line);
  std::vector<Vec2> directions;
  std::size_t behind = 0, ahead = 0;
  const auto at = [&](std::size_t& k, double s_m) {  // s_m rises from call to call
    while (k + 2 < line.size() && s[k + 1] < s_m) ++k;
    return line[k] + (line[k + 1] - line[k]) * std::clamp((s_m - s[k]) / (s[k + 1] - s[k]), 0.0, 1.0);
  };
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double middle = 0.5 * (s[i] + s[i + 1]), half = std::max(direction_m, 0.5 * (s[i + 1] - s[i]));
    const double from = std::max(0.0, middle - half), to = std::min(s.back(), middle + half);
    const Vec2 chord = at(ahead, to) - at(behind, from);
    directions.push_back(length(chord) > least_chord * (to - from) ? normalized(chord) : Vec2{});
  }
  return directions;
}

/// The path at each segment of a chain, and whether the chain runs along it.
struct PathAt {
  std::size_t path = 0;
  bool reversed = false;
};
std::vector<PathAt> paths_along(const RoadChain& chain) {
  std::vector<PathAt> paths(chain.nodes.size());
  for (const ChainPiece& piece : chain.pieces)
    for (std::size_t i = piece.first; i <= piece.last; ++i) paths[i] = {piece.path, piece.reversed};
  return paths;
}

/// How far beside the middle one drives, and how sure that is. Two vehicles pass each other from about 5 m on; on
/// one-way roads with more than a lane the driven one is unknown.
struct DrivenLine {
  double side_m = 0.0, sigma_m = 0.0;
};
DrivenLine driven_line(double width_m, Oneway oneway) {
  const double two_lanes = std::clamp((width_m - 4.0) / 1.5, 0.0, 1.0), wander_m = 0.1 * width_m;
  if (oneway == Oneway::no) return {0.25 * width_m * two_lanes, wander_m};
  return {0.0, std::hypot(wander_m, 0.15 * width_m * two_lanes)};
}

struct Witness {
  double offset_m = 0.0, weight = 1.0;
};

/// Iteratively reweighted from the median on; the sum of the weights is how many witnesses agree.
Witness robust_mean(std::vector<double> values, double scale_m) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  Witness mean{values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle])};
  for (int round = 0; round < 8; ++round) {
    double sum = 0.0, weights = 0.0;
    for (const double v : values) {
      const double r = (v - mean.offset_m) / (2.0 * scale_m), weight = 1.0 / (1.0 + r * r);
      sum += weight * v, weights += weight;
    }
    mean = {sum / weights, weights};
  }
  return mean;
}

}  // namespace

std::vector<MovingTrace> moving_traces(const GpsTraces& traces) {
  std::vector<MovingTrace> moving;
  for (const GpsTrace& trace : traces.traces) {
    MovingTrace moved{.recording = trace.recording};
    for (const Vec2 p : trace.line)
      if (moved.line.empty() || distance(moved.line.back(), p) >= standing_m) moved.line.push_back(p);
    if (moved.line.size() < 2) continue;
    moved.direction = directions_of(moved.line);
    moving.push_back(std::move(moved));
  }
  return moving;
}

std::vector<std::vector<TracePass>> find_passes(const std::vector<RoadChain>& chains, const RoadNetwork& osm,
                                                const std::vector<MovingTrace>& traces,
                                                const std::vector<std::vector<Neighbour>>& neighbours, int threads) {
  std::vector<std::vector<TracePass>> passes(chains.size());
  if (traces.empty()) return passes;
  std::vector<Polyline> lines;
  lines.reserve(traces.size());
  for (const MovingTrace& trace : traces) lines.push_back(trace.line);
  const SegmentIndex index(lines);
  std::vector<std::vector<PathAt>> paths_of;
  paths_of.reserve(chains.size());
  for (const RoadChain& chain : chains) paths_of.push_back(paths_along(chain));
  parallel_for(chains.size(), threads, [&](std::size_t c) {
    const RoadChain& chain = chains[c];
    const std::vector<PathAt>& paths = paths_of[c];
    std::vector<TracePass> borders(chain.nodes.size(), {.right_m = -infinity, .left_m = infinity});
    for (const Neighbour& n : neighbours[c]) {
      // Carriageways in opposite directions are told apart by where one drives.
      const PathAt here = paths[n.node], there = paths_of[n.chain][n.segment];
      const double along = (here.reversed == there.reversed ? 1.0 : -1.0) * n.alignment;
      if (along < 0.0 && osm.paths[here.path].oneway != Oneway::no && osm.paths[there.path].oneway != Oneway::no)
        continue;
      if (n.base_m > 0.0) borders[n.node].left_m = 0.5 * n.base_m;
      if (n.base_m < 0.0) borders[n.node].right_m = 0.5 * n.base_m;
    }
    for (std::size_t i = 0; i < chain.nodes.size(); ++i) {
      const ChainNode& node = chain.nodes[i];
      const RoadPath& path = osm.paths[paths[i].path];
      if (path.tunnel) continue;
      const Vec2 ahead = left_normal(node.normal) * -1.0;
      for (const auto [l, k] : index.near(node.base, reach_m)) {
        const MovingTrace& trace = traces[l];
        const double alignment = dot(trace.direction[k], ahead), drive = alignment > 0.0 ? 1.0 : -1.0;
        if (std::abs(alignment) < least_alignment) continue;
        if (path.oneway != Oneway::no && drive != (paths[i].reversed ? -1.0 : 1.0)) continue;
        const Vec2 a = trace.line[k], along = trace.line[k + 1] - a;
        const double across = cross(along, node.normal);  // 0 where the segment runs along the normal
        if (across == 0.0) continue;
        const double fraction = cross(node.base - a, node.normal) / across;
        if (fraction < 0.0 || fraction >= 1.0) continue;
        const double offset_m = dot(a + along * fraction - node.base, node.normal);
        if (std::abs(offset_m) <= reach_m)
          passes[c].push_back({i, trace.recording, offset_m, drive, borders[i].right_m, borders[i].left_m});
      }
    }
    std::stable_sort(passes[c].begin(), passes[c].end(), [](const TracePass& a, const TracePass& b) {
      return std::pair(a.node, a.recording) < std::pair(b.node, b.recording);
    });
  });
  return passes;
}

std::vector<TraceOffset> trace_offsets(const RoadChain& chain, const RoadNetwork& osm,
                                       const std::vector<TracePass>& passes, const std::vector<double>& width_m,
                                       const std::vector<ExpectedOffset>& expected, const RefineRoadsOptions& options) {
  if (passes.empty()) return {};
  std::vector<TraceOffset> offsets(chain.nodes.size());
  const std::vector<PathAt> paths = paths_along(chain);
  const double keeps_right = options.driving_side == DrivingSide::right ? 1.0 : -1.0;
  for (std::size_t begin = 0; begin < passes.size();) {
    const std::size_t node = passes[begin].node;
    const DrivenLine driven = driven_line(width_m[node], osm.paths[paths[node].path].oneway);
    const double shift_m = expected.empty() ? 0.0 : expected[node].offset_m;
    std::vector<double> witnesses;  // one a recording: its laps have the error of one receiver
    std::size_t end = begin;
    while (end < passes.size() && passes[end].node == node) {
      const std::size_t recording = passes[end].recording;
      double sum = 0.0, count = 0.0;
      for (; end < passes.size() && passes[end].node == node && passes[end].recording == recording; ++end) {
        const TracePass& pass = passes[end];
        const double beside_m = pass.offset_m - shift_m;
        if (beside_m <= pass.right_m || beside_m >= pass.left_m) continue;
        sum += pass.offset_m + keeps_right * pass.drive * driven.side_m, count += 1.0;
      }
      if (count > 0.0) witnesses.push_back(sum / count);
    }
    if (!witnesses.empty()) {
      const Witness mean = robust_mean(witnesses, gps_sigma_m);
      offsets[node] = {mean.offset_m, std::hypot(gps_sigma_m / std::sqrt(mean.weight), driven.sigma_m), mean.weight};
    }
    begin = end;
  }
  return offsets;
}

std::vector<ExpectedOffset> combine(const std::vector<ExpectedOffset>& map, const std::vector<TraceOffset>& traces) {
  if (traces.empty()) return map;
  std::vector<ExpectedOffset> both = map;
  for (std::size_t i = 0; i < both.size(); ++i) {
    if (traces[i].recordings <= 0.0) continue;
    both[i] = combined(map[i], {traces[i].offset_m, traces[i].sigma_m});
  }
  return both;
}

}  // namespace orthodrive::refine

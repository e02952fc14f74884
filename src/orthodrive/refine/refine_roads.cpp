// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/refine/refine_roads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/refine/cross_profiles.hpp"
#include "orthodrive/refine/fit_chain.hpp"
#include "orthodrive/refine/parallel_roads.hpp"
#include "orthodrive/refine/search_offsets.hpp"
#include "orthodrive/refine/seen_places.hpp"
#include "orthodrive/refine/shift_field.hpp"
#include "orthodrive/refine/trace_offsets.hpp"
#include "orthodrive/refine/trace_paths.hpp"
#include "orthodrive/roads/join_junctions.hpp"
#include "orthodrive/roads/path_crossings.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive {
namespace {

using namespace refine;

constexpr double unseen_finding_m = 20.0;  // shorter stretches without a road in the labels are not reported

struct RefinedChain {
  ChainFit fit;
  std::vector<bool> road_near;  // one for each segment
};

void check(const RoadNetwork& osm, const RoadEvidence& evidence, const RefineRoadsOptions& options,
           const GpsTraces& traces) {
  if (!traces.traces.empty() && !(traces.crs == osm.crs))
    throw OptionError(fmt::format("refine: GPS traces are in {} but roads in {}, need one CRS", traces.crs.definition,
                                  osm.crs.definition));
  if (!(osm.crs == evidence.crs))
    throw OptionError(fmt::format("refine: roads are in {} but labels in {}, need one CRS", osm.crs.definition,
                                  evidence.crs.definition));
  if (!(options.spacing_m > 0.0) || !(options.search_radius_m > 0.0) || !(options.strip_m > 0.0) ||
      !(options.min_width_factor > 0.0) || !(options.max_width_factor > options.min_width_factor))
    throw OptionError(
        "refine: spacing, search radius, strip and width factors must be positive, the largest factor above the "
        "smallest");
  for (const RoadPath& path : osm.paths) {
    if (path.nodes.size() < 2) throw OptionError(fmt::format("refine: way {} has fewer than two nodes", path.osm_id));
    for (const RoadNode& node : path.nodes)
      if (!(node.width_m > 0.0))
        throw OptionError(fmt::format("refine: way {} has no width, set default_width_m", path.osm_id));
  }
}

/// The evidence straightened along a chain, as far as its roads may move. The search looks at strips wider than the
/// fit's.
CrossProfiles profiles_of(const RoadChain& chain, const RoadEvidence& evidence, const RefineRoadsOptions& options) {
  double widest_m = 0.0;
  for (const ChainNode& node : chain.nodes)
    widest_m = std::max(widest_m, max_width_factor(node, options) * node.input_width_m);
  return sample_cross_profiles(chain, evidence, options.search_radius_m + 0.5 * widest_m + 2.0 * options.strip_m);
}

Polyline line_of(const RoadChain& chain, const ChainShape& shape) {
  Polyline line;
  for (std::size_t i = 0; i < chain.nodes.size(); ++i)
    line.push_back(chain.nodes[i].base + chain.nodes[i].normal * shape.offset_m[i]);
  return line;
}

/// All chains of a site and the state of the method. In each round every chain is fitted on its own, in parallel, with
/// its neighbours held fixed. Profiles are sampled again in each round: kept, they would be most of the memory.
class Refinement {
 public:
  /// `osm` may hold paths of traces from `first_of_traces` on.
  Refinement(const RoadNetwork& osm, std::size_t first_of_traces, const RoadEvidence& evidence,
             const std::vector<MovingTrace>& traces, const RoadAlignment& alignment, const RefineRoadsOptions& options,
             Monitor* monitor)
      : osm_(osm),
        first_of_traces_(first_of_traces),
        evidence_(evidence),
        options_(options),
        monitor_(monitor),
        chains_(build_chains(osm, {.spacing_m = options.spacing_m})) {
    mask_evidence(chains_, osm);
    merging_ = find_merging(chains_, osm);
    neighbours_ = find_neighbours(chains_, osm);
    shapes_.resize(chains_.size());
    refined_.resize(chains_.size());
    expected_.resize(chains_.size());
    passes_ = find_passes(chains_, osm, traces, neighbours_, options.threads);
    traces_.resize(chains_.size());
    for (const RoadChain& chain : chains_) seen_.push_back(seen_on_chain(chain, alignment, options.weights.seen_sigma));
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      std::vector<double> widths_m;
      for (const ChainNode& node : chains_[c].nodes) widths_m.push_back(node.input_width_m);
      look_at_traces(c, widths_m);
    }
  }

  /// First guesses. Each chain finds its road on its own; from these offsets follows the shift of the map around every
  /// place; then each chain searches again near that shift. So hidden roads, and roads beside a yard that looks more
  /// like a road, follow their neighbours.
  void search() {
    RefineWeights wide = options_.weights;
    wide.search_offset_m = options_.weights.map_shift_m;
    search_chains(0, wide);
    learn_shift();
    search_chains(1, options_.weights);
  }

  /// Fits every chain on its own, places the junctions by these lines, and fits again: now chains pass through their
  /// junctions and keep to their side of neighbours.
  void fit() {
    std::vector<ChainCoupling> couplings(chains_.size());
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      look_at_traces(c, shapes_[c].width_m);
      couplings[c].expected = expected_[c];
      couplings[c].traces = traces_[c];
      couplings[c].seen = seen_[c];
    }
    fit_chains(2, couplings);
    junctions_ = place_junctions(chains_, lines());
    for (const JunctionPlace& place : junctions_)
      for (const auto& [chain, node, sigma_m] : place.passes) {
        const ChainNode& at = chains_[chain].nodes[node];
        couplings[chain].meetings.push_back({node, dot(place.p - at.base, at.normal), sigma_m});
      }
    for (std::size_t c = 0; c < chains_.size(); ++c)
      couplings[c].limits = limits_of(occupied_by_neighbours(c, chains_, neighbours_, shapes_));
    fit_chains(3, couplings);
  }

  [[nodiscard]] RefinedRoads result() const;

 private:
  static constexpr double tolerated_overlap_m = 0.5;

  /// Where two roads have found the same place, the road farther from its map line searches again.
  void search_chains(int phase, const RefineWeights& weights) {
    RefineRoadsOptions options = options_;
    options.weights = weights;
    std::vector<std::vector<ExpectedOffset>> expected(chains_.size());
    for (std::size_t c = 0; c < chains_.size(); ++c) expected[c] = expected_of_search(c);
    const auto search_chain = [&](std::size_t c, const std::vector<Occupied>& occupied) {
      CrossProfiles profiles = profiles_of(chains_[c], evidence_, options);
      silence_merging(chains_[c], merging_[c], expected_[c], options, profiles);
      mask_neighbours(borders_of_search(occupied), profiles);
      keep_road_near(c, profiles);
      return search_offsets(chains_[c], profiles, expected[c], options);
    };
    shared_for(
        options.exchange, fmt::format("search{}", phase), chains_.size(), options.threads,
        [&](std::size_t c) { shapes_[c] = search_chain(c, {}); },
        [&](auto& archive, std::size_t c) { archive(shapes_[c], refined_[c].road_near); },
        [&](std::size_t done) { report(phase, done); });
    constexpr int sweeps = 2;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      std::vector<ChainShape> next = shapes_;
      const auto search_again = [&](std::size_t c) {
        const std::vector<Occupied> occupied = occupied_by_neighbours(c, chains_, neighbours_, shapes_);
        if (std::ranges::any_of(occupied,
                                [](const Occupied& o) { return o.yields && o.overlap_m > tolerated_overlap_m; }))
          next[c] = search_chain(c, occupied);
      };
      shared_for(options.exchange, fmt::format("search{}-again{}", phase, sweep), chains_.size(), options.threads,
                 search_again, [&](auto& archive, std::size_t c) { archive(next[c], refined_[c].road_near); });
      shapes_ = std::move(next);
    }
  }
  /// With the present widths and the shift of the map, which tells parallel roads apart.
  void look_at_traces(std::size_t c, const std::vector<double>& widths_m) {
    traces_[c] = trace_offsets(chains_[c], osm_, passes_[c], widths_m, expected_[c], options_);
  }
  /// Expected offsets by the map's shift (its prior until it is known), the traces, and where the network sees the
  /// road.
  [[nodiscard]] std::vector<ExpectedOffset> expected_of_search(std::size_t c) const {
    if (traces_[c].empty() && seen_[c].empty()) return expected_[c];
    const std::vector<ExpectedOffset> prior =
        !expected_[c].empty()
            ? expected_[c]
            : std::vector<ExpectedOffset>(chains_[c].nodes.size(), {0.0, options_.weights.map_shift_m});
    return combine(combine(prior, traces_[c]), seen_[c]);
  }
  void keep_road_near(std::size_t c, const CrossProfiles& profiles) {
    refined_[c].road_near.clear();
    for (std::size_t row = 0; row < profiles.road_near.size(); row += rows_per_segment)
      refined_[c].road_near.push_back(profiles.road_near[row] || profiles.road_near[row + rows_per_segment - 1]);
  }
  /// What the roads around say about the shift of the map, from what the chains have found by themselves, and where
  /// traces pass. What traces say of a chain comes in when it is fitted: where they cover most of it, the field must
  /// not say it again.
  void learn_shift() {
    const auto without = learned_shift(false);
    const bool traced = std::ranges::any_of(traces_, [](const auto& traces) { return !traces.empty(); });
    const auto with = traced ? learned_shift(true) : without;
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      const auto told = std::ranges::count_if(traces_[c], [](const TraceOffset& t) { return t.recordings > 0.0; });
      expected_[c] = 2 * static_cast<std::size_t>(told) >= chains_[c].nodes.size() ? without[c] : with[c];
      const std::vector<bool> of_traces = nodes_of_traces(c);
      for (std::size_t i = 0; i < of_traces.size(); ++i)
        if (of_traces[i]) expected_[c][i] = {0.0, options_.search_radius_m};  // no map, no shift of it
    }
  }
  /// First of the district, then what the streets around differ from that. One a node of each chain.
  [[nodiscard]] std::vector<std::vector<ExpectedOffset>> learned_shift(bool from_traces) const {
    std::vector<std::vector<ExpectedOffset>> expected;
    expected.reserve(chains_.size());
    for (const RoadChain& chain : chains_) expected.emplace_back(chain.nodes.size());
    add_shift({.reach_m = 200.0, .prior_m = options_.weights.map_shift_m, .outlier_m = 2.0}, from_traces, expected);
    add_shift({.reach_m = 120.0, .prior_m = 0.2 * options_.weights.map_shift_m, .outlier_m = 1.0}, from_traces,
              expected);
    return expected;
  }
  void add_shift(const ShiftFieldOptions& field, bool from_traces,
                 std::vector<std::vector<ExpectedOffset>>& learned) const {
    constexpr std::size_t sample_nodes = 5, place_nodes = 10;
    // The samples of a trace have one error: those that a place sees together, the length of the Gaussian, count as
    // one.
    const double trace_share = sample_nodes * options_.spacing_m / (2.5 * field.reach_m);
    std::vector<ShiftSample> samples;
    std::vector<Vec2> places;
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      const std::vector<ChainNode>& nodes = chains_[c].nodes;
      const std::vector<bool> of_traces = nodes_of_traces(c);
      for (std::size_t i = 0; i + 1 < nodes.size(); i += sample_nodes) {
        if (of_traces[i]) continue;
        const double known_m = learned[c][i].offset_m;
        if (refined_[c].road_near[i] && nodes[i].evidence.both() > 0.0)
          samples.push_back(
              {nodes[i].base, nodes[i].normal, shapes_[c].offset_m[i] - known_m, nodes[i].evidence.both()});
        if (from_traces && !traces_[c].empty() && traces_[c][i].recordings > 0.0)
          samples.push_back({nodes[i].base, nodes[i].normal, traces_[c][i].offset_m - known_m,
                             trace_share * std::pow(sample_sigma_m / traces_[c][i].sigma_m, 2)});
      }
      for (std::size_t i = 0; i < nodes.size(); i += place_nodes) places.push_back(nodes[i].base);
      places.push_back(nodes.back().base);
    }
    const std::vector<Shift> shifts = shift_at(places, samples, options_.threads, field);
    for (std::size_t c = 0, first = 0; c < chains_.size(); ++c) {
      const std::vector<ChainNode>& nodes = chains_[c].nodes;
      const std::size_t last = (nodes.size() + place_nodes - 1) / place_nodes;  // the place of the last node
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        const std::size_t k = std::min(i / place_nodes, last - 1);
        const std::size_t begin = k * place_nodes, end = std::min(begin + place_nodes, nodes.size() - 1);
        const double f = end > begin ? static_cast<double>(i - begin) / static_cast<double>(end - begin) : 0.0;
        const Shift &a = shifts[first + k], &b = shifts[first + k + 1];
        const auto mean = [f](auto x, auto y) { return x * (1.0 - f) + y * f; };
        const Vec2 n = nodes[i].normal;
        const double variance_m2 = n.x * n.x * mean(a.xx_m2, b.xx_m2) + 2.0 * n.x * n.y * mean(a.xy_m2, b.xy_m2) +
                                   n.y * n.y * mean(a.yy_m2, b.yy_m2);
        ExpectedOffset& expected = learned[c][i];
        expected.offset_m += dot(n, mean(a.shift_m, b.shift_m));
        expected.sigma_m = std::hypot(expected.sigma_m, std::sqrt(variance_m2));
      }
      first += last + 1;
    }
  }
  /// One a node: it lies on a path that only traces know.
  [[nodiscard]] std::vector<bool> nodes_of_traces(std::size_t c) const {
    std::vector<bool> of_traces(chains_[c].nodes.size(), false);
    for (const ChainPiece& piece : chains_[c].pieces)
      for (std::size_t i = piece.first; piece.path >= first_of_traces_ && i <= piece.last; ++i) of_traces[i] = true;
    return of_traces;
  }
  [[nodiscard]] std::vector<Polyline> lines() const {
    std::vector<Polyline> lines;
    lines.reserve(chains_.size());
    for (std::size_t c = 0; c < chains_.size(); ++c) lines.push_back(line_of(chains_[c], shapes_[c]));
    return lines;
  }
  void fit_chains(int phase, const std::vector<ChainCoupling>& couplings) {
    shared_for(
        options_.exchange, fmt::format("fit{}", phase), chains_.size(), options_.threads,
        [&](std::size_t c) {
          if (phase > 2 && couplings[c].meetings.empty() && couplings[c].limits.empty()) return;  // nothing new for it
          CrossProfiles profiles = profiles_of(chains_[c], evidence_, options_);
          silence_merging(chains_[c], merging_[c], expected_[c], options_, profiles);
          mask_neighbours(borders_of_fit(occupied_by_neighbours(c, chains_, neighbours_, shapes_)), profiles);
          refined_[c].fit = fit_chain(chains_[c], profiles, shapes_[c], couplings[c], options_);
          keep_road_near(c, profiles);
        },
        [&](auto& archive, std::size_t c) { archive(refined_[c].fit, refined_[c].road_near); },
        [&](std::size_t done) { report(phase, done); });
    for (std::size_t c = 0; c < chains_.size(); ++c) shapes_[c] = refined_[c].fit.shape;
  }
  void report(int phase, std::size_t done) const {
    constexpr double phases = 4.0;
    if (monitor_)
      monitor_->progress((phase + static_cast<double>(done) / static_cast<double>(chains_.size())) / phases, "refine");
  }

  const RoadNetwork& osm_;
  std::size_t first_of_traces_;
  const RoadEvidence& evidence_;
  const RefineRoadsOptions& options_;
  Monitor* monitor_;
  std::vector<RoadChain> chains_;
  std::vector<std::vector<Neighbour>> neighbours_;
  std::vector<std::vector<Merging>> merging_;
  std::vector<JunctionPlace> junctions_;
  std::vector<std::vector<ExpectedOffset>> expected_;  // one per node, of the map's shift
  std::vector<std::vector<TracePass>> passes_;
  std::vector<std::vector<TraceOffset>> traces_;  // one per node, or none
  std::vector<std::vector<SeenPlace>> seen_;      // one per node, or none
  std::vector<ChainShape> shapes_;
  std::vector<RefinedChain> refined_;
};

/// Long stretches where the labels show no road although they should: tunnels are not expected to be seen.
void report_unseen(const RoadChain& chain, const RefinedChain& refined, const RoadNetwork& osm,
                   std::size_t first_of_traces, Findings& findings) {
  for (const ChainPiece& piece : chain.pieces) {
    if (osm.paths[piece.path].tunnel) continue;
    for (std::size_t begin = piece.first; begin < piece.last; ++begin) {
      if (refined.road_near[begin]) continue;
      std::size_t end = begin;
      while (end < piece.last && !refined.road_near[end]) ++end;
      const double length = chain.nodes[end].s_m - chain.nodes[begin].s_m;
      const Vec2 middle = chain.nodes[(begin + end) / 2].base;
      if (length >= unseen_finding_m)
        findings.push_back(
            {Severity::warning, "refine.no_road_seen",
             fmt::format("way {}: the labels show no road over {:.0f} m, kept near the {} with the default width",
                         osm.paths[piece.path].osm_id, length,
                         piece.path < first_of_traces ? "OSM line" : "GPX traces"),
             middle.x, middle.y});
      begin = end;
    }
  }
}

/// Metres of road that the labels should show, and of those they do.
struct SeenLength {
  double expected_m = 0.0, seen_m = 0.0;
  Vec2 moment;  ///< of the expected ones

  void add(const RoadChain& chain, const RefinedChain& refined, const RoadNetwork& osm) {
    for (const ChainPiece& piece : chain.pieces) {
      if (osm.paths[piece.path].tunnel) continue;
      for (std::size_t i = piece.first; i < piece.last; ++i) {
        const double run_m = chain.nodes[i + 1].s_m - chain.nodes[i].s_m;
        expected_m += run_m;
        seen_m += refined.road_near[i] ? run_m : 0.0;
        moment = moment + chain.nodes[i].base * run_m;
      }
    }
  }
};

/// A map of another place, one that lies wrong altogether, or a photo in which the network is blind.
void report_strange_map(const SeenLength& length, Findings& findings) {
  constexpr double least_m = 500.0, least_share = 0.6;
  if (length.expected_m < least_m || length.seen_m >= least_share * length.expected_m) return;
  const Vec2 middle = length.moment * (1.0 / length.expected_m);
  findings.push_back(
      {Severity::warning, "refine.map_unlike_photo",
       fmt::format("the labels show a road near {:.0f} % of {:.1f} km of OSM's roads only: does the map lie where the "
                   "photo does, and are both of the same time? Else the network does not know such a photo",
                   100.0 * length.seen_m / length.expected_m, 0.001 * length.expected_m),
       middle.x, middle.y});
}

/// Ways that cross themselves without a node there: a loop drawn with a missing node, or a mistake.
void report_self_crossings(const RoadNetwork& osm, Findings& findings) {
  std::size_t last = osm.paths.size();
  for (const PathCrossing& crossing : find_crossings(osm)) {
    if (crossing.path_a != crossing.path_b || crossing.path_a == last) continue;
    last = crossing.path_a;
    findings.push_back(
        {Severity::warning, "refine.self_crossing",
         fmt::format("way {} crosses itself without a node, kept as it is; the labels do not count there",
                     osm.paths[last].osm_id),
         crossing.p.x, crossing.p.y});
  }
}

/// Traces of another place change nothing; they are reported because the file is probably the wrong one.
void report_outside(const GpsTraces& traces, const RoadEvidence& evidence, Findings& findings) {
  if (traces.traces.empty()) return;
  const Box2 box = evidence.frame.bounds();
  for (const GpsTrace& trace : traces.traces)
    if (std::ranges::any_of(trace.line, [&](Vec2 p) { return box.contains(p); })) return;
  const Vec2 p = traces.traces.front().line.front();
  findings.push_back({Severity::warning, "refine.traces_outside",
                      fmt::format("none of the {} GPS traces passes the labels (easting {:.0f}..{:.0f}, northing "
                                  "{:.0f}..{:.0f} m), the first begins at {:.0f}, {:.0f} m: not used",
                                  traces.traces.size(), box.min_x, box.max_x, box.min_y, box.max_y, p.x, p.y),
                      p.x, p.y});
}

/// The path of a piece of a chain, in the path's own direction.
RoadPath pack_path(const RoadPath& input, const RoadChain& chain, const ChainPiece& piece, const ChainFit& fit,
                   const Polyline& line) {
  RoadPath path = input;
  path.nodes.clear();
  for (std::size_t i = piece.first; i <= piece.last; ++i) {
    const ChainNode& node = chain.nodes[i];
    path.nodes.push_back({.p = line[i],
                          .osm_node = node.osm_node,
                          .offset_m = dot(line[i] - node.base, node.normal) * (piece.reversed ? -1.0 : 1.0),
                          .width_m = fit.shape.width_m[i],
                          .sigma_offset_m = fit.sigma_offset_m[i],
                          .sigma_width_m = fit.sigma_width_m[i]});
  }
  if (piece.reversed) std::reverse(path.nodes.begin(), path.nodes.end());
  const std::vector<double> s = arc_lengths_m(centerline(path));
  for (std::size_t i = 0; i < s.size(); ++i) path.nodes[i].s_m = s[i];
  return path;
}

RefinedRoads Refinement::result() const {
  std::vector<Polyline> lines = this->lines();
  bend_to_junctions(chains_, junctions_, lines);
  RefinedRoads result{.roads = {.crs = osm_.crs, .paths = std::vector<RoadPath>(osm_.paths.size())}};
  SeenLength seen_length;
  for (std::size_t c = 0; c < chains_.size(); ++c) seen_length.add(chains_[c], refined_[c], osm_);
  report_strange_map(seen_length, result.findings);
  report_self_crossings(osm_, result.findings);
  for (std::size_t c = 0; c < chains_.size(); ++c) {
    const ChainFit& fit = refined_[c].fit;
    result.solve.converged = result.solve.converged && fit.solve.converged;
    result.solve.iterations = std::max(result.solve.iterations, fit.solve.iterations);
    result.solve.cost_before += fit.solve.cost_before;
    result.solve.cost_after += fit.solve.cost_after;
    report_unseen(chains_[c], refined_[c], osm_, first_of_traces_, result.findings);
    if (!fit.solve.converged) {
      const ChainPiece& piece = chains_[c].pieces.front();
      const Vec2 middle = lines[c][lines[c].size() / 2];
      result.findings.push_back({Severity::info, "refine.not_converged",
                                 fmt::format("way {}: no convergence after {} iterations",
                                             osm_.paths[piece.path].osm_id, fit.solve.iterations),
                                 middle.x, middle.y});
    }
    for (const ChainPiece& piece : chains_[c].pieces)
      result.roads.paths[piece.path] = pack_path(osm_.paths[piece.path], chains_[c], piece, fit, lines[c]);
  }
  return result;
}

}  // namespace

RefinedRoads refine_roads(const RoadNetwork& osm, const RoadEvidence& evidence, const RefineRoadsOptions& options,
                          Monitor* monitor, const GpsTraces& traces, const RoadAlignment& alignment) {
  check(osm, evidence, options, traces);
  Findings findings;
  report_outside(traces, evidence, findings);
  const std::vector<MovingTrace> moving = moving_traces(traces);
  const RoadNetwork with_paths = moving.empty() ? RoadNetwork{} : with_paths_of_traces(osm, evidence, moving, findings);
  Refinement refinement(moving.empty() ? osm : with_paths, osm.paths.size(), evidence, moving, alignment, options,
                        monitor);
  refinement.search();
  refinement.fit();
  RefinedRoads result = refinement.result();
  result.findings.insert(result.findings.begin(), findings.begin(), findings.end());
  return result;
}

RefinedRoads refine_roads(const RoadNetwork& osm, const LabelMap& labels, const RefineRoadsOptions& options,
                          Monitor* monitor, const GpsTraces& traces) {
  return refine_roads(osm, road_evidence(labels), options, monitor, traces);
}

}  // namespace orthodrive

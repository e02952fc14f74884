#include "orthodrive/elevate/estimate_profiles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/elevate/fit_heights.hpp"
#include "orthodrive/model/path_crossings.hpp"

namespace orthodrive {
namespace {

constexpr int clearance_passes = 3;         // one a level of a stack of bridges
constexpr double clearance_tolerance_m = 0.1;

void check(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, const ElevateOptions& options) {
  if (dtms.empty()) throw OptionError("elevate: no terrain model given");
  for (const HeightGrid& dtm : dtms)
    if (!(dtm.crs == roads.crs))
      throw OptionError(fmt::format("elevate: roads are in {} but terrain in {}, need one CRS", roads.crs.definition, dtm.crs.definition));
  if (!(options.weight_height > 0.0) || !(options.weight_gradient >= 0.0) || !(options.weight_gradient_change > 0.0) ||
      !(options.cauchy_scale > 0.0))
    throw OptionError("elevate: the weights of height and gradient change and the Cauchy scale must be positive");
  for (const RoadPath& path : roads.paths)
    if (path.nodes.size() < 2) throw OptionError(fmt::format("elevate: way {} has fewer than two nodes", path.osm_id));
}

/// Two roads at different levels, the bridge or tunnel of them first to give way.
struct LevelCrossing {
  PathCrossing crossing;
  bool a_is_above = false;

  [[nodiscard]] std::size_t upper() const { return a_is_above ? crossing.path_a : crossing.path_b; }
  [[nodiscard]] std::size_t lower() const { return a_is_above ? crossing.path_b : crossing.path_a; }
};

std::vector<LevelCrossing> level_crossings(const RoadNetwork& roads) {
  std::vector<LevelCrossing> result;
  for (const PathCrossing& crossing : find_crossings(roads)) {
    const int a = roads.paths[crossing.path_a].layer, b = roads.paths[crossing.path_b].layer;
    if (a != b) result.push_back({crossing, a > b});
  }
  return result;
}

class Heights {
 public:
  explicit Heights(const HeightUnknowns& unknowns) : unknowns_(unknowns), z_m(unknowns.start_m), sigma_z_m(unknowns.size(), 0.0) {}

  void take(const HeightFit& fit) {
    for (std::size_t m = 0; m < fit.unknowns.size(); ++m) {
      z_m[fit.unknowns[m]] = fit.z_m[m];
      sigma_z_m[fit.unknowns[m]] = fit.sigma_z_m[m];
    }
  }
  [[nodiscard]] double at(std::size_t path, std::size_t segment, double fraction) const {
    const auto& indices = unknowns_.of_node[path];
    return z_m[indices[segment]] * (1.0 - fraction) + z_m[indices[segment + 1]] * fraction;
  }
  [[nodiscard]] double upper_z_m(const LevelCrossing& level) const { return at_path(level.crossing, level.a_is_above); }
  [[nodiscard]] double lower_z_m(const LevelCrossing& level) const { return at_path(level.crossing, !level.a_is_above); }

 private:
  [[nodiscard]] double at_path(const PathCrossing& c, bool a) const {
    return a ? at(c.path_a, c.segment_a, c.fraction_a) : at(c.path_b, c.segment_b, c.fraction_b);
  }
  const HeightUnknowns& unknowns_;

 public:
  std::vector<double> z_m, sigma_z_m;  ///< [unknown]
};

void solve_components(const std::vector<std::size_t>& which, const RoadNetwork& roads, const HeightUnknowns& unknowns,
                      const PathLinks& links, const std::vector<std::vector<StructureLimit>>& limits, const ElevateOptions& options,
                      Monitor* monitor, std::vector<HeightFit>& fits, Heights& heights) {
  parallel_for(
      which.size(), options.threads,
      [&](std::size_t k) { fits[which[k]] = fit_heights(roads, unknowns, unknowns.components[which[k]], links, limits[which[k]], options); },
      [&](std::size_t done) {
        if (monitor) monitor->progress(static_cast<double>(done) / static_cast<double>(which.size()), "elevate");
      });
  for (const std::size_t c : which) heights.take(fits[c]);
}

/// A limit for the bridge, or else for the tunnel, of a crossing; none when neither way is tagged as one.
bool limit_structure(const RoadNetwork& roads, const HeightUnknowns& unknowns, const LevelCrossing& level, const Heights& heights,
                     double clearance_m, StructureLimit& limit, std::size_t& path) {
  const bool raise = roads.paths[level.upper()].bridge;
  if (!raise && !roads.paths[level.lower()].tunnel) return false;
  path = raise ? level.upper() : level.lower();
  const bool is_a = path == level.crossing.path_a;
  const std::size_t segment = is_a ? level.crossing.segment_a : level.crossing.segment_b;
  limit.before = unknowns.of_node[path][segment], limit.after = unknowns.of_node[path][segment + 1];
  limit.fraction = is_a ? level.crossing.fraction_a : level.crossing.fraction_b;
  limit.side = raise ? StructureLimit::Side::above : StructureLimit::Side::below;
  limit.z_m = raise ? heights.lower_z_m(level) + clearance_m : heights.upper_z_m(level) - clearance_m;
  return true;
}

/// Raises bridges and lowers tunnels that are too close to the road they cross, with the roads that lead there.
void make_room(const RoadNetwork& roads, const HeightUnknowns& unknowns, const PathLinks& links, const std::vector<LevelCrossing>& levels,
               const ElevateOptions& options, std::vector<HeightFit>& fits, Heights& heights) {
  std::vector<std::size_t> component_of(roads.paths.size());
  for (std::size_t c = 0; c < unknowns.components.size(); ++c)
    for (const std::size_t k : unknowns.components[c]) component_of[k] = c;
  std::vector<bool> tight(levels.size(), false);
  for (int pass = 0; pass < clearance_passes; ++pass) {
    bool changed = false;
    for (std::size_t i = 0; i < levels.size(); ++i)
      if (heights.upper_z_m(levels[i]) - heights.lower_z_m(levels[i]) < options.clearance_m - clearance_tolerance_m)
        changed = true, tight[i] = true;
    if (!changed) return;
    std::vector<std::vector<StructureLimit>> limits(unknowns.components.size());
    std::set<std::size_t> affected;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      StructureLimit limit;
      std::size_t path = 0;
      if (!tight[i] || !limit_structure(roads, unknowns, levels[i], heights, options.clearance_m, limit, path)) continue;
      limits[component_of[path]].push_back(limit);
      affected.insert(component_of[path]);
    }
    solve_components({affected.begin(), affected.end()}, roads, unknowns, links, limits, options, nullptr, fits, heights);
  }
}

ProfileEnergy energy(const RoadNetwork& roads, const HeightUnknowns& unknowns, const std::vector<double>& z_m) {
  double gradients = 0.0, errors = 0.0;
  std::size_t segments = 0, nodes = 0;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& indices = unknowns.of_node[k];
    for (std::size_t n = 0; n < indices.size(); ++n) {
      if (!unknowns.measured[indices[n]]) continue;
      errors += std::pow(z_m[indices[n]] - unknowns.terrain_m[indices[n]], 2), ++nodes;
      if (n + 1 == indices.size() || !unknowns.measured[indices[n + 1]]) continue;
      const double run = distance(roads.paths[k].nodes[n].p, roads.paths[k].nodes[n + 1].p);
      if (run > 0.0) gradients += std::pow((z_m[indices[n + 1]] - z_m[indices[n]]) / run, 2), ++segments;
    }
  }
  return {segments > 0 ? gradients / static_cast<double>(segments) : 0.0, nodes > 0 ? errors / static_cast<double>(nodes) : 0.0};
}

/// Gradient of the segments at both sides of a node; where a way goes on in the next one, across both.
void set_gradients(RoadNetwork& roads, const PathLinks& links) {
  const auto slope = [](const RoadNode& a, const RoadNode& b) {
    const double run = distance(a.p, b.p);
    return run > 0.0 ? (b.z_m - a.z_m) / run : 0.0;
  };
  const auto rise_inwards = [&](PathEnd end) {  // gradient when going into the path from its end
    const auto& nodes = roads.paths[end.path].nodes;
    return end.at_back ? -slope(nodes[nodes.size() - 2], nodes.back()) : slope(nodes[0], nodes[1]);
  };
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    auto& nodes = roads.paths[k].nodes;
    for (std::size_t n = 1; n + 1 < nodes.size(); ++n) {
      const double before = distance(nodes[n - 1].p, nodes[n].p), after = distance(nodes[n].p, nodes[n + 1].p);
      const double total = before + after;  // a line through both neighbours, exact for parabolas
      nodes[n].gradient = total > 0.0 ? (slope(nodes[n - 1], nodes[n]) * after + slope(nodes[n], nodes[n + 1]) * before) / total : 0.0;
    }
    for (const bool at_back : {false, true}) {
      const PathEnd end{k, at_back};
      const auto link = links.find(end);
      const double inwards = link == links.end() ? rise_inwards(end) : 0.5 * (rise_inwards(end) - rise_inwards(link->second));
      (at_back ? nodes.back() : nodes.front()).gradient = at_back ? -inwards : inwards;
    }
  }
}

void report_missing_terrain(const RoadNetwork& roads, const HeightUnknowns& unknowns, Findings& findings) {
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& indices = unknowns.of_node[k];
    std::size_t missing = 0, first = 0;
    for (std::size_t n = indices.size(); n-- > 0;)
      if (std::isnan(unknowns.terrain_m[indices[n]])) ++missing, first = n;
    if (missing == 0) continue;
    const Vec2 p = roads.paths[k].nodes[first].p;
    findings.push_back({Severity::warning, "elevate.no_terrain",
                        fmt::format("way {}: no terrain height at {} of {} nodes, heights continue those beside", roads.paths[k].osm_id,
                                    missing, indices.size()),
                        p.x, p.y});
  }
}

void report_low_clearance(const RoadNetwork& roads, const std::vector<LevelCrossing>& levels, const Heights& heights, double clearance_m,
                          Findings& findings) {
  for (const LevelCrossing& level : levels) {
    const double room = heights.upper_z_m(level) - heights.lower_z_m(level);
    if (room >= clearance_m - clearance_tolerance_m) continue;
    findings.push_back({Severity::warning, "elevate.low_clearance",
                        fmt::format("way {} passes {:.1f} m over way {}, {:.1f} m are wanted", roads.paths[level.upper()].osm_id, room,
                                    roads.paths[level.lower()].osm_id, clearance_m),
                        level.crossing.p.x, level.crossing.p.y});
  }
}

}  // namespace

EstimateProfilesResult estimate_profiles(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, const ElevateOptions& options,
                                         Monitor* monitor) {
  check(roads, dtms, options);
  EstimateProfilesResult result{.roads = roads};
  if (roads.paths.empty()) return result;
  const HeightUnknowns unknowns = gather_height_unknowns(roads, dtms, options.sampling);
  const PathLinks links = link_path_ends(roads);
  const std::vector<LevelCrossing> levels = level_crossings(roads);

  Heights heights(unknowns);
  std::vector<HeightFit> fits(unknowns.components.size());
  std::vector<std::size_t> all(unknowns.components.size());
  for (std::size_t c = 0; c < all.size(); ++c) all[c] = c;
  solve_components(all, roads, unknowns, links, std::vector<std::vector<StructureLimit>>(all.size()), options, monitor, fits, heights);
  make_room(roads, unknowns, links, levels, options, fits, heights);

  for (std::size_t k = 0; k < roads.paths.size(); ++k)
    for (std::size_t n = 0; n < roads.paths[k].nodes.size(); ++n) {
      RoadNode& node = result.roads.paths[k].nodes[n];
      node.z_m = heights.z_m[unknowns.of_node[k][n]];
      node.sigma_z_m = heights.sigma_z_m[unknowns.of_node[k][n]];
      node.banking = 0.0;
      node.banking_source = "none";
    }
  set_gradients(result.roads, links);
  for (std::size_t c = 0; c < fits.size(); ++c) {
    result.solve.converged = result.solve.converged && fits[c].solve.converged;
    result.solve.iterations = std::max(result.solve.iterations, fits[c].solve.iterations);
    result.solve.cost_before += fits[c].solve.cost_before;
    result.solve.cost_after += fits[c].solve.cost_after;
    if (fits[c].solve.converged) continue;
    const RoadPath& path = roads.paths[unknowns.components[c].front()];
    result.findings.push_back({Severity::info, "elevate.not_converged",
                               fmt::format("way {} and {} more: no convergence after {} iterations", path.osm_id,
                                           unknowns.components[c].size() - 1, fits[c].solve.iterations),
                               path.nodes.front().p.x, path.nodes.front().p.y});
  }
  result.before = energy(roads, unknowns, unknowns.terrain_m);
  result.after = energy(roads, unknowns, heights.z_m);
  report_missing_terrain(roads, unknowns, result.findings);
  report_low_clearance(roads, levels, heights, options.clearance_m, result.findings);
  return result;
}

}  // namespace orthodrive

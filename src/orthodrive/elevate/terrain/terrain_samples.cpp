// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/elevate/terrain/terrain_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "orthodrive/core/error.hpp"
#include "orthodrive/core/parallel.hpp"
#include "orthodrive/model/roads/design_limits.hpp"
#include "orthodrive/model/roads/osm_node_id.hpp"

namespace orthodrive::elevate {
namespace {

constexpr double smallest_margin_m = 5.0;

std::vector<double> stations(const RoadPath& path) { return arc_lengths_m(centerline(path)); }

/// A road is a bench in a slope, anywhere between all cut and all fill: uniform within its half width times the slope,
/// where pixels are too coarse to show it. Where the land bends, the mean of a pixel differs from its centre by 1/24 of
/// the second difference from pixel to pixel.
double spread_m(const HeightGrid& dtm, Vec2 p, Vec2 left, double width_m) {
  constexpr double bend_share = 1.0 / 24.0, root_of_uniform = 0.57735;
  const double gsd_m = dtm.frame.gsd_m;
  const double a = sample_bilinear(dtm, p + gsd_m * left), b = sample_bilinear(dtm, p - gsd_m * left),
               z = sample_bilinear(dtm, p);
  if (std::isnan(a + b + z)) return 0.0;
  const double hidden = width_m > 0.0 ? std::clamp(gsd_m / width_m - 1.0, 0.0, 1.0) : 0.0;
  const double bench_m = root_of_uniform * hidden * 0.5 * width_m * (a - b) / (2.0 * gsd_m),
               bend_m = bend_share * (a - 2.0 * z + b);
  return std::hypot(bench_m, bend_m);
}

}  // namespace

TerrainSamples sample_terrain(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, HeightSampling sampling,
                              int threads) {
  TerrainSamples terrain;
  for (const HeightGrid& dtm : dtms) terrain.gsd_m.push_back(dtm.frame.gsd_m);
  terrain.of_node.resize(roads.paths.size());
  parallel_for(roads.paths.size(), threads, [&](std::size_t k) {
    const auto& nodes = roads.paths[k].nodes;
    auto& samples = terrain.of_node[k];
    samples.resize(nodes.size());
    const std::vector<Vec2> along = tangents(centerline(roads.paths[k]));
    for (std::size_t n = 0; n < nodes.size(); ++n)
      for (std::size_t d = 0; d < dtms.size() && std::isnan(samples[n].z_m); ++d)
        if (const double z_m = sample_height(dtms[d], nodes[n].p, sampling); std::isfinite(z_m))
          samples[n] = {z_m, static_cast<float>(spread_m(dtms[d], nodes[n].p, left_normal(along[n]), nodes[n].width_m)),
                        static_cast<std::uint8_t>(d), true};
  });
  for (const auto& samples : terrain.of_node)
    for (const TerrainSample& sample : samples)
      if (sample.is_road) terrain.coarsest_gsd_m = std::max(terrain.coarsest_gsd_m, terrain.gsd_m[sample.source]);
  if (terrain.coarsest_gsd_m == 0.0)
    throw OptionError("elevate: no terrain model has a height on any road, check that they cover the area");
  return terrain;
}

void leave_out_structures(const RoadNetwork& roads, const std::vector<Span>& spans, TerrainSamples& terrain) {
  const double margin_m = std::max(smallest_margin_m, terrain.coarsest_gsd_m);
  std::set<std::int64_t> ends;  // where bridges and tunnels end
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const RoadPath& path = roads.paths[k];
    if (!path.bridge && !path.tunnel) continue;
    for (TerrainSample& sample : terrain.of_node[k]) sample.is_road = false;
    for (const RoadNode* end : {&path.nodes.front(), &path.nodes.back()})
      if (is_osm_node(end->osm_node)) ends.insert(end->osm_node);
  }
  const auto leave_out = [&](std::size_t k, const std::vector<double>& s, double at_m, double half_m) {
    for (std::size_t n = 0; n < s.size(); ++n)
      if (std::abs(s[n] - at_m) <= half_m) terrain.of_node[k][n].is_road = false;
  };
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    std::vector<double> s;
    for (std::size_t n = 0; n < roads.paths[k].nodes.size(); ++n) {
      if (!ends.contains(roads.paths[k].nodes[n].osm_node)) continue;
      if (s.empty()) s = stations(roads.paths[k]);
      leave_out(k, s, s[n], margin_m);
    }
  }
  for (const Span& span : spans)
    leave_out(span.path, stations(roads.paths[span.path]), span.s_m, span.half_length_m + margin_m);
}

std::vector<std::vector<double>> start_heights(const RoadNetwork& roads, const TerrainSamples& terrain) {
  constexpr double cell_m = 50.0;  // one height a cell is enough to begin with
  struct Known {
    Vec2 p;
    double z_m;
  };
  std::map<std::pair<long, long>, Known> known_of_cell;
  for (std::size_t k = 0; k < roads.paths.size(); ++k)
    for (std::size_t n = 0; n < roads.paths[k].nodes.size(); ++n) {
      const Vec2 p = roads.paths[k].nodes[n].p;
      if (const double z_m = terrain.of_node[k][n].z_m; !std::isnan(z_m))
        known_of_cell.try_emplace({std::lround(p.x / cell_m), std::lround(p.y / cell_m)}, Known{p, z_m});
    }
  std::vector<std::vector<double>> start;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& samples = terrain.of_node[k];
    const std::vector<double> s = stations(roads.paths[k]);
    auto& z = start.emplace_back();
    std::vector<std::size_t> known;
    for (std::size_t n = 0; n < samples.size(); ++n)
      if (samples[n].is_road) known.push_back(n);
    for (std::size_t n = 0; n < samples.size() && known.empty(); ++n)  // a bridge alone: what is below it
      if (!std::isnan(samples[n].z_m)) known.push_back(n);
    if (known.empty()) {
      const Known* nearest = nullptr;
      const Vec2 p = roads.paths[k].nodes.front().p;
      for (const auto& [cell, candidate] : known_of_cell)
        if (!nearest || distance(candidate.p, p) < distance(nearest->p, p)) nearest = &candidate;
      z.assign(samples.size(), nearest->z_m);
      continue;
    }
    for (std::size_t n = 0, next = 0; n < samples.size(); ++n) {
      while (next < known.size() && known[next] < n) ++next;
      const std::size_t a = known[next > 0 ? next - 1 : 0], b = known[std::min(next, known.size() - 1)];
      const double f = s[b] > s[a] ? std::clamp((s[n] - s[a]) / (s[b] - s[a]), 0.0, 1.0) : 0.0;
      z.push_back(samples[n].is_road ? samples[n].z_m : samples[a].z_m + (samples[b].z_m - samples[a].z_m) * f);
    }
  }
  return start;
}

namespace {

/// Share of the length of roads that is steeper than its class allows, were the heights divided by `divisor`. Over at
/// least two pixels and 20 m, so that noise does not count.
double steep_share(const RoadNetwork& roads, const TerrainSamples& terrain, double divisor) {
  const double base_m = std::max(20.0, 2.0 * terrain.coarsest_gsd_m);
  double steep_m = 0.0, all_m = 0.0;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const double limit = design_limits(roads.paths[k].highway).gradient;
    const std::vector<double> s = stations(roads.paths[k]);
    const auto& samples = terrain.of_node[k];
    for (std::size_t a = 0, b = 0; b < s.size(); ++b) {
      if (s[b] - s[a] < base_m) continue;
      const double run_m = s[b] - s[a], rise_m = (samples[b].z_m - samples[a].z_m) / divisor;
      if (samples[a].is_road && samples[b].is_road) {
        all_m += run_m;
        if (std::abs(rise_m) > limit * run_m) steep_m += run_m;
      }
      a = b;
    }
  }
  return all_m > 0.0 ? steep_m / all_m : 0.0;
}

}  // namespace

void report_terrain(const RoadNetwork& roads, const TerrainSamples& terrain, Findings& findings) {
  // The shore of the Dead Sea and above the highest road, with a margin for geoid heights.
  constexpr double lowest_m = -550.0, highest_m = 6500.0, feet_per_m = 3.28084;
  double low_m = INFINITY, high_m = -INFINITY;
  Vec2 low_p, high_p;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& samples = terrain.of_node[k];
    std::size_t missing = 0, first = 0;
    for (std::size_t n = samples.size(); n-- > 0;) {
      const double z_m = samples[n].z_m;
      if (std::isnan(z_m)) ++missing, first = n;
      if (z_m < low_m) low_m = z_m, low_p = roads.paths[k].nodes[n].p;
      if (z_m > high_m) high_m = z_m, high_p = roads.paths[k].nodes[n].p;
    }
    if (missing == 0) continue;
    const Vec2 p = roads.paths[k].nodes[first].p;
    findings.push_back({Severity::warning, "elevate.no_terrain",
                        fmt::format("way {}: no terrain height at {} of {} nodes, heights continue those beside",
                                    roads.paths[k].osm_id, missing, samples.size()),
                        p.x, p.y});
  }
  if (low_m < lowest_m || high_m > highest_m) {
    const Vec2 p = low_m < lowest_m ? low_p : high_p;
    findings.push_back(
        {Severity::warning, "elevate.implausible_terrain",
         fmt::format("terrain heights on roads go from {:.0f} to {:.0f} m, no road of the earth lies there; taken for "
                     "metres as they are, check the unit and the nodata value of the terrain model",
                     low_m, high_m),
         p.x, p.y});
  }
  const double steep = steep_share(roads, terrain, 1.0), steep_in_feet = steep_share(roads, terrain, feet_per_m);
  // Hilly towns have 2 % of such roads (Kvarnbyn), 22 % were their heights feet.
  if (steep > 0.08 && steep_in_feet < 0.2 * steep)
    findings.push_back(
        {Severity::warning, "elevate.implausible_terrain",
         fmt::format("{:.0f} % of the roads are steeper than their class allows, {:.0f} % would be if the terrain's "
                     "heights were feet; taken for metres as they are, check the unit of the terrain model",
                     100.0 * steep, 100.0 * steep_in_feet),
         high_p.x, high_p.y});
}

}  // namespace orthodrive::elevate

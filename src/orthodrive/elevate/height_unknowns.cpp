#include "orthodrive/elevate/height_unknowns.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "orthodrive/core/error.hpp"

namespace orthodrive {
namespace {

/// Terrain models are bare earth: the abutment of a bridge and the portal of a tunnel are smeared over about a pixel.
constexpr double smallest_margin_m = 5.0;

void number_unknowns(const RoadNetwork& roads, HeightUnknowns& unknowns) {
  std::map<std::int64_t, std::size_t> of_osm_node;
  for (const RoadPath& path : roads.paths) {
    auto& indices = unknowns.of_node.emplace_back();
    for (const RoadNode& node : path.nodes) {
      std::size_t index = unknowns.p.size();
      if (node.osm_node > 0) index = of_osm_node.try_emplace(node.osm_node, index).first->second;
      if (index == unknowns.p.size()) unknowns.p.push_back(node.p);
      indices.push_back(index);
    }
  }
}

void sample_terrain(const std::vector<HeightGrid>& dtms, HeightSampling sampling, HeightUnknowns& unknowns) {
  unknowns.terrain_m.assign(unknowns.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const HeightGrid& dtm : dtms) {
      unknowns.terrain_m[i] = sample_height(dtm, unknowns.p[i], sampling);
      if (std::isnan(unknowns.terrain_m[i])) continue;
      unknowns.coarsest_gsd_m = std::max(unknowns.coarsest_gsd_m, dtm.frame.gsd_m);
      break;
    }
  if (std::all_of(unknowns.terrain_m.begin(), unknowns.terrain_m.end(), [](double z) { return std::isnan(z); }))
    throw OptionError("elevate: no terrain model has a height on any road, check that they cover the area");
}

/// Not on bridges, not in tunnels, and not within a margin of their ends.
void mark_measured(const RoadNetwork& roads, HeightUnknowns& unknowns) {
  unknowns.measured.resize(unknowns.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) unknowns.measured[i] = !std::isnan(unknowns.terrain_m[i]);
  const double margin_m = std::max(smallest_margin_m, unknowns.coarsest_gsd_m);
  std::set<std::size_t> structure_ends;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    if (!roads.paths[k].bridge && !roads.paths[k].tunnel) continue;
    for (const std::size_t i : unknowns.of_node[k]) unknowns.measured[i] = false;
    structure_ends.insert({unknowns.of_node[k].front(), unknowns.of_node[k].back()});
  }
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& indices = unknowns.of_node[k];
    const std::vector<double> s = arc_lengths_m(centerline(roads.paths[k]));
    for (std::size_t end = 0; end < indices.size(); ++end) {
      if (!structure_ends.contains(indices[end])) continue;
      for (std::size_t i = 0; i < indices.size(); ++i)
        if (std::abs(s[i] - s[end]) <= margin_m) unknowns.measured[indices[i]] = false;
    }
  }
}

void find_components(const RoadNetwork& roads, HeightUnknowns& unknowns) {
  std::vector<std::size_t> leader(unknowns.size());
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (leader[i] != i) i = leader[i] = leader[leader[i]];
    return i;
  };
  for (const auto& indices : unknowns.of_node)
    for (const std::size_t i : indices) {
      const std::size_t a = find(i), b = find(indices.front());
      leader[std::max(a, b)] = std::min(a, b);
    }
  std::map<std::size_t, std::vector<std::size_t>> groups;
  for (std::size_t k = 0; k < roads.paths.size(); ++k) groups[find(unknowns.of_node[k].front())].push_back(k);
  for (auto& [first, paths] : groups) unknowns.components.push_back(std::move(paths));
}

/// Heights to start from: linear along the path between measured nodes; where a path has none, the nearest measured
/// height of the network.
void fill_start(const RoadNetwork& roads, HeightUnknowns& unknowns) {
  const double unset = std::numeric_limits<double>::quiet_NaN();
  unknowns.start_m.assign(unknowns.size(), unset);
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    if (unknowns.measured[i]) unknowns.start_m[i] = unknowns.terrain_m[i];
  for (std::size_t k = 0; k < roads.paths.size(); ++k) {
    const auto& indices = unknowns.of_node[k];
    const std::vector<double> s = arc_lengths_m(centerline(roads.paths[k]));
    std::vector<std::size_t> known;
    for (std::size_t n = 0; n < indices.size(); ++n)
      if (unknowns.measured[indices[n]]) known.push_back(n);
    for (std::size_t n = 0, next = 0; n < indices.size() && !known.empty(); ++n) {
      while (next < known.size() && known[next] < n) ++next;
      if (!std::isnan(unknowns.start_m[indices[n]])) continue;
      const std::size_t a = known[next > 0 ? next - 1 : 0], b = known[std::min(next, known.size() - 1)];
      const double f = s[b] > s[a] ? (s[n] - s[a]) / (s[b] - s[a]) : 0.0;
      unknowns.start_m[indices[n]] =
          unknowns.terrain_m[indices[a]] + (unknowns.terrain_m[indices[b]] - unknowns.terrain_m[indices[a]]) * std::clamp(f, 0.0, 1.0);
    }
  }
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    if (!std::isnan(unknowns.start_m[i])) continue;
    double nearest_m = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      if (std::isnan(unknowns.terrain_m[k])) continue;
      const double d = distance(unknowns.p[i], unknowns.p[k]);
      if (d < nearest_m) nearest_m = d, unknowns.start_m[i] = unknowns.terrain_m[k];
    }
  }
}

}  // namespace

HeightUnknowns gather_height_unknowns(const RoadNetwork& roads, const std::vector<HeightGrid>& dtms, HeightSampling sampling) {
  HeightUnknowns unknowns;
  number_unknowns(roads, unknowns);
  sample_terrain(dtms, sampling, unknowns);
  mark_measured(roads, unknowns);
  find_components(roads, unknowns);
  fill_start(roads, unknowns);
  return unknowns;
}

}  // namespace orthodrive

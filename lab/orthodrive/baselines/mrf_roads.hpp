// SPDX-License-Identifier: Apache-2.0
#pragma once
// The baseline: Mattyus et al., Enhancing Road Maps by Parsing Aerial Images around the World, 2015, with the terms
// that the reference used (thesis sec. 3.2): road and context forests, image edges, smoothness, no overlap of parallel
// roads.

#include <vector>

#include "orthodrive/baselines/mrf_evidence.hpp"
#include "orthodrive/baselines/mrf_model.hpp"
#include "orthodrive/core/finding.hpp"
#include "orthodrive/core/monitor.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive {

enum class RoadPolygons { douglas_peucker, smooth };

struct MrfRoadsOptions {
  double segment_m = 10.0;        ///< length of the straight segments, about
  double search_radius_m = 6.0;   ///< largest offset to each side of the OSM line
  double step_m = 0.25;           ///< between offsets; widths differ by twice that
  double min_width_factor = 0.5;  ///< bounds of the width, times the input's width
  double max_width_factor = 1.8;
  MrfWeights weights;
  double no_overlap_angle_deg = 20.0;
  int max_sweeps = 30;
  RoadPolygons polygons = RoadPolygons::smooth;
  double simplify_m = 0.5;  ///< tolerance of Douglas-Peucker
  int threads = 0;          ///< 0 = all cores; the result does not depend on it
};

struct MrfRoadsResult {
  RoadNetwork roads;  ///< the input's paths with a node every segment_m; p, osm_node, s_m, offset_m, width_m are set
  std::vector<MultiPolygon>
      surfaces;                ///< of each path as the chosen method draws it, before roads are joined at junctions
  double energy_before = 0.0;  ///< at OSM's lines
  double energy_after = 0.0;
  std::vector<double> energies;  ///< before, and after every sweep
  int sweeps = 0;
  bool converged = true;
  Findings findings;  ///< "refine.no_photo", "refine.no_length", "refine.not_converged"
};

/// `osm` and the evidence share one CRS (throws OptionError, as for options out of range and ways without nodes or
/// width). Where there is no evidence (nodata, tunnels, mouths of other roads) a road runs on from its neighbours
/// towards OSM. Reads the evidence once, around the roads only; time and memory are linear in their length.
[[nodiscard]] MrfRoadsResult refine_roads_mrf(const RoadNetwork& osm, const MrfEvidenceSource& evidence,
                                              const MrfRoadsOptions& options = {}, Monitor* monitor = nullptr);

/// The same in two steps, to try many weights on one photo: reading the photo takes nearly all of the time.
struct MrfRoadsProblem {
  RoadNetwork osm;
  std::vector<RoadChain> chains;
  MrfProblem mrf;  ///< one chain of sites a RoadChain, one site between two of its nodes
  Findings findings;
};
[[nodiscard]] MrfRoadsProblem prepare_mrf_roads(const RoadNetwork& osm, const MrfEvidenceSource& evidence,
                                                const MrfRoadsOptions& options = {}, Monitor* monitor = nullptr);
/// Of the options only weights, max_sweeps, polygons, simplify_m and threads may differ from those prepared with.
[[nodiscard]] MrfRoadsResult solve_mrf_roads(const MrfRoadsProblem& problem, const MrfRoadsOptions& options = {},
                                             Monitor* monitor = nullptr);

}  // namespace orthodrive

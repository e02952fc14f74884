// SPDX-License-Identifier: Apache-2.0
#pragma once
// A site around a real race track: its surveyed edges, its OSM way, heights along it.

#include <cstdint>
#include <string>
#include <vector>

#include "orthodrive/model/roads/osm_data.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"
#include "orthodrive/synth/plan/track_table.hpp"

namespace orthodrive::synth {

struct TrackSources {
  std::vector<TrackRow> rows;  ///< EPSG:32633
  std::string file;            ///< that they are from, for messages
  OsmData osm;                 ///< EPSG:32633, may be empty: OSM is then the truth, disturbed
  std::string osm_file;
  std::vector<Vec3> heights;  ///< EPSG:32633, may be empty: hills are then made up
  std::string heights_file;
};

/// The carriageway lies exactly between the given edges: road 0 is a cubic spline through the middles of both edges,
/// its width a cubic spline over its length. Drivable OSM ways within 25 m of the track must close to one loop; they
/// are kept as they are (others are left out), the truth has their ids and direction. Verges, run-off areas, stands
/// and woods are made up by seed. `size_m` 0: a site as large as the track and 120 m round it. Else that large, with
/// the country of plan_country.hpp round the track, for make_region(). Throws InputError naming the file; OptionError
/// for a size too small or large.
[[nodiscard]] SitePlan plan_from_track(const TrackSources& sources, std::uint64_t seed, double size_m = 0.0);

/// The given edges, a point a row, in the CRS of the rows: across the periodic cubic spline through them.
struct TrackEdges {
  std::vector<Vec2> left, right;
};
[[nodiscard]] TrackEdges track_edges(const std::vector<TrackRow>& rows);

/// How a finished site keeps to the track that it was made from.
struct TrackErrors {
  double lap_m = 0.0;                                             ///< of the true centre lines
  double edge_mean_m = 0.0, edge_p95_m = 0.0, edge_most_m = 0.0;  ///< from given edges to the nearer true edge
};
/// Measured on the true roads as they are written, nodes a metre apart. A network without roads gives zeros.
[[nodiscard]] TrackErrors measure_track(const std::vector<TrackRow>& rows, const RoadNetwork& truth);

}  // namespace orthodrive::synth

// SPDX-License-Identifier: Apache-2.0
#pragma once
// The outer borders of all roads on the ground, as 3D line segments: where the terrain meets them.

#include <cstdint>
#include <optional>
#include <vector>

#include "roadquery/query/road_query.hpp"

namespace roadquery {

/// Nearest point of the roads' outer borders.
struct NearestBorder {
  double distance_m = 0.0;
  double x = 0.0, y = 0.0, z = 0.0;
  double dz_dx = 0.0, dz_dy = 0.0;  ///< of z as the asking point moves
};

/// Chords of the edges and ends of all roads but bridges and tunnels, at most 1 m long and 2 mm off. What another road
/// goes on beyond is no border. Heights are those that the query gives just inside.
class RoadBorders {
 public:
  /// Finds borders up to `reach_m` away.
  RoadBorders(const RoadQuery& query, double reach_m);
  /// Nothing when no border is within reach_m. Does not allocate.
  [[nodiscard]] std::optional<NearestBorder> nearest(double x, double y) const;
  [[nodiscard]] std::size_t segments() const { return segments_.size(); }

 private:
  struct Segment {
    double x0 = 0.0, y0 = 0.0, z0 = 0.0, x1 = 0.0, y1 = 0.0, z1 = 0.0;
  };
  void add_edges(const RoadQuery& query, int road);
  void add_ends(const RoadQuery& query, int road);
  void add(const RoadQuery& query, int road, Segment segment, double out_x, double out_y);
  void fill_grid();

  double reach_m_ = 0.0;
  std::vector<Segment> segments_;
  // Segments that touch cell (column, row) are cell_segments_[cell_begin_[i] .. cell_begin_[i + 1]).
  double west_ = 0.0, south_ = 0.0, cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint32_t> cell_begin_, cell_segments_;
};

}  // namespace roadquery

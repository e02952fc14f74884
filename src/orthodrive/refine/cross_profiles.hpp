// SPDX-License-Identifier: Apache-2.0
#pragma once
// The evidence straightened along a chain: class costs as functions of the lateral position t, one row a station.
// All later work (search, residuals, derivatives) reads these rows and never the rasters.

#include <cstddef>
#include <span>
#include <vector>

#include "orthodrive/model/rasters/rasters.hpp"
#include "orthodrive/roads/road_chains.hpp"

namespace orthodrive::refine {

constexpr std::size_t rows_per_segment = 2;  ///< stations at 1/4 and 3/4 of a segment

/// Costs are constant in cells of step_m; cell k spans t = (k .. k + 1) * step_m - half_m. Left of the path is t > 0.
struct CrossProfiles {
  double step_m = 0.0, half_m = 0.0;
  int cells = 0;                             ///< a row
  std::vector<float> false_positive;         ///< cost of the cell outside the road, row after row
  std::vector<float> false_negative;         ///< cost of the cell inside the road
  std::vector<EdgeEvidence> chain_evidence;  ///< one per row: how much the chain lets it count
  std::vector<EdgeEvidence> evidence;        ///< the same, 0 where no road is near
  std::vector<bool> road_near;               ///< one per row: the labels show a road somewhere in the row

  /// Sets road_near and evidence of a row by its costs.
  void look_again(std::size_t row);

  [[nodiscard]] std::span<const float> positive_row(std::size_t row) const {
    return std::span(false_positive).subspan(row * static_cast<std::size_t>(cells), static_cast<std::size_t>(cells));
  }
  [[nodiscard]] std::span<const float> negative_row(std::size_t row) const {
    return std::span(false_negative).subspan(row * static_cast<std::size_t>(cells), static_cast<std::size_t>(cells));
  }
};

/// Looks half_m to each side, bilinear between pixel centres. Places outside the evidence cost nothing.
[[nodiscard]] CrossProfiles sample_cross_profiles(const RoadChain& chain, const RoadEvidence& evidence, double half_m);

/// The classification cost of the four strips of a road with its edges at t, eq. 3.3 of the reference: mean class cost
/// weighted by the distance from the edge, as a smooth function of the edge position.
class StripCosts {
 public:
  StripCosts(const CrossProfiles& profiles, double strip_m);

  enum class Edge { left, right };
  struct Value {
    double cost = 0.0, derivative = 0.0;  ///< derivative by t, 1/m
  };
  /// Of the strip outside an edge and of that inside.
  struct Values {
    Value context, boundary;
  };
  /// t, of the edge, is clamped to where the strips are inside the profile.
  [[nodiscard]] Values at(Edge edge, std::size_t row, double t_m) const;

 private:
  double steps_per_m_, half_m_;
  int knots_;
  struct Knot {
    float context, boundary;
  };
  std::vector<Knot> knots_of_edge_[2];
};

}  // namespace orthodrive::refine

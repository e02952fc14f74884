#pragma once
// Cross-fall along one chain from terrain pixels across it: one banded least-squares problem.

#include <vector>

#include "orthodrive/elevate/cross_fall.hpp"
#include "orthodrive/elevate/design_cross_fall.hpp"
#include "orthodrive/elevate/terrain_across.hpp"

namespace orthodrive {

/// At this station the surface is that of a higher ranked road, or the plane that the roads of a junction have in
/// common.
struct CrossFallAnchor {
  std::size_t station = 0;
  double slope = 0.0;
  bool is_main = false;  ///< the most important road of the junction: it keeps its crown, and turns no faster there
};

/// A plane of a junction is reached over so much road: 5 % at the relative gradient of 0.65 % for 50 km/h, over half a
/// street of 5 - 6 m.
inline constexpr double cross_fall_runout_m = 20.0;

enum class CrossFallSource : std::int8_t { none, dtm, interpolated, design };

struct CrossFallFit {
  std::vector<double> slope, crown, sigma_slope;  ///< [station]; tangents; slope positive = left side higher
  std::vector<CrossFallSource> source;
};

[[nodiscard]] CrossFallFit fit_cross_fall(const StationChain& chain, const std::vector<AcrossSample>& samples,
                                          const DesignCrossFall& design, const std::vector<CrossFallAnchor>& anchors,
                                          const CrossFallOptions& options);

}  // namespace orthodrive

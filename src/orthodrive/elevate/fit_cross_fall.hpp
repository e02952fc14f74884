#pragma once
// Cross-fall along one chain from terrain pixels across it: one banded least-squares problem.

#include <vector>

#include "orthodrive/elevate/cross_fall.hpp"
#include "orthodrive/elevate/design_cross_fall.hpp"
#include "orthodrive/elevate/terrain_across.hpp"

namespace orthodrive {

/// At this station the surface is the plane of a higher ranked road.
struct CrossFallAnchor {
  std::size_t station = 0;
  double slope = 0.0;
};

enum class CrossFallSource : std::int8_t { none, dtm, interpolated, design };

struct CrossFallFit {
  std::vector<double> slope, crown, sigma_slope;  ///< [station]; tangents; slope positive = left side higher
  std::vector<CrossFallSource> source;
};

[[nodiscard]] CrossFallFit fit_cross_fall(const StationChain& chain, const std::vector<AcrossSample>& samples,
                                          const DesignCrossFall& design, const std::vector<CrossFallAnchor>& anchors,
                                          const CrossFallOptions& options);

}  // namespace orthodrive

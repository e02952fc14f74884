#pragma once
// The nonlinear least-squares fit of the heights of a component of the network.

#include <utility>
#include <vector>

#include "orthodrive/elevate/height_unknowns.hpp"
#include "orthodrive/model/path_links.hpp"

namespace orthodrive {

/// At `fraction` between two of its unknowns a bridge should lie at or above `z_m`, a tunnel at or below it.
struct StructureLimit {
  enum class Side { above, below };
  std::size_t before = 0, after = 0;
  double fraction = 0.0, z_m = 0.0;
  Side side = Side::above;
};

struct HeightFit {
  std::vector<std::size_t> unknowns;  ///< of the component, ascending
  std::vector<double> z_m, sigma_z_m; ///< in that order
  SolveSummary solve;
};

/// Levenberg-Marquardt over the paths of one component. Unmeasured unknowns have no terrain residual; a component without
/// any measured one is held at its start heights.
[[nodiscard]] HeightFit fit_heights(const RoadNetwork& roads, const HeightUnknowns& unknowns, const std::vector<std::size_t>& paths,
                                    const PathLinks& links, const std::vector<StructureLimit>& limits, const ElevateOptions& options);

}  // namespace orthodrive

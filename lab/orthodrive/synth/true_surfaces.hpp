// SPDX-License-Identifier: Apache-2.0
#pragma once
// The true carriageways and how much of them the photo shows.

#include "orthodrive/synth/make_site.hpp"

namespace orthodrive::synth {

/// A carriageway a path, visibility not yet counted.
[[nodiscard]] std::vector<SynthSurface> true_surfaces(const RoadNetwork& roads);

/// Pixels of one carriageway, summed over as many windows as there are.
struct SeenPixels {
  std::int64_t all = 0, visible = 0;
  /// Those whose class has the role of a road are seen.
  void count(const Polygon& carriageway, const Raster<std::uint8_t>& labels, const GridFrame& frame,
             const ClassTable& classes);
  [[nodiscard]] double share() const { return all > 0 ? static_cast<double>(visible) / static_cast<double>(all) : 1.0; }
};

}  // namespace orthodrive::synth

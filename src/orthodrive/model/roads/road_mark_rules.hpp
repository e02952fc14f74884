// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a country paints the lines along its roads.

#include <string>
#include <vector>

namespace orthodrive {

/// Strokes of the broken lines of roads up to a speed limit.
struct StrokeRule {
  double to_kmh = 0.0;
  double stroke_m = 0.0, gap_m = 0.0;
};

/// Of one country; colours as OpenDRIVE names them (1.8.1, e_roadMarkColor).
struct RoadMarkRule {
  std::string country;                          ///< ISO 3166-1
  std::string between_directions = "standard";  ///< colour of what parts opposite directions
  std::string inner_edge = "standard";          ///< of the edge on the side of the oncoming traffic of one-way roads
  bool is_solid_centre_double = false;          ///< a solid line between opposite directions is two lines
  /// By speed, slowest first; the last one counts for what is faster. Empty: nothing is written out.
  std::vector<StrokeRule> strokes;
};

struct RoadMarkRules {
  std::vector<RoadMarkRule> rules;  ///< any order
  std::string here;                 ///< country of the roads, ISO 3166-1 or -2; empty: not known
};

/// The rule of `here`, or of its country where it is a part of one. Where there is none, the default: white lines.
[[nodiscard]] RoadMarkRule rule_here(const RoadMarkRules& rules);

}  // namespace orthodrive

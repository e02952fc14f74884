// SPDX-License-Identifier: Apache-2.0
#pragma once
// Banking as roads are designed, for where nothing can be measured.
//
// Sources. Crown and banking of straights 2.5 %: RASt 06 and RAL 2012. Curves ("superelevation" e in the literature):
// AASHTO, A Policy on Geometric Design of Highways and Streets (Green Book), 2011, sec. 3.3: e + f = v^2 / (127 R),
// side friction f by design speed (table 3-7), method 5 on highways (sec. 3.3.4, eqs. of "method 5 procedure for
// development"), method 2 on low-speed streets; transitions no steeper than the maximum relative gradient of the edge
// (table 3-15). Largest rates: RAL 2012 7 %, RASt 06 6 %.

#include <string>
#include <vector>

#include "orthodrive/elevate/terrain/chain_stations.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"

namespace orthodrive::elevate {

/// How a class of roads is banked in curves.
struct CurveRule {
  double design_speed_kmh = 50.0;
  double largest = 0.06;        ///< e_max
  bool friction_first = false;  ///< method 2: no banking until side friction is used up; else method 5
};
[[nodiscard]] CurveRule curve_rule(const std::string& highway);

/// e (a slope, >= 0) for a curve of this curvature (1/m, either sign); e_max where the curve is too sharp for the
/// speed.
[[nodiscard]] double curve_banking(const CurveRule& rule, double curvature_1pm);

struct DesignBanking {
  std::vector<double> slope, crown;  ///< [station], tangents of the angles; slope positive = left side higher
};
/// Straights have a crown; one-way carriageways fall to their outer edge (to the right where traffic keeps right),
/// roundabouts to the outside. Curves that need 1.5 % or more are planes that fall to the inside by 2.5 % or more; in
/// the transition the outer half turns first (crown = 2.5 % - |slope|). Raceways have no design.
[[nodiscard]] DesignBanking design_banking(const RoadNetwork& roads, const StationChain& chain, double crown,
                                           DrivingSide driving_side);

}  // namespace orthodrive::elevate

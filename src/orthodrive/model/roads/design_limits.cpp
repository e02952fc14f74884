// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/model/roads/design_limits.hpp"

#include <algorithm>
#include <array>

namespace orthodrive {
namespace {

struct ClassLimits {
  const char* highway;
  DesignLimits limits;
};
// Speeds, km/h: the least that the guideline which the radii are from asks of the class. Outside towns roads are mostly
// faster (RAL 2012, table 7: 70 to 110), which OSM's class does not tell; secondary roads get a value between the two.
// Radii, crest and sag:
//  motorways   RAA 2008, EKA 3 (urban motorways, 80 km/h), the least of any motorway; links: its ramps at 50 km/h
//  primary     RASt 06, main roads without frontage, 70 km/h
//  secondary, tertiary   RASt 06, main roads with frontage, 50 km/h: outside towns roads are mostly gentler (RAL 2012:
//              2000 m and more)
//  raceway     FIA Appendix O, 7.3: R = V^2 / 20 (crest), V^2 / 15 (sag), at 100 km/h, as for slow corners
//  the others  RASt 06, access roads, which allow a sag of 20 m; as tight as crests here, because a car's chassis asks
//              for it
// Gradients: RAA 6 % and AASHTO 2011, tables 3-2, 5-2, 6-2, 7-2 and 8-1 for mountains; access roads 15 %
// (AASHTO 5.3.2). Driveways, farm tracks and race tracks have no standard: what cars still climb in winter, and the
// steepest tracks.
constexpr std::array limits_of_classes{ClassLimits{"motorway", {100.0, 0.06, 3000.0, 2600.0}},
                                       ClassLimits{"motorway_link", {50.0, 0.08, 1500.0, 750.0}},
                                       ClassLimits{"trunk", {80.0, 0.07, 3000.0, 2600.0}},
                                       ClassLimits{"trunk_link", {50.0, 0.08, 1500.0, 750.0}},
                                       ClassLimits{"primary", {70.0, 0.10, 2200.0, 1200.0}},
                                       ClassLimits{"primary_link", {50.0, 0.10, 250.0, 150.0}},
                                       ClassLimits{"secondary", {60.0, 0.12, 250.0, 150.0}},
                                       ClassLimits{"secondary_link", {50.0, 0.12, 250.0, 150.0}},
                                       ClassLimits{"tertiary", {50.0, 0.12, 250.0, 150.0}},
                                       ClassLimits{"tertiary_link", {50.0, 0.12, 250.0, 150.0}},
                                       ClassLimits{"raceway", {100.0, 0.20, 500.0, 667.0}},
                                       ClassLimits{"unclassified", {40.0, 0.15, 50.0, 50.0}},
                                       ClassLimits{"residential", {30.0, 0.15, 50.0, 50.0, true}},
                                       ClassLimits{"road", {30.0, 0.15, 50.0, 50.0}},
                                       ClassLimits{"living_street", {20.0, 0.15, 50.0, 50.0, true}},
                                       ClassLimits{"service", {20.0, 0.20, 50.0, 50.0, true}},
                                       ClassLimits{"track", {20.0, 0.25, 50.0, 50.0, true}}};
constexpr DesignLimits of_unknown{20.0, 0.20, 50.0, 50.0, true};

}  // namespace

DesignLimits design_limits(const std::string& highway) {
  const auto it = std::find_if(limits_of_classes.begin(), limits_of_classes.end(),
                               [&](const ClassLimits& c) { return highway == c.highway; });
  return it == limits_of_classes.end() ? of_unknown : it->limits;
}

double comfortable_curvature_1pm(double design_speed_kmh) {
  const double speed_mps = design_speed_kmh / 3.6;
  return 0.3 / (speed_mps * speed_mps);
}

double vertical_curve_length_m(double design_speed_kmh) { return 0.6 * design_speed_kmh; }

}  // namespace orthodrive

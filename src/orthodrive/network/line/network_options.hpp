// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a road network is built.

#include <string>

#include "orthodrive/core/shared_loop.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_mark_rules.hpp"
#include "orthodrive/model/roads/road_material.hpp"
#include "orthodrive/model/roads/speed_laws.hpp"

namespace orthodrive {

struct BuildNetworkOptions {
  std::string name = "orthodrive";  ///< header/@name
  /// Largest distance of a node from the reference line. Refined lines are uncertain by some decimetres; following them
  /// more closely turns their noise into curvature.
  double plan_tolerance_m = 0.10;
  double elevation_tolerance_m = 0.02;   ///< largest height error at a node
  double banking_tolerance_rad = 0.002;  ///< largest superelevation error at a node
  double width_tolerance_m = 0.05;       ///< largest error of the carriageway width at a node
  /// Heights change by no more for the sake of fewer entries of crown and superelevation.
  double shape_tolerance_m = 0.0048;
  DrivingSide driving_side = DrivingSide::right;
  Weather weather = Weather::dry;    ///< what the friction of the lanes is for
  SpeedLaws speed_laws;              ///< for roads whose limit no sign tells
  RoadMarkRules road_marks;          ///< how lines along roads are painted
  bool junction_surfaces = true;     ///< one surface for the paved area of each junction
  int threads = 0;                   ///< 0 = all cores; the result does not depend on it
  LoopExchange* exchange = nullptr;  ///< with other processes that build the same network; nor on it
};

}  // namespace orthodrive

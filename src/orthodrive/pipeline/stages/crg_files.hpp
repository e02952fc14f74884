// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenCRG files of chosen roads of a network, beside its OpenDRIVE file.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "orthodrive/model/roads/crg_geometry.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive {

struct CrgFilesOptions {
  /// Each as choose_roads() takes it, "all-of-route" (the roads of `route`) or "all".
  std::vector<std::string> roads;
  std::string route = "auto";  ///< as RouteOptions::route
  CrgFormat format = CrgFormat::krbi;
  double u_step_m = 0.5, v_step_m = 0.1;
  /// Height to add at (s, t) of a road; none, or an empty function for a road: the surface alone.
  std::function<std::function<double(double s, double t)>(const roadquery::Road&)> relief_of;
  /// Also road_ID_friction.crg: a grid of the road's friction, referred to with purpose "friction".
  bool friction = false;
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
};

struct CrgFilesResult {
  int files = 0;  ///< of heights
  double length_m = 0.0;
};

/// "NAME_crg" for roads in NAME.xodr.
[[nodiscard]] std::filesystem::path crg_folder(const std::filesystem::path& xodr);

/// Writes road_ID.crg for every chosen road into crg_folder(xodr), which it replaces, and refers to them in the map;
/// the caller writes the map. Nothing chosen: nothing happens. Throws OptionError for roads, ways and routes that are
/// not in the map and Error for files that cannot be written.
CrgFilesResult write_crg_files(roadquery::RoadMap& map, const std::filesystem::path& xodr,
                               const CrgFilesOptions& options);

/// "LRFI" and so on, upper or lower case. Throws OptionError for others.
[[nodiscard]] CrgFormat crg_format_of(const std::string& name);

}  // namespace orthodrive

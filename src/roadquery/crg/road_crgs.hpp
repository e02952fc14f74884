// SPDX-License-Identifier: Apache-2.0
#pragma once
// OpenCRG surfaces laid on the roads of a map, as OpenDRIVE says (1.7, 10.6; formulas in 1.9, 10.6.1).

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "roadquery/crg/crg_grid.hpp"
#include "roadquery/map/road_map.hpp"

namespace roadquery {

/// A place of a road, for what is laid on it.
struct RoadPlace {
  double s = 0.0, t = 0.0, x = 0.0, y = 0.0;
  double cos_hdg = 1.0, sin_hdg = 0.0;         ///< of the reference line at s
  double s_per_along = 1.0, t_per_left = 1.0;  ///< ds and dt per metre along that heading and to its left in plan
  double s_per_left = 0.0, t_per_along = 0.0;
};

/// The surface at a place: height, and how it rises per metre along the reference line's heading and to its left.
struct LaidSurface {
  double z = 0.0, rise_along = 0.0, rise_left = 0.0;
  double friction = 1.0;
};

/// With (u, v) = (s - sOffset, t - tOffset), or minus that for orientation "opposite":
///   attached   z = road's z + zScale grid(u, v) + zOffset; the file's reference line, slope and banking do not count
///   attached0  z = zScale height(u, v) + zOffset, the file's whole height
///   genuine    z = zScale height(x, y) + zOffset, the file's reference line put to (sOffset, tOffset) of the road and
///              turned by the road's heading there + hOffset
///   global     likewise at (xOffset, yOffset), turned by hOffset
/// Purpose "friction" gives the friction instead of z, without zScale and zOffset. A reference counts from sStart to
/// sEnd. Where a file defines no height (border mode 0, missing values that stay missing) the road stays as it is.
/// References of one road: those that replace first, then those that add, each in the order of the file.
class RoadCrgs {
 public:
  RoadCrgs() = default;
  /// Reads every file that a road refers to, once; names are relative to `folder`. Throws std::runtime_error
  /// "road 12: file: what" for files that are not there or damaged and for references that say nothing known.
  RoadCrgs(const RoadMap& map, const std::string& folder);

  [[nodiscard]] bool empty() const { return layers_.empty(); }
  /// Whether anything is laid on the road of this index.
  [[nodiscard]] bool on(int road) const {
    const auto i = static_cast<std::size_t>(road);
    return i + 1 < first_layer_.size() && first_layer_[i] != first_layer_[i + 1];
  }
  /// Lays the road's files over its own surface. About 30 ns a file.
  void lay(int road, const RoadPlace& place, LaidSurface& surface) const;

  /// What was read but not taken as it stands, each one line.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  enum class Mode { attached, attached0, genuine, global };
  struct Layer {
    std::shared_ptr<const CrgGrid> grid;
    Mode mode = Mode::genuine;
    bool is_friction = false;
    double s_start = 0.0, s_end = 0.0, s_offset = 0.0, t_offset = 0.0;
    double sign = 1.0;  ///< of u with s, and of v with t
    double z_offset = 0.0, z_scale = 1.0;
    // Of the modes genuine and global: (x, y) of the map less `from`, turned back, plus `to` is the file's.
    double cos_turn = 1.0, sin_turn = 0.0, from_x = 0.0, from_y = 0.0, to_x = 0.0, to_y = 0.0;
    double s_start_of_knots = 0.0, knots_per_s = 0.0;
    std::vector<float> u_of_knot;  ///< where along the file, from its start, the road's reference line runs
  };
  struct Height {
    double z, along, left;
  };
  void add(const Road& road, const SurfaceCrg& reference, const std::shared_ptr<const CrgGrid>& grid);
  void place_line(Layer& layer, const Road& road, const SurfaceCrg& reference);
  [[nodiscard]] static Height by_st(const Layer& layer, const RoadPlace& place);
  [[nodiscard]] static Height by_xy(const Layer& layer, const RoadPlace& place);

  std::vector<Layer> layers_;             // by road
  std::vector<std::size_t> first_layer_;  // of each road, and the count of all
  std::vector<std::string> notes_;
  std::size_t knots_ = 0;
};

/// Where a file begins or ends within a road and its surface steps: the largest step across the carriageway.
struct CrgStep {
  int road = 0;  ///< index into RoadMap::roads
  double s = 0.0, t = 0.0, step_m = 0.0;
};
/// Steps of more than least_m at sStart and sEnd of the map's references, at places where the road itself goes on.
[[nodiscard]] std::vector<CrgStep> find_crg_steps(const RoadMap& map, const RoadCrgs& crgs, double least_m);

/// Reads the OpenCRG files that the map refers to, by names relative to the folder of `xodr`, into map.crgs; to be
/// called when the map is complete. A RoadQuery of the map then answers with them. Throws as RoadCrgs does.
void load_crgs(RoadMap& map, const std::string& xodr);

}  // namespace roadquery

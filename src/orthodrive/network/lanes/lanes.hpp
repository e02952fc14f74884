// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a carriageway is divided into lanes, what lies beside it, and how it is marked.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_material.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/curves/fit_profile.hpp"
#include "orthodrive/network/lanes/lane_rests.hpp"
#include "roadquery/road_map.hpp"

namespace orthodrive::network {

/// Numbers of driving lanes, all equally wide. Forward lanes run with s: right of the centre lane in right-hand
/// traffic.
struct LaneLayout {
  int left = 1, right = 1;
  /// More lanes were tagged than the width has room for.
  bool reduced = false;
  [[nodiscard]] int total() const { return left + right; }
};

/// By the tags lanes, lanes:forward, lanes:backward and oneway; untagged: as many lanes of a usual width as the median
/// width has room for: of motorways and trunk roads beside their shoulder, of streets and lower classes one a
/// direction, of roundabouts one up to 8 m. An odd number of lanes gives the additional one to the forward direction; a
/// single lane used both ways becomes two narrow ones, because OpenDRIVE gives a lane one direction. No lane is made
/// narrower than 2.2 m for the sake of a tag.
[[nodiscard]] LaneLayout lane_layout(const RoadPath& path, double median_width_m, DrivingSide driving_side);

/// What a carriageway needs at least, m: lanes of 2.05 m for two directions, where two cars meet (RASt 06, 4.3); alone
/// a car takes the middle of them. One direction alone has no other lane to swing out into: a car with its mirrors (2.2
/// m), and what its wheels stray to both sides of its way in a bend.
[[nodiscard]] double least_carriageway_m(Oneway oneway, double curvature_1pm = 0.0);

/// Widens carriageways that are narrower than that. Finding network.widened where that is by more than 0.3 m.
[[nodiscard]] RoadNetwork with_lane_room(RoadNetwork roads, Findings& findings);

/// The lanes of a side that are open at an end of a road, counted from the inside; the others taper out towards it.
struct OpenLanes {
  int first = 0, count = 0;
};
/// Of a road's end: left of the centre lane and right of it.
struct RoadEndLanes {
  OpenLanes left, right;
};

struct LaneOptions {
  double tolerance_m = 0.05;  ///< largest error of the carriageway width
  Sides sidewalk = Sides::none;
  LaneRests rests;
  /// Where the road goes on with fewer lanes. Not set: all are open.
  std::optional<RoadEndLanes> start, end;
  /// What goes on of the rests. Not set: all of them.
  std::optional<LaneRests> start_rests, end_rests;
};

/// Fills sections and lane_offset of a road whose length and highway class are known: lanes and what lies beside them
/// together as wide as the carriageway (`widths`) and centred about the reference line, sidewalks outside it, markings
/// by class.
void add_lanes(roadquery::Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths,
               const LaneOptions& options);

[[nodiscard]] roadquery::LaneMaterial lane_material(SurfaceClass surface, Weather weather);
/// Gives all lanes what the road is made of; sidewalks are of slabs (concrete). One entry a lane section.
void set_material(roadquery::Road& road, SurfaceClass surface, Weather weather);
/// Of the innermost driving lane; asphalt for roads without a material.
[[nodiscard]] SurfaceClass surface_of(const roadquery::Road& road);

/// How lanes of one direction go on into those of another road; both counted from the inside. Lanes that end or open do
/// so outside; `inner` of them open inside (turn lanes for the side of the oncoming traffic).
struct LaneMatch {
  OpenLanes from, to;
};
[[nodiscard]] LaneMatch match_lanes(int from, int to, int inner);

/// Ids of driving lanes that run along s (`forward`) or against it, from the inside out.
[[nodiscard]] std::vector<int> lanes_of_direction(const roadquery::Road& road, bool forward);

/// What turn:lanes says about one lane: bits of TurnBit. 0: nothing ("none", "").
enum TurnBit : unsigned { turn_left = 1, turn_through = 2, turn_right = 4, turn_merge = 8 };
/// Of the lanes of one direction from the inside out; empty when there are no arrows.
[[nodiscard]] std::vector<unsigned> turn_lanes(const RoadPath& path, bool forward, DrivingSide driving_side);

}  // namespace orthodrive::network

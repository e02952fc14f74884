// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a carriageway is divided into lanes, what lies beside it, and how it is marked.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "orthodrive/core/finding.hpp"
#include "orthodrive/model/roads/parse_driving_side.hpp"
#include "orthodrive/model/roads/road_material.hpp"
#include "orthodrive/model/roads/road_network.hpp"
#include "orthodrive/network/curves/fit_profile.hpp"
#include "orthodrive/network/lanes/lane_rests.hpp"
#include "roadquery/map/road_map.hpp"

namespace orthodrive::network {

inline constexpr double kmh_per_mps = 3.6;

/// Who drives on a lane.
struct LaneUse {
  roadquery::LaneType type = roadquery::LaneType::driving;
  std::vector<std::string> allowed;  ///< as roadquery::Lane::allowed
};

/// Of each lane of a side and of those for both directions, from the inside out: how wide they are beside each other. A
/// lane without a number has the weight 1.
struct LaneWeights {
  std::vector<double> left, right, both_ways;
  [[nodiscard]] bool are_told() const { return !left.empty() || !right.empty() || !both_ways.empty(); }
  static double at(const std::vector<double>& weights, int lane) {
    const auto i = static_cast<std::size_t>(lane);
    return i < weights.size() ? weights[i] : 1.0;
  }
  bool operator==(const LaneWeights&) const = default;
};

/// Numbers of lanes, what the tags say of their widths and users. Forward lanes run with s: right of the centre lane in
/// right-hand traffic.
struct LaneLayout {
  int left = 1, right = 1;
  /// More lanes were tagged than the width has room for.
  bool reduced = false;
  /// Lanes for both directions between them, the innermost ones on the side of the forward lanes. A single-track road
  /// has no others.
  int both_ways = 0;
  std::vector<LaneUse> left_uses, right_uses;  ///< from the inside out, without both_ways; empty: all for cars
  LaneUse both_use{roadquery::LaneType::bidirectional, {}};
  LaneWeights told_m;  ///< widths that tags tell, m; 0 of lanes of which they do not; no lists where they tell of none

  [[nodiscard]] int total() const { return left + right + both_ways; }
  [[nodiscard]] bool is_shared() const { return left + right == 0; }
  [[nodiscard]] LaneUse use(bool of_left, int lane) const {
    const std::vector<LaneUse>& uses = of_left ? left_uses : right_uses;
    return uses.empty() ? LaneUse{} : uses[static_cast<std::size_t>(lane)];
  }
  /// The sum of the widths that tags tell of all lanes, m; 0 where one lacks.
  [[nodiscard]] double told_sum_m() const;
  /// Lanes of a side for cars; of a road without any, all of the side.
  [[nodiscard]] int main_lanes(bool of_left) const;
};

/// By the tags lanes, lanes:forward, lanes:backward, lanes:both_ways and oneway; untagged: as many lanes of a usual
/// width as the median width has room for: of motorways and trunk roads beside their shoulder, of streets and lower
/// classes one for each direction, of roundabouts one up to 8 m. An odd number of lanes gives the additional one to the
/// forward direction; lanes=1 without oneway is one lane for both. Who may use a lane comes from RoadPath::use_forward,
/// use_backward, use and side_lanes; lanes against a one-way road are never for cars. No lane is made narrower than 2.2
/// m for the sake of a tag.
[[nodiscard]] LaneLayout lane_layout(const RoadPath& path, double median_width_m, DrivingSide driving_side);

/// What a carriageway needs at least, m: lanes of 2.05 m for two directions, where two cars meet (RASt 06, 4.3); alone
/// a car takes the middle of them. One direction alone and a single-track road have no other lane to swing out into: a
/// car with its mirrors (2.2 m), and what its wheels stray to both sides of its way in a bend.
[[nodiscard]] double least_carriageway_m(const RoadPath& path, double curvature_1pm = 0.0);

/// Widens carriageways that are narrower than that. Finding network.widened where that is by more than 0.3 m.
[[nodiscard]] RoadNetwork with_lane_room(RoadNetwork roads, Findings& findings);

/// The lanes of a side that are open at an end of a road, counted from the inside; the others taper out towards it.
struct OpenLanes {
  int first = 0, count = 0;
};
/// Of a road's end: left of the centre lane and right of it, and those for both directions.
struct RoadEndLanes {
  OpenLanes left, right;
  int both_ways = 0;
  [[nodiscard]] int count() const { return left.count + right.count + both_ways; }
};

/// How far the centre lane lies left of the reference line, as shares of the carriageway's width. Not set: the
/// carriageway lies centred about the reference line.
struct LaneShift {
  std::optional<double> start, middle, end;
};

/// How the lanes share a carriageway of this width: as wide as the tags tell of each, or in that ratio; lanes of which
/// they do not tell share what is left in equal parts, 2.2 m at least. No weights where no tag tells.
[[nodiscard]] LaneWeights lane_weights(const LaneLayout& layout, const LaneRests& rests, double median_width_m);

/// Where placement puts the centre lane of a road with these lanes open, `along` from 0 (start) to 1; none: not told.
[[nodiscard]] std::optional<double> placed_shift(const RoadPath& path, const LaneLayout& layout,
                                                 const RoadEndLanes& open, const LaneRests& rests,
                                                 const LaneWeights& weights, double along, DrivingSide driving_side);
[[nodiscard]] RoadEndLanes all_open(const LaneLayout& layout);

struct LaneOptions {
  double tolerance_m = 0.05;  ///< largest error of the carriageway width
  Sides sidewalk = Sides::none;
  LaneRests rests;
  /// Where the road goes on with fewer lanes. Not set: all are open.
  std::optional<RoadEndLanes> start, end;
  /// What goes on of the rests. Not set: all of them.
  std::optional<LaneRests> start_rests, end_rests;
  LaneShift shift;
  LaneWeights weights;
  /// Where the road goes on with lanes of other widths. Not set: `weights`.
  std::optional<LaneWeights> start_weights, end_weights;
};

/// Fills sections and lane_offset of a road whose length and highway class are known: lanes and what lies beside them
/// together as wide as the carriageway (`widths`) and centred about the reference line but for `shift`, sidewalks
/// outside it, markings by class.
void add_lanes(roadquery::Road& road, const LaneLayout& layout, std::span<const ProfileSample> widths,
               const LaneOptions& options);

[[nodiscard]] roadquery::LaneMaterial lane_material(SurfaceClass surface, Weather weather);
/// Gives the lanes the limits that are told of them alone (RoadPath::speeds_forward, speeds_backward).
void set_lane_speeds(roadquery::Road& road, const RoadPath& path);
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

/// The first of the side's lanes that is of one direction alone.
[[nodiscard]] int first_own_lane(const LaneLayout& layout, bool left, DrivingSide driving_side);

/// Ids of driving lanes that run along s (`forward`) or against it, from the inside out. Of a road that has only lanes
/// for both directions, those; of one without any for cars, those of the vehicles that it has.
[[nodiscard]] std::vector<int> lanes_of_direction(const roadquery::Road& road, bool forward);

/// What turn:lanes says about one lane: bits of TurnBit. 0: nothing ("none", "").
enum TurnBit : unsigned { turn_left = 1, turn_through = 2, turn_right = 4, turn_merge = 8 };
/// Of the lanes of one direction that are for cars, from the inside out; empty when there are no arrows.
[[nodiscard]] std::vector<unsigned> turn_lanes(const RoadPath& path, bool forward, DrivingSide driving_side);

}  // namespace orthodrive::network

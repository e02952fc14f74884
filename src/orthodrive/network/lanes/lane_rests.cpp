// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/network/lanes/lane_rests.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "orthodrive/model/roads/highway_class.hpp"
#include "orthodrive/network/lanes/lanes.hpp"

namespace orthodrive::network {
namespace {

using roadquery::LaneType;

constexpr double least_strip_m = 0.5;     // RAL 2012: edge strips are that wide; what is less the lanes take
constexpr double inner_strip_m = 0.75;    // RAA 2008, 4.3: edge strip beside the median
constexpr double least_parking_m = 1.8;   // RASt 06, 6.1.5.2: 2.0 m, of which 0.2 m may overhang
constexpr double usual_parking_m = 2.5;   // lanes are widest before strips are wider
constexpr double least_shoulder_m = 1.0;  // narrower ones are edge strips: nobody stands there

struct LaneWidths {
  std::string_view highway;
  double usual_m, widest_m;  ///< a lane beside others
  double alone_m;            ///< a single lane of a one-way road
};
// Motorways and their ramps: RAA 2008 (RQ 31: 3.75 m; ramps Q 1: 4.50 m, Q 2 and Q 3: 3.50 and 3.75 m). Trunk to
// secondary roads: RAL 2012 (RQ 15.5, RQ 11: 3.50 m), Czech S 11.5 and R 25.5: 3.75 m. Tertiary roads: RQ 9: 3.00 m,
// RASt 06 for buses: 3.25 m. Streets: RASt 06: 2.75 to 3.25 m, one-way with room beside a bicycle 3.50 m. Tracks: DWA-A
// 904: 3.50 m.
constexpr std::array classes{LaneWidths{"motorway", 3.5, 3.75, 3.75},      LaneWidths{"motorway_link", 3.5, 3.75, 4.5},
                             LaneWidths{"trunk", 3.25, 3.75, 3.75},        LaneWidths{"trunk_link", 3.5, 3.75, 4.5},
                             LaneWidths{"primary", 3.0, 3.5, 4.0},         LaneWidths{"primary_link", 3.0, 3.5, 4.5},
                             LaneWidths{"secondary", 3.0, 3.5, 4.0},       LaneWidths{"secondary_link", 3.0, 3.5, 4.5},
                             LaneWidths{"tertiary", 2.75, 3.25, 3.75},     LaneWidths{"tertiary_link", 2.75, 3.25, 4.5},
                             LaneWidths{"unclassified", 2.75, 3.25, 3.75}, LaneWidths{"residential", 2.75, 3.25, 3.5},
                             LaneWidths{"road", 2.75, 3.25, 3.5},          LaneWidths{"living_street", 2.5, 3.0, 3.5},
                             LaneWidths{"service", 2.5, 3.0, 3.5},         LaneWidths{"track", 2.5, 3.0, 3.5}};
// FGSV, Merkblatt fuer die Anlage von Kreisverkehren 2006: rings for one lane are up to 6.5 m wide without the paved
// strip at the island, those of two lanes 8 to 10 m.
constexpr double ring_lane_m = 6.5, ring_lane_of_two_m = 5.0;

const LaneWidths* find_class(std::string_view highway) {
  const auto found =
      std::find_if(classes.begin(), classes.end(), [&](const LaneWidths& c) { return c.highway == highway; });
  return found == classes.end() ? nullptr : &*found;
}

/// Metres of both sides, and what they are.
struct Sidestrips {
  double left_m = 0.0, right_m = 0.0;
  LaneType left = LaneType::none, right = LaneType::none;
};

class Divider {
 public:
  Divider(const RoadPath& path, const LaneLayout& layout, double width_m, DrivingSide driving_side)
      : path_(path),
        lanes_(layout.total()),
        width_m_(width_m),
        told_m_(layout.told_sum_m()),
        one_way_(!layout.is_shared() && path.oneway == Oneway::forward),
        outer_(driving_side == DrivingSide::left ? Sides::left : Sides::right) {}

  [[nodiscard]] Sidestrips strips() const {
    const LaneWidths* widths = find_class(path_.highway);
    if (!widths) return {};
    const bool alone = lanes_ == 1;
    const auto lanes_m = [&](double each_m) { return told_m_ > 0.0 ? told_m_ : lanes_ * each_m; };
    const double usual_m = lanes_m(alone ? std::min(widths->alone_m, widths->usual_m + 0.25) : widths->usual_m);
    const double widest_m = lanes_m(alone ? widths->alone_m : widths->widest_m);
    if (path_.roundabout)
      return at(opposite(outer_), width_m_ - lanes_m(alone ? ring_lane_m : ring_lane_of_two_m), LaneType::border);
    if (const Sidestrips parked = parking(usual_m, widest_m); parked.left_m + parked.right_m > 0.0) return parked;
    if (path_.shoulder != Sides::none) return tagged(path_.shoulder, width_m_ - usual_m, LaneType::shoulder);
    const double rest_m = width_m_ - widest_m;
    if (one_way_ && is_fast_class(path_.highway)) {
      const double inner_m =
          rest_m < 2.0 * least_strip_m ? 0.0 : std::clamp(rest_m / 3.0, least_strip_m, inner_strip_m);
      Sidestrips strips = at(outer_, rest_m - inner_m, edge_type(rest_m - inner_m));
      if (inner_m <= 0.0) return strips;
      (outer_ == Sides::right ? strips.left_m : strips.right_m) = inner_m;
      (outer_ == Sides::right ? strips.left : strips.right) = LaneType::border;
      return strips;
    }
    return tagged(Sides::both, rest_m, edge_type(0.5 * rest_m));
  }

 private:
  static Sides opposite(Sides side) { return side == Sides::left ? Sides::right : Sides::left; }
  static Sidestrips at(Sides side, double width_m, LaneType type) {
    if (width_m < least_strip_m) return {};
    return side == Sides::left ? Sidestrips{width_m, 0.0, type, LaneType::none}
                               : Sidestrips{0.0, width_m, LaneType::none, type};
  }
  static Sidestrips tagged(Sides sides, double width_m, LaneType type) {
    if (sides != Sides::both) return at(sides, width_m, type);
    if (width_m < 2.0 * least_strip_m) return {};
    return {0.5 * width_m, 0.5 * width_m, type, type};
  }
  [[nodiscard]] LaneType edge_type(double width_m) const {
    const bool rural = road_rank(path_.highway) >= road_rank("unclassified") && !is_street_class(path_.highway) &&
                       path_.sidewalk == Sides::none;
    return rural && width_m >= least_shoulder_m ? LaneType::shoulder : LaneType::border;
  }
  /// Of streets: on both sides, or outside of a one-way street. On which side of a two-way street cars stand in one row
  /// nobody knows.
  [[nodiscard]] Sidestrips parking(double usual_m, double widest_m) const {
    if (!is_street_class(path_.highway)) return {};
    const double rows = one_way_ ? 1.0 : 2.0, rest_m = width_m_ - usual_m;
    if (rest_m < rows * least_parking_m) return {};
    return tagged(one_way_ ? outer_ : Sides::both,
                  std::max(std::min(rest_m, rows * usual_parking_m), width_m_ - widest_m), LaneType::parking);
  }

  const RoadPath& path_;
  int lanes_;
  double width_m_, told_m_;
  bool one_way_;
  Sides outer_;
};

LaneRest at_joint(const LaneRest& own, const LaneRest& other) { return {own.type, std::min(own.share, other.share)}; }

/// The width of each cycle lane; 0: none.
double cycle_width_m(const LaneLayout& layout, double width_m, int lanes) {
  constexpr double usual_m = 1.5, least_m = 0.75, least_lane_m = 2.2;
  if (lanes == 0) return 0.0;
  const double each_m = std::min(usual_m, (width_m - layout.total() * least_lane_m) / lanes);
  return each_m < least_m ? 0.0 : each_m;
}

}  // namespace

Sides sides_with(const RoadPath& path, std::string_view kind, DrivingSide driving_side) {
  const bool right_hand = driving_side == DrivingSide::right;
  int sides = 0;
  for (const std::string_view word : side_lanes_of(path)) {
    if (word.size() <= kind.size() || !word.starts_with(kind) || word[kind.size()] != ':') continue;
    const std::string_view side = word.substr(kind.size() + 1);
    const bool right = side == "right" || (side == "along" && right_hand) || (side == "against" && !right_hand);
    sides |= static_cast<int>(right ? Sides::right : Sides::left);
  }
  return static_cast<Sides>(sides);
}

LaneRests lane_rests(const RoadPath& path, const LaneLayout& layout, double median_width_m, DrivingSide driving_side) {
  const Sides cycles = sides_with(path, "bicycle", driving_side);
  const bool on_left = has_side(cycles, Sides::left), on_right = has_side(cycles, Sides::right);
  const double cycle_m = cycle_width_m(layout, median_width_m, (on_left ? 1 : 0) + (on_right ? 1 : 0));
  const double left_m = on_left ? cycle_m : 0.0, right_m = on_right ? cycle_m : 0.0;
  const Sidestrips strips = Divider(path, layout, median_width_m - left_m - right_m, driving_side).strips();
  return {{strips.left, strips.left_m / median_width_m},
          {strips.right, strips.right_m / median_width_m},
          {LaneType::biking, left_m / median_width_m},
          {LaneType::biking, right_m / median_width_m}};
}

LaneRests rests_at_joint(const LaneRests& own, const LaneRests& other, bool same_direction) {
  return {at_joint(own.left, same_direction ? other.left : other.right),
          at_joint(own.right, same_direction ? other.right : other.left),
          at_joint(own.left_cycles, same_direction ? other.left_cycles : other.right_cycles),
          at_joint(own.right_cycles, same_direction ? other.right_cycles : other.left_cycles)};
}

}  // namespace orthodrive::network

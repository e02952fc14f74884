// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads as tables: what the query evaluates instead of the exact functions of road_surface.hpp, a few nanoseconds a
// point. Every station is compared with the exact reference line when it is made.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "roadquery/map/road_map.hpp"
#include "roadquery/tables/large_vector.hpp"

namespace roadquery {

/// Largest distance in plan between a baked reference line and the exact one, m.
inline constexpr double baked_plan_error_m = 1e-6;
/// Half of the shortest station: shorter pieces of line are not cut further, whatever their curvature, m.
inline constexpr double shortest_half_m = 0.02;
inline constexpr double free_step_m = 0.125;
inline constexpr std::uint16_t unusable_station = 0xffff;
inline constexpr std::uint32_t no_index = 0xffffffffu;
inline constexpr std::uint32_t one_of_several = 0xfffffffeu;

/// Whether slope and superelevation (or shape) move the points of a station along the road: by no more than turned_m,
/// which is less than what a foot is looked for beyond a station's ends, or by more.
inline constexpr std::uint32_t not_turned = 0, near_turned = 1, far_turned = 2;
inline constexpr double turned_m = 0.1;

/// One piece of a road, two cache lines: polynomials in u = s - s of its middle, |u| <= half_m. Nothing in it begins or
/// ends: geometry, profiles, shape rows and lanes are smooth.
struct alignas(64) Station {
  double x = 0.0, y = 0.0;              ///< middle of the reference line
  double cos_hdg = 1.0, sin_hdg = 0.0;  ///< heading there: the frame of `along` and `left`
  double s = 0.0, z = 0.0;              ///< of the middle
  float half_m = 0.0F;
  float speed = 1.0F;                          ///< of u, along the heading: the line in the frame of its middle
  float bend[4][2] = {};                       ///< of u^2 to u^5: along the heading, and to the left
  float bank = 0.0F;                           ///< of the middle: superelevation, rad
  float profile[3][2] = {};                    ///< of u, u^2, u^3: superelevation, and height over z
  std::uint32_t lanes = 0;                     ///< index into BakedRoads::stretches
  std::uint32_t shapes : 30 = 0;               ///< index of the first of shape_count in BakedRoads::shapes
  std::uint32_t turned : 2 = 0;                ///< not_turned, near_turned or far_turned
  std::uint16_t shape_count = 0;               ///< unusable_station: not all numbers are finite
  std::int8_t free_right = 1, free_left = -1;  ///< so far left of the line, in free_step_m, nothing else is near
};
static_assert(sizeof(Station) == 128);

/// Lateral profile between two rows of <shape>: a + b dt + c dt^2 + d dt^3 plus (s - this->s) times the same of
/// `slope`, with dt = t - origin; valid from `begin` on to the next one's, the first one also to its right.
struct ShapePiece {
  double s = 0.0;
  float begin = 0.0F, origin = 0.0F;
  float value[2][2] = {}, slope[2][2] = {};
};

/// A lane between two places where its width or material changes.
struct BakedLane {
  double outer[4] = {0.0, 0.0, 0.0, 0.0};  ///< t of the outer border: cubic of s - LaneStretch::s
  int id = 0;
  SurfaceClass surface = SurfaceClass::asphalt;
  float friction = 1.0F, roughness_m = 0.0F;
};

/// Height of a lane over the road's surface at its inner and outer border, and how they change per metre of s.
struct BakedHeight {
  float at[2] = {}, rise[2] = {};  ///< at LaneStretch::s, m
};

/// What lies on a road's own surface: LaneStretch::relief.
inline constexpr std::uint32_t relief_crg = 1, relief_lanes = 2;

/// The lanes of a road where none of their widths, heights and materials begins or ends. Cubics of s - this->s.
struct alignas(64) LaneStretch {
  double s = 0.0;
  std::uint32_t road = 0;                         ///< index into RoadMap::roads
  float reach_m = 0.0F;                           ///< the surface lies within this distance of the line
  double length_m = 0.0;                          ///< of the road
  double edges[4][2] = {};                        ///< t of the right and the left outer edge
  double center[4] = {};                          ///< t of the centre line
  std::uint32_t first : 29 = 0;                   ///< of left_count + right_count in BakedRoads::lanes
  std::uint32_t one_material : 1 = 0;             ///< all lanes have that of the first, which there is
  std::uint32_t relief : 2 = 0;                   ///< OpenCRG files, lanes with heights, or both; 0: neither
  std::uint16_t left_count = 0, right_count = 0;  ///< from the centre outwards
};

static_assert(sizeof(LaneStretch) == 128);

/// Successive stations [first, last] of one road.
struct StationRange {
  std::uint32_t first = 0, last = 0;
};

/// Stations that lie over another one. The rectangle, in the other's frame and in companion_step_m, holds their surface
/// beside it; the last step of either side goes on for ever.
struct Companion {
  StationRange range;
  std::int8_t along_min = 127, along_max = -128, left_min = 127, left_max = -128;
};
inline constexpr float companion_step_m = 0.25F;

/// Where a junction's own surface answers for a station.
struct StationJunction {
  std::uint32_t index = no_index;  ///< of RoadMap::junctions; one_of_several or no_index: no single one
  /// A point that is_in_core() lies on the station's surface. In free_step_m of near_place(); right above left:
  /// nowhere.
  std::int8_t core_right = 1, core_left = -1;
};

class RoadCrgs;

/// All roads of a map. Immutable after bake().
struct BakedRoads {
  LargeVector<Station> stations;             // by road, then by s
  std::vector<std::uint32_t> first_station;  // of each road, and the count of all
  LargeVector<LaneStretch> stretches;
  LargeVector<BakedLane> lanes;
  std::vector<BakedHeight> heights;  // of the lanes, up to the last one that has any
  LargeVector<ShapePiece> shapes;
  std::shared_ptr<const RoadCrgs> crgs;  // what is laid on them; null: nothing
  // What else lies over station i, or within 3.5 m above or below it: companions[companion_begin[i] ..
  // companion_begin[i + 1]) are the stations of other roads, or of the same one far along it, that touch it.
  std::vector<std::uint32_t> companion_begin;
  LargeVector<Companion> companions;
  // Of each station, where its surface, its companions' and those of the junctions over it are one level whichever
  // counts, and no companion is of its own road: the junction whose surface, under a point there, is the answer;
  // one_of_several where more than one lies over the station, no_index where none decides.
  LargeVector<StationJunction> deciding_junction;

  [[nodiscard]] StationRange stations_of(std::uint32_t road) const {
    return {first_station[road], first_station[road + 1] - 1};
  }
  [[nodiscard]] std::uint32_t road_of(const Station& station) const { return stretches[station.lanes].road; }

  /// The station of a road at s, clamped to the road; no_index for roads without stations.
  [[nodiscard]] std::uint32_t station_at(std::size_t road, double s) const;

 private:
  friend BakedRoads bake(const RoadMap& map);
  // Station of road r at s: entry [lookup_begin[r] + s lookup_per_m[r]] or one of the next.
  std::vector<std::uint32_t> lookup_, lookup_begin_;
  std::vector<float> lookup_per_m_;
};

/// Throws std::runtime_error for a road without bounds: coordinates beyond 1e8 m, 1 km of width, 100 turns within one
/// geometry, a line 100 times as long as its s, and for a map of more than 10 000 km of road.
[[nodiscard]] BakedRoads bake(const RoadMap& map);

}  // namespace roadquery

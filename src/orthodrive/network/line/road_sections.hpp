// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cross sections of all roads, a metre apart, and which of them lie on each other.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/network/line/stretches.hpp"

namespace orthodrive::network {

/// A cross section of a road, or of a way inside a junction.
struct RoadSection {
  ChainIndex chain;
  std::size_t stretch = 0;
  int junction = -1;  ///< that it lies in
  double s = 0.0, half_m = 0.0, least_half_m = 0.0, z = 0.0;
  double gradient = 0.0, banking = 0.0, crown = 0.0;  ///< tangents
  int rank = 0;                                       ///< road_rank() of its class
  double speed_mps = 0.0;                             ///< limit
  Vec2 p, direction;

  /// Of its plane, carried on beyond its edges.
  [[nodiscard]] double height_at(Vec2 at) const {
    const double left_m = cross(direction, at - p);
    return z + dot(direction, at - p) * gradient + left_m * banking - std::abs(left_m) * crown;
  }
};

/// Of cut_roads().
using Cuts = std::vector<std::vector<double>>;

class SectionMaker {
 public:
  SectionMaker(const RoadNetwork& roads, const Topology& topology, const JunctionPlan& junctions,
               const ChainGeometries& geometry)
      : roads_(roads), topology_(topology), junctions_(junctions), geometry_(geometry) {}

  [[nodiscard]] RoadSection at(std::size_t stretch, int junction, double s) const;
  /// Of all roads but the shortest, which lie inside the surfaces of their junctions, and of what lies in junctions.
  [[nodiscard]] std::vector<RoadSection> all(const Cuts& cuts) const;

 private:
  const RoadNetwork& roads_;
  const Topology& topology_;
  const JunctionPlan& junctions_;
  const ChainGeometries& geometry_;
};

class SectionIndex {
 public:
  explicit SectionIndex(const std::vector<RoadSection>& sections);
  /// All whose roads may reach so near.
  [[nodiscard]] std::vector<std::uint32_t> near(Vec2 p, double reach_m) const;

 private:
  SpatialIndex index_;
  double widest_m_ = 0.0;
};

inline constexpr double section_step_m = 1.0;
inline constexpr double flush_m = 0.01;           ///< lower steps between two surfaces need no bank
inline constexpr double widest_bank_m = 0.5;      ///< between roads of different heights, 45 degrees steep
inline constexpr double section_margin_m = 0.1;   ///< widths are fitted within 5 cm, on both roads
inline constexpr double deepest_overlap_m = 5.0;  ///< of roads that make room for each other

[[nodiscard]] double bank_m(double z_step_m);
/// Whether a makes room for b: the one of the lower class, then the narrower one.
[[nodiscard]] bool gives_way(const RoadSection& a, const RoadSection& b);
/// Whether the junction that `other` lies in is one of the road's own.
[[nodiscard]] bool is_own_junction(const RoadSection& road, const RoadSection& other, const JunctionPlan& junctions);
/// Whether the roads part at one node. They lie on each other until they are apart: there both keep their width for
/// longer.
[[nodiscard]] bool part_at_a_node(const RoadSection& a, const RoadSection& b, const JunctionPlan& junctions);
/// Whether two sections stand side by side: on roads that go along each other, at most a step apart along them.
[[nodiscard]] bool are_side_by_side(const RoadSection& a, const RoadSection& b);
/// Half widths that are left when all roads have made room for each other (leave_room.hpp), by section. Those inside
/// junctions keep theirs.
[[nodiscard]] std::vector<double> room_of(const std::vector<RoadSection>& sections, const JunctionPlan& junctions);

}  // namespace orthodrive::network

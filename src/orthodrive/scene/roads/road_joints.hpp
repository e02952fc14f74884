// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where roads of two levels run on into each other: the ground and a deck, the ground and a tunnel. Both meshes get the
// same vertices there, so that no crack opens.

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/spatial_index.hpp"
#include "orthodrive/geo/vec.hpp"
#include "roadquery/query/road_query.hpp"

namespace orthodrive::scene {

/// Points across both ends of a road where roads of other levels go on, from the right edge to the left one; empty:
/// none do.
struct EndPoints {
  std::span<const Vec2> start, end;
};

struct MeetingLevels {
  int lowest = 0, highest = 0;
};

class RoadJoints {
 public:
  RoadJoints() = default;
  /// Of road ends that links of the map join. `level_of`: by index of the road its level, negative: not drawn. Ends
  /// more than 2 cm apart along the road are no joint.
  RoadJoints(const roadquery::RoadQuery& query, std::span<const int> level_of);

  /// On the plan grid, seen along the road: its own corners, and those of the other roads, borders of lanes and ridges
  /// of crowns in between.
  [[nodiscard]] EndPoints across(std::size_t road) const { return {across(road, false), across(road, true)}; }
  /// The level whose height counts at p: the lowest of those that meet there. Nothing: p lies on no joint.
  [[nodiscard]] std::optional<int> level_at(Vec2 p) const;
  /// The levels of the roads that meet at p, where p lies between the corners of the joint; nothing elsewhere. Every
  /// joint has a point there.
  [[nodiscard]] std::optional<MeetingLevels> inside_at(Vec2 p) const;

 private:
  struct Edge {
    Vec2 a, b;
    int level = 0;
  };
  struct Run {  // from corner to corner: roads of two levels at least on all of it
    Vec2 a, b;
    MeetingLevels levels;
  };
  struct End;
  struct Place;
  [[nodiscard]] std::span<const Vec2> across(std::size_t road, bool at_end) const;
  void join(std::span<const End> ends);
  void add_runs(std::span<const End* const> joined, Vec2 across, Vec2 from, std::vector<Place>& places);

  std::map<std::pair<std::size_t, bool>, std::vector<Vec2>> across_;
  std::vector<Edge> edges_;
  std::vector<Run> runs_;
  SpatialIndex index_, run_index_;
};

/// A ring with the points between its corners `from` and `to`, which follow each other; as it was where it lacks them.
void insert_between(Ring& ring, Vec2 from, Vec2 to, const std::vector<Vec2>& between);

}  // namespace orthodrive::scene

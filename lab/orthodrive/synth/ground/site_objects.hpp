// SPDX-License-Identifier: Apache-2.0
#pragma once
// What stands and grows on a synthetic site: houses with their lots, trees, cars, fields, woods, a pond.

#include <cstdint>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/synth/plan/site_plan.hpp"

namespace orthodrive::synth {

enum class Leaves : std::uint8_t { green, autumn, bare };

struct Tree {
  Vec2 center;
  double radius_m = 0.0, height_m = 0.0;
  bool conifer = false;
  std::int32_t id = 0;  ///< what its look is drawn from
  Leaves leaves = Leaves::green;
};

struct Car {
  Vec2 center;
  double heading_rad = 0.0, half_length_m = 2.2, half_width_m = 0.9, height_m = 1.5;
  Rgb color{};
};

struct SiteObjects {
  std::vector<House> houses;
  std::vector<Tree> trees;
  std::vector<Car> cars;
  std::vector<Area> areas;
};

[[nodiscard]] Ring outline(const House& house);

/// `clearance_m` on `frame` (local metres): distance to the nearest carriageway.
[[nodiscard]] SiteObjects place_objects(const SitePlan& plan, const Raster<float>& clearance_m, const GridFrame& frame,
                                        std::uint64_t seed);

/// A square of a region whose objects are placed on their own: what stands in it, with what the plan says about it.
struct ObjectCell {
  Box2 box;
  std::vector<Stretch> stretches;  ///< of the roads that touch the box
  std::vector<std::size_t> areas;  ///< of the plan that touch the box
  std::uint64_t seed = 0;          ///< of this cell
};
/// Objects whose centres lie in the cell; houses keep inside it. The plan's own areas are not among them.
[[nodiscard]] SiteObjects place_cell_objects(const SitePlan& plan, const ObjectCell& cell,
                                             const Raster<float>& clearance_m, const GridFrame& frame);

}  // namespace orthodrive::synth

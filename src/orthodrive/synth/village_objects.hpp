#pragma once
// What stands and grows in a synthetic village: houses with their lots, trees, cars, fields, woods, a pond.

#include <array>
#include <cstdint>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/raster.hpp"
#include "orthodrive/synth/village_plan.hpp"

namespace orthodrive::synth {

using Rgb = std::array<float, 3>;  ///< 0..1, as displayed

enum class RoofShape : std::uint8_t { gable, flat };

struct House {
  Vec2 center;
  double heading_rad = 0.0;                                                   ///< of the ridge
  double half_length_m = 0.0, half_width_m = 0.0, eave_m = 0.0, pitch = 0.0;  ///< pitch = rise over run
  RoofShape roof = RoofShape::gable;
  Rgb color{};
};

struct Tree {
  Vec2 center;
  double radius_m = 0.0, height_m = 0.0;
  bool conifer = false;
};

struct Car {
  Vec2 center;
  double heading_rad = 0.0, half_length_m = 2.2, half_width_m = 0.9, height_m = 1.5;
  Rgb color{};
};

/// What covers the ground of an area; later areas lie on earlier ones, roads on all.
enum class Cover : std::uint8_t {
  field,
  meadow,
  lawn,
  garden_bed,
  forest_floor,
  paved,
  parking,
  gravel,
  water,
  pool,
  road,
  verge,
  sidewalk
};

struct Area {
  Polygon polygon;
  Cover cover = Cover::lawn;
  bool mapped = false;  ///< appears in the OSM file
};

struct VillageObjects {
  std::vector<House> houses;
  std::vector<Tree> trees;
  std::vector<Car> cars;
  std::vector<Area> areas;
};

[[nodiscard]] Ring outline(const House& house);

/// `clearance_m` on `frame` (local metres): distance to the nearest carriageway.
[[nodiscard]] VillageObjects place_objects(const VillagePlan& plan, const Raster<float>& clearance_m,
                                           const GridFrame& frame, std::uint64_t seed);

}  // namespace orthodrive::synth

// SPDX-License-Identifier: Apache-2.0
#pragma once
// The plan of a synthetic site: exact roads, where they meet, where one crosses over another, what lies between them.
// Everything in synth/ works in local metres east and north of the site's south-west corner; make_site moves the
// results into the site CRS.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/math/cubic_spline.hpp"
#include "orthodrive/model/roads/osm_data.hpp"
#include "orthodrive/synth/plan/alignment.hpp"

namespace orthodrive::synth {

using Rgb = std::array<float, 3>;  ///< 0..1, as displayed

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
  sidewalk,
  gravel_trap,
  kerb,
  drive,  ///< paved, to a house
  apron,  ///< paved run-off area
  path,   ///< unpaved, no road of the map
  // Of landmarks (synth/ground/landmarks.hpp)
  snow,
  dirt,
  debris,
  rock,
  river,
  rails,
  orchard,
  barrier
};

/// Paved, no road.
[[nodiscard]] constexpr bool is_paved(Cover cover) {
  return cover == Cover::paved || cover == Cover::drive || cover == Cover::apron;
}

struct Area {
  Polygon polygon;
  Cover cover = Cover::lawn;
  bool mapped = false;  ///< appears in the OSM file
  std::int32_t id = 0;  ///< what its look is drawn from; set when objects are placed
};

/// What a carriageway is made of; `plain`: the asphalt of sites without a world.
enum class Pavement : std::uint8_t { plain, new_asphalt, old_asphalt, concrete, setts, gravel, dirt };
constexpr std::size_t pavement_count = 7;

enum class RoofShape : std::uint8_t { gable, flat };

/// What a building is for; `dwelling`: of all that stand on lots, whose size tells the rest.
enum class Use : std::uint8_t { dwelling, town_house, tower, farm, works, stand };

struct House {
  Vec2 center;
  double heading_rad = 0.0;                                                   ///< of the ridge
  double half_length_m = 0.0, half_width_m = 0.0, eave_m = 0.0, pitch = 0.0;  ///< pitch = rise over run
  RoofShape roof = RoofShape::gable;
  Rgb color{};
  std::int32_t id = 0;  ///< what its look is drawn from; set when objects are placed
  Use use = Use::dwelling;
};

struct PlannedRoad {
  std::string highway, name;
  double width_m = 0.0;  ///< of the carriageway where `width_along` has no knots
  int lanes = 2;
  bool oneway = false;
  Alignment alignment;
  bool roundabout = false;
  bool lanes_tagged = false;  ///< always, not only by chance
  CubicSpline width_along;    ///< of the carriageway, over s
  std::string surface;        ///< as OSM would have it; empty: asphalt that nobody tagged
  Pavement pavement = Pavement::plain;
  [[nodiscard]] double width_at(double s_m) const { return width_along.knots.empty() ? width_m : width_along.at(s_m); }
};

struct PlannedJunction {
  struct Arm {
    std::size_t road = 0;
    double s_m = 0.0;
  };
  Vec2 p;
  std::vector<Arm> arms;
};

/// One deck, over one road or over both carriageways of one.
struct PlannedBridge {
  struct Below {
    std::size_t road = 0;
    double s_m = 0.0, s_over_m = 0.0;  ///< of the crossing along the lower and along the upper road
  };
  std::size_t over = 0;        ///< road
  double s_over_m = 0.0;       ///< middle of the deck
  double half_length_m = 0.0;  ///< of the deck, along the upper road
  std::vector<Below> under;
};

/// A stretch of a road whose height follows another road beside it: slip roads in the carriageway that they leave, the
/// two carriageways of a motorway.
struct PlannedTie {
  std::size_t road = 0, main = 0;
  double s_begin_m = 0.0, s_end_m = 0.0;  ///< along `road`
  bool on_surface = false;                ///< on the very surface of `main`, its banking included; else about as high
};

/// How the land looks away from the roads.
enum class Surroundings : std::uint8_t { village, country, region, settled };

/// A town or a village of a region.
struct Settlement {
  Polygon outline;
  bool town = false;
};

/// Building lots along the roads and what stands on them.
struct LotStyle {
  double least_length_m = 18.0, most_length_m = 27.0;
  double walk_m = 1.8;  ///< pavement between carriageway and lot
  double least_setback_m = 5.0, most_setback_m = 10.0;
  double least_depth_m = 24.0, most_depth_m = 38.0;
  double least_half_front_m = 4.5, most_half_front_m = 8.0;
  double side_gap_m = 3.5;  ///< on either side of the house, at least
  double least_half_deep_m = 3.8, most_half_deep_m = 5.5;
  double least_eave_m = 3.5, most_eave_m = 6.5;
  double road_gap_m = 4.0, house_gap_m = 3.0;  ///< from a house to carriageways and to other houses, at least
};

/// Fruit trees in rows.
struct Orchard {
  Polygon polygon;
  double heading_rad = 0.0, row_m = 5.0, tree_m = 4.0, radius_m = 1.6;
};

/// How a site whose surroundings are `settled` is built up and planted.
struct Settling {
  LotStyle lots;
  double built_share = 0.9;       ///< of the lots along streets in settlements
  double lawn_share = 1.0;        ///< of the lots; the others are paved, gravel or beds
  double tree_clearance_m = 1.0;  ///< from carriageways to trunks
  double roadside_trees = 1.0;    ///< share of the places beside roads that may have a tree
  double scattered_per_ha = 4.0;  ///< groups of trees
  double parked_share = 0.16;     ///< of the places at the kerb
  std::vector<Orchard> orchards;
};

/// Ways that were given, not made: OSM as it is, with the stretch of road 0 that each way is. Sorted by their ids.
struct GivenOsm {
  struct Way {
    std::int64_t osm_id = 0;
    std::int64_t first_node = 0, last_node = 0;
    double s_begin_m = 0.0, s_end_m = 0.0;  ///< along road 0; the end may lie beyond the seam (s > length)
  };
  OsmData data;  ///< local metres
  std::vector<Way> ways;
};

struct SitePlan {
  double size_m = 0.0;
  std::string name;  ///< of the site, without the seed
  std::vector<PlannedRoad> roads;
  std::vector<PlannedJunction> junctions;
  std::vector<PlannedBridge> bridges;
  std::vector<PlannedTie> ties;
  std::vector<Polygon> parkings;  ///< four corners each: along the road, then away from it
  std::vector<Area> areas;        ///< what the plan lays out itself: run-off areas, verges
  std::vector<House> buildings;
  std::vector<Settlement> settlements;  ///< of a region: roads in them are built up
  Settling settling;
  Vec2 field_m{70.0, 190.0};  ///< about so large are fields
  double bund_m = 0.0;        ///< grass between fields, to either side of their border
  double terrace_m = 0.0;     ///< fields are cut where the ground rises by this; 0: they lie as they like
  double walk_from_m = 0.0, walk_to_m = 1.6;  ///< pavement of residential streets, from the carriageway's edge
  double corner_rounding_m = 7.0;
  bool only_footpaths = false;         ///< paths that are no roads are too narrow for cars
  std::string route;                   ///< name of an open road to drive on; empty: the circuit, or none
  std::optional<std::size_t> circuit;  ///< the closed road to drive on; its inside is a meadow
  Surroundings surroundings = Surroundings::village;
  double relief = 1.0;                  ///< of the hills
  bool round_corners_by_angle = false;  ///< else all corners alike: right where roads meet at 45 degrees and more
  Vec2 world_from_local{460000.0, 5270000.0};  ///< near Salzburg. A multiple of 10 m, so that all grids share corners
  std::vector<Vec3> heights;                   ///< surveyed ground; empty: hills are made up
  std::optional<GivenOsm> osm;                 ///< of road 0; else, and for other roads, OSM is the plan, disturbed
};

/// With the seed where all is made up.
[[nodiscard]] std::string site_name(const SitePlan& plan, std::uint64_t seed);

/// Of the crossing roads a and b (indices): the one that is on a bridge, if any.
using BridgeRule = std::function<std::optional<std::size_t>(std::size_t a, std::size_t b)>;
/// Finds, on the exact curves, where roads end on others and where they cross: junctions and bridges.
void find_junctions(SitePlan& plan, const BridgeRule& rule);

/// Which road's surface is on top where two overlap at grade: larger wins.
[[nodiscard]] int surface_priority(const SitePlan& plan, std::size_t road);
/// A piece of a road, along its line.
struct Stretch {
  std::size_t road = 0;
  double s_begin_m = 0.0, s_end_m = 0.0;
};
/// All roads from end to end.
[[nodiscard]] std::vector<Stretch> whole_roads(const SitePlan& plan);

/// True on the deck of a bridge.
[[nodiscard]] bool on_bridge(const SitePlan& plan, std::size_t road, double s_m);
/// Built for speed: nothing grows or stands near it.
[[nodiscard]] bool is_fast(const PlannedRoad& road);

/// Corners counter-clockwise.
[[nodiscard]] Ring rectangle(Vec2 center, double heading_rad, double half_length_m, double half_width_m);

}  // namespace orthodrive::synth

// SPDX-License-Identifier: Apache-2.0
#pragma once
// Roads from OSM to OpenDRIVE: one path a way (a piece of a way where the way leaves the area), with samples that the
// stages refine and elevate fill in step by step. On disk: roads.gpkg.

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "orthodrive/geo/crs.hpp"
#include "orthodrive/geo/polygon.hpp"
#include "orthodrive/geo/polyline.hpp"
#include "orthodrive/model/roads/road_material.hpp"

namespace orthodrive {

enum class Oneway : std::int8_t { no = 0, forward = 1 };  ///< oneway=-1 is reversed on reading

/// Where banking and crown of a node come from.
enum class BankingSource : std::int8_t {
  unset,         ///< no heights yet
  none,          ///< a raceway that nothing measured
  dtm,           ///< measured across the carriageway in a terrain model
  log,           ///< measured by a car that drove there
  interpolated,  ///< between or shortly beyond measured places
  design,        ///< as roads of the class are designed
  truth          ///< of a synthetic site
};
/// As the column `banking_source` of roads.gpkg has it; unset is the empty text.
[[nodiscard]] const char* to_string(BankingSource source);
/// Unset for other texts.
[[nodiscard]] BankingSource banking_source_of(std::string_view text);

/// One place along a path.
struct RoadNode {
  Vec2 p;                     ///< on the centre line of the carriageway, site CRS
  std::int64_t osm_node = 0;  ///< 0: put in by resampling (osm_node_id.hpp). Paths that share another id meet here
  double s_m = 0.0;           ///< along the path
  double offset_m = 0.0;      ///< of p from the OSM line, positive to the left of the path's direction
  double width_m = 0.0;       ///< of the carriageway (all lanes), symmetric about p
  double sigma_offset_m = 0.0, sigma_width_m = 0.0;
  double z_m = std::numeric_limits<double>::quiet_NaN();  ///< height of the road surface at p
  double gradient = 0.0;                                  ///< dz/ds
  double banking = 0.0;  ///< slope across in rad, positive = left side higher (<superelevation> in OpenDRIVE)
  double crown = 0.0;  ///< rad, >= 0: both halves fall away from p by this. z(t) = z + t tan(banking) - |t| tan(crown)
  double sigma_z_m = 0.0, sigma_banking = 0.0;
  BankingSource banking_source = BankingSource::unset;  ///< of banking and crown
  double kerb_radius_m =
      0.0;  ///< of the corners of the junction that this node is, as seen; 0: not seen, or no junction
};

/// Where the width of an OSM way comes from: its class alone, its number of lanes, or a tag.
enum class WidthSource : std::int8_t { highway, lanes, tag };

/// Sides of a path, seen in its direction.
enum class Sides : std::int8_t { none = 0, left = 1, right = 2, both = 3 };
[[nodiscard]] constexpr bool has_side(Sides sides, Sides one) {
  return (static_cast<int>(sides) & static_cast<int>(one)) != 0;
}

/// Where the line of the map lies among the lanes of one direction: how many of them lie to its left, as their drivers
/// see them. OSM's placement: left_of:1 is 0, middle_of:1 is 0.5, right_of:1 is 1.
struct Placement {
  bool backward = false;            ///< the lanes that run against the path are counted
  double start = -1.0, end = -1.0;  ///< at both ends of the path; -1: not told
  bool transition = false;          ///< from where it lies on the road before to where it lies on the next one
  [[nodiscard]] bool is_told() const { return start >= 0.0 || end >= 0.0; }
};

struct RoadPath {
  std::int64_t osm_id = 0;
  int part = 0;  ///< pieces of one way inside the area are counted from 0
  std::string highway, name;
  int layer = 0;
  bool bridge = false, tunnel = false;
  Oneway oneway = Oneway::no;
  int lanes = 0;  ///< 0: not tagged
  WidthSource width_source = WidthSource::highway;
  bool roundabout = false;
  /// Of each direction; 0: not tagged. Lanes against a one-way road are none for cars.
  int lanes_forward = 0, lanes_backward = 0;
  int lanes_both_ways = 0;  ///< between the directions, for both of them: turn lanes, reversible lanes
  /// OSM's turn:lanes of each direction, "left|through;right": lanes from left to right as their drivers see them.
  std::string turn_forward, turn_backward;
  /// Who may use each lane of a direction, in the same order: "||bus". Words: psv, bus, taxi, bicycle, none; nothing
  /// where cars may. Empty: cars may use all of them.
  std::string use_forward, use_backward;
  /// The same word for the whole road; empty: cars may drive there.
  std::string use;
  /// Lanes of one kind of vehicle at the road's sides, "bus:right bicycle:along": bus lanes are the outermost of the
  /// lanes, cycle lanes (bicycle) lie beside them. Sides: left, right, along (of those that drive with the path),
  /// against.
  std::string side_lanes;
  Placement placement;           ///< where no photo has shown where the carriageway lies
  double speed_limit_kmh = 0.0;  ///< 0: not tagged
  /// The case of the law that gives a limit where no number is tagged: "CZ:urban", "GB:nsl_dual", "DE:zone30", or
  /// "urban" and "rural" alone for where the road lies; empty: not known. settle_speeds() asks it.
  std::string speed_context;
  /// Limits in km/h of the lanes of each direction, "70" or lane by lane "100|80", before settle_speeds() also cases of
  /// the law; empty: speed_limit_kmh.
  std::string speeds_forward, speeds_backward;
  /// Widths in m of the lanes of each direction, lane by lane in the same order, and of those for both directions from
  /// left to right along the path: "3.5|3|", nothing for a lane whose width is not told; empty: of none.
  std::string widths_forward, widths_backward, widths_both_ways;
  Sides sidewalk = Sides::none, shoulder = Sides::none;
  std::string traffic_calming;  ///< humps that the whole way is, as OSM has it (traffic_calming.hpp); empty: none
  std::string surface;          ///< as OSM has it; empty: not tagged
  KnownSurface known_surface;   ///< its class, and where that comes from
  std::vector<RoadNode> nodes;  ///< at least two; first == last position (and osm_node) for closed ways
};

/// A turn at a node, or over one or more ways, that OSM's relations forbid (no_*), or the only one they allow (only_*).
struct TurnRestriction {
  std::int64_t from_way = 0, via_node = 0, to_way = 0;  ///< via_node: where one leaves from_way
  bool only = false;
  std::vector<std::int64_t> via_ways = {};  ///< between from_way and to_way, as one drives; none: over via_node alone
};

/// What the tags of a node on a road say: who waits there, who walks across, what is built there.
enum class NodeSignKind : std::int8_t {
  stop,
  give_way,
  traffic_signals,
  zebra,            ///< a crossing with its own marking
  signal_crossing,  ///< a crossing with traffic lights
  plain_crossing,   ///< without a marking, or none told
  mini_roundabout,  ///< value: "clockwise", "anticlockwise" or nothing; size_m: of the paved disc
  traffic_calming,  ///< value: OSM's
  barrier           ///< value: OSM's; size_m: of the way through
};
[[nodiscard]] constexpr bool is_crossing(NodeSignKind kind) {
  return kind >= NodeSignKind::zebra && kind <= NodeSignKind::plain_crossing;
}
/// As the column `kind` of roads.gpkg has it.
[[nodiscard]] const char* to_string(NodeSignKind kind);
[[nodiscard]] std::optional<NodeSignKind> node_sign_kind_of(std::string_view text);

struct NodeSign {
  std::int64_t osm_node = 0;
  NodeSignKind kind = NodeSignKind::stop;
  int direction = 0;    ///< 1: for who drives along the path, -1: against it, 0: not told
  std::string value;    ///< which one of its kind; empty: not told
  double size_m = 0.0;  ///< 0: not told
  bool closed = false;  ///< a barrier that no car may pass
};
/// As a network holds them: by node, then kind, then what tells equal kinds apart.
[[nodiscard]] bool sign_before(const NodeSign& a, const NodeSign& b);

struct RoadNetwork {
  Crs crs;
  std::vector<RoadPath> paths;
  std::vector<TurnRestriction> restrictions;
  std::vector<NodeSign> signs;  ///< sorted by sign_before
};

/// Carriageway width in metres for a way without a width tag: by highway value, lanes and oneway.
[[nodiscard]] double default_width_m(const std::string& highway, int lanes, Oneway oneway);
/// Cycle lanes that side_lanes names, as wide as they are usually painted, m.
[[nodiscard]] double cycle_lanes_m(const RoadPath& path);
/// The parts of a list of lanes such as use_forward and speeds_forward, one per lane; none of an empty list. They live
/// as long as the list.
[[nodiscard]] std::vector<std::string_view> lane_words(std::string_view list);
/// The words of side_lanes.
[[nodiscard]] std::vector<std::string_view> side_lanes_of(const RoadPath& path);
/// Lanes of a road that has only such for both directions: of a single-track road (lanes=1 without oneway, where cars
/// meet at passing places) one, of a reversible road all; 0 of other roads.
[[nodiscard]] int shared_lanes(const RoadPath& path);
/// 0 = least important (service) upwards; which road wins at a junction. Unknown values rank as service.
[[nodiscard]] int road_rank(const std::string& highway);
/// Speed in km/h that a class is built for in towns, and its limit where no law is known. 0: none (raceways).
[[nodiscard]] double default_speed_limit_kmh(const std::string& highway);
/// motorway ... service, track, raceway, busway; not footway, cycleway, path, steps, pedestrian.
[[nodiscard]] bool is_drivable(const std::string& highway);

/// The same road, its nodes in the other order: what the tags say of sides and directions changes sides.
void turn_round(RoadPath& path);

/// Sets s_m of its nodes from where they are; the first one is at 0.
void measure_path(RoadPath& path);

[[nodiscard]] Polyline centerline(const RoadPath& path);
/// Of all nodes.
[[nodiscard]] Box2 bounds_of_roads(const RoadNetwork& roads);
/// Ring of the carriageway polygon of a path: half the width to each side.
[[nodiscard]] Ring surface_ring(const RoadPath& path);
/// The same surface as one convex ring for each segment: their union is right also where a tight bend folds the ring
/// over itself.
[[nodiscard]] std::vector<Ring> surface_cells(const RoadPath& path);

}  // namespace orthodrive

// SPDX-License-Identifier: Apache-2.0
#include "roadquery/query/road_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "roadquery/surface/blend.hpp"
#include "roadquery/tables/baked_surface.hpp"
#include "roadquery/tables/junction_levels.hpp"
#include "roadquery/tables/overlaps.hpp"
#include "roadquery/tables/surface_search.hpp"

namespace roadquery {
namespace {

constexpr double coherent_level_m = 1.0;
/// No surface this far above or below a station's can win against it or be blended with it when it lies within
/// coherent_level_m of the hint.
constexpr double alone_level_m = 2.0 * coherent_level_m + same_level_m;

void fill_material(const BakedLane& lane, Hit& hit) {
  hit.surface = lane.surface, hit.friction = lane.friction, hit.roughness_m = lane.roughness_m;
}

void fill_place(const BakedRoads& roads, const Found& found, unsigned parts, Hit& hit) {
  const Station& q = roads.stations[found.station];
  const LaneStretch& lanes = roads.stretches[q.lanes];
  hit.road = static_cast<int>(lanes.road);
  if ((parts & hit_position) != 0 || ((parts & hit_material) != 0 && !lanes.one_material)) {
    hit.s = q.s + found.line.u, hit.t = found.on.t;
    if (const BakedLane* lane = lane_at(roads, lanes, hit.s, hit.t, edge_rounding_m)) {
      hit.lane_id = lane->id;
      fill_material(*lane, hit);
    }
  } else if ((parts & hit_material) != 0) {
    fill_material(roads.lanes[lanes.first], hit);
  }
  if (found.has_relief && !std::isnan(found.friction)) hit.friction = found.friction;
}

/// Normal and curvature at a found surface, relief included.
Bearing bearing_of(const BakedRoads& roads, const Found& found) {
  const Station& q = roads.stations[found.station];
  Bearing bearing = bearing_at(q, found.line, found.on);
  if (!found.has_relief) return bearing;
  const LinePlace& line = found.line;
  const double c = (q.cos_hdg * line.dx_du - q.sin_hdg * line.dy_du) * line.inverse_speed;
  const double n = (q.sin_hdg * line.dx_du + q.cos_hdg * line.dy_du) * line.inverse_speed;
  const double scale = 1.0 / std::sqrt(1.0 + found.rise_along * found.rise_along + found.rise_left * found.rise_left);
  bearing.normal[0] = (-found.rise_along * c + found.rise_left * n) * scale;
  bearing.normal[1] = (-found.rise_along * n - found.rise_left * c) * scale;
  bearing.normal[2] = scale;
  return bearing;
}

void fill_hit(const BakedRoads& roads, const Found& found, unsigned parts, Hit& hit) {
  fill_place(roads, found, parts, hit);
  hit.z = found.on.z;
  if ((parts & (hit_normal | hit_curvature)) == 0) return;
  const Bearing bearing = bearing_of(roads, found);
  hit.curvature = bearing.curvature;
  hit.normal = {bearing.normal[0], bearing.normal[1], bearing.normal[2]};
}

void fill_junction(const JunctionHeight& at, unsigned parts, Hit& hit) {
  hit.z = at.z, hit.in_junction = true;
  if ((parts & hit_normal) == 0) return;
  const double scale = 1.0 / std::sqrt(1.0 + at.dz_dx * at.dz_dx + at.dz_dy * at.dz_dy);
  hit.normal = {-at.dz_dx * scale, -at.dz_dy * scale, scale};
}

void fill_blended(const BakedRoads& roads, std::span<const Found> surfaces, const Found& named, unsigned parts,
                  Hit& hit) {
  fill_place(roads, named, parts, hit);
  Blend blend;
  if ((parts & (hit_normal | hit_curvature)) == 0) {
    for (const Found& found : surfaces) blend.add(found.inside_m, found.on.z);
    hit.z = blend.z();
    return;
  }
  for (const Found& found : surfaces) {
    const Bearing bearing = bearing_of(roads, found);
    blend.add(found.inside_m, found.on.z, bearing.normal);
    if (&found == &named) hit.curvature = bearing.curvature;
  }
  double normal[3];
  blend.get_normal(normal);
  hit.z = blend.z(), hit.normal = {normal[0], normal[1], normal[2]};
}

/// The cursor's station, or no_index for one of another map.
std::uint32_t station_of(const BakedRoads& roads, const Cursor& cursor) {
  const auto road = static_cast<std::uint32_t>(cursor.road);
  if (cursor.station < roads.stations.size() && roads.road_of(roads.stations[cursor.station]) == road)
    return cursor.station;
  if (cursor.road < 0 || static_cast<std::size_t>(cursor.road) + 1 >= roads.first_station.size()) return no_index;
  return roads.station_at(road, cursor.s);
}

/// The surface under the point near the station; false unless the point lies on it and z_hint near it: then it is of
/// the level that counts.
bool follow(const BakedRoads& roads, std::uint32_t station, double x, double y, double z_hint, Found& found) {
  constexpr int most_steps = 4;
  found.station = station;
  const Station& q = roads.stations[station];
  if (q.shape_count == unusable_station) return false;
  const FramePoint p = in_frame(q, x, y);
  if (q.turned != not_turned)
    turned_foot(roads, q, p, guess_u(q, p), found.line, found.on);
  else
    found.line = foot_on(q, p, guess_u(q, p));
  found.along_rest_m = 0.0;
  const LaneStretch& lanes = roads.stretches[q.lanes];
  if (holds(q, found.line.u)) {
    if (!complete(roads, q, lanes, x, y, edge_rounding_m, found)) return false;
  } else if (!find_on(roads, roads.stations_of(lanes.road), x, y, most_steps, edge_rounding_m, found)) {
    return false;
  }
  return found.along_rest_m <= edge_rounding_m && std::abs(found.on.z - z_hint) <= coherent_level_m;
}

/// Whether `parts` of a hit are known without the place on the road.
bool takes_no_foot(const LaneStretch& lanes, unsigned parts) {
  return (parts & (hit_position | hit_curvature | hit_own)) == 0 &&
         ((parts & hit_material) == 0 || lanes.one_material) && lanes.relief == 0;
}

/// Whether no other surface touches the found one's station there.
bool is_alone(const BakedRoads& roads, const Found& found) {
  const Station& q = roads.stations[found.station];
  return found.line.left_m >= q.free_right * free_step_m && found.line.left_m <= q.free_left * free_step_m;
}

constexpr auto any_road = [](const Found&) { return true; };

const Found& named_of(const BakedRoads& roads, std::span<const Found> level, int preferred_road) {
  if (level.size() == 1) return level.front();
  const auto is_preferred = [&](const Found& f) {
    return static_cast<int>(roads.road_of(roads.stations[f.station])) == preferred_road;
  };
  return *std::max_element(level.begin(), level.end(), [&](const Found& a, const Found& b) {
    if (is_preferred(a) != is_preferred(b)) return is_preferred(b);
    return a.inside_m < b.inside_m;
  });
}

}  // namespace

RoadQuery::RoadQuery(RoadMap map) : map_(std::move(map)), baked_(bake(map_)), junctions_(map_), cells_(baked_, map_) {
  find_overlaps(baked_, map_, cells_, alone_level_m);
  find_levels(baked_, map_, cells_);
  if (!map_.crgs || map_.crgs->empty()) return;
  for (LaneStretch& lanes : baked_.stretches)
    if (map_.crgs->on(static_cast<int>(lanes.road))) lanes.relief |= relief_crg;
  baked_.crgs = map_.crgs;
}

/// The surfaces under a point that make up one level.
struct RoadQuery::Level {
  std::span<Found> roads;
  JunctionOver junction;

  [[nodiscard]] bool empty() const { return roads.empty() && junction.junction == no_index; }
};

void RoadQuery::search_place(const Cell& cell, double x, double y, FoundList& list) const {
  junctions_.fetch_first(cell);
  StartList starts;
  find_starts(baked_, cell, edge_rounding_m, starts);
  junctions_.fetch_second(cell, x, y);
  search_starts(baked_, starts, x, y, edge_rounding_m, list);
  if (list.count == 0) search_stations(baked_, cell, x, y, edge_rounding_m, true, list);
}

/// `followed`: what follow() found, where other surfaces lie near it; else null.
RoadQuery::Level RoadQuery::search(double x, double y, double z_hint, const Found* followed, FoundList& list) const {
  if (followed != nullptr) {
    list.items[0] = *followed, list.count = 1;
    const std::uint32_t station = followed->station, deciding = baked_.deciding_junction[station].index;
    JunctionOver over;
    if (deciding < one_of_several)
      over = junctions_.over(deciding, x, y);
    else if (!junctions_.empty())
      over = junctions_.over(cells_.at(x, y), x, y, z_hint);
    if (over.junction != no_index && deciding != no_index) return {list.all(), over};
    search_companions(baked_, station, x, y, list);
    return with_junction(over, z_hint, list);
  }
  const Cell cell = cells_.at(x, y);
  search_place(cell, x, y, list);
  return with_junction(junctions_.over(cell, x, y, z_hint), z_hint, list);
}

/// A junction's own surface takes part in the choice of the level like a road's.
RoadQuery::Level RoadQuery::with_junction(const JunctionOver& over, double z_hint, FoundList& list) {
  if (over.junction == no_index) return {level_of(list, z_hint, any_road), {}};
  const auto distance = [&](double z) { return std::isnan(z_hint) ? -z : std::abs(z - z_hint); };
  double level_z = over.at.z;
  for (const Found& found : list.all())
    if (distance(found.on.z) < distance(level_z)) level_z = found.on.z;
  const std::span<Found> roads = level_of(list, level_z, any_road);
  if (!is_same_level(over.at.z, level_z)) return {roads, {}};
  return {list.count > 0 && !roads.empty() && is_same_level(roads.front().on.z, level_z) ? roads : std::span<Found>{},
          over};
}

/// The road of a junction whose lanes are nearest to a point between them.
std::optional<Found> RoadQuery::nearest_of_junction(std::uint32_t junction, double x, double y) const {
  constexpr double far_m = 100.0;
  constexpr int most_steps = 64;
  std::optional<Found> best;
  for (const std::uint32_t road : junctions_.roads(junction)) {
    const StationRange all{baked_.first_station[road], baked_.first_station[road + 1] - 1};
    if (baked_.first_station[road] == baked_.first_station[road + 1]) continue;
    Found found;
    found.station = all.first + (all.last - all.first) / 2;
    if (find_on(baked_, all, x, y, most_steps, far_m, found) && (!best || found.inside_m > best->inside_m))
      best = found;
  }
  return best;
}

bool RoadQuery::fill_level(const Level& level, double x, double y, unsigned parts, Cursor& cursor, Hit& hit) const {
  std::optional<Found> nearest;
  if (level.roads.empty()) nearest = nearest_of_junction(level.junction.junction, x, y);
  if (level.roads.empty() && !nearest) return false;
  const Found& named = nearest ? *nearest : named_of(baked_, level.roads, cursor.road);
  // Between the roads of a junction there is no road's own surface.
  const bool of_road = (parts & hit_own) != 0 && !nearest;
  const bool has_own_surface = level.junction.junction != no_index && !of_road;
  if (level.roads.size() > 1 && !has_own_surface && !of_road)
    fill_blended(baked_, level.roads, named, parts, hit);
  else
    fill_hit(baked_, named, has_own_surface ? parts & ~hit_normal : parts, hit);
  if (has_own_surface) fill_junction(level.junction.at, parts, hit);
  cursor = {hit.road, baked_.stations[named.station].s + named.line.u, named.station};
  return true;
}

/// Where one junction's own surface answers for all that lies over the station. What is asked of the road takes no
/// foot.
template <typename Answer>
bool RoadQuery::find_in_core(const StationJunction& junction, const Station& q, double x, double y, double z_hint,
                             unsigned parts, Answer& hit) const {
  const JunctionOver over = junctions_.over(junction.index, x, y);
  if (over.junction == no_index || !(std::abs(over.at.z - z_hint) <= coherent_level_m)) return false;
  const LaneStretch& lanes = baked_.stretches[q.lanes];
  hit.road = static_cast<int>(lanes.road);
  if constexpr (std::is_same_v<Answer, Hit>) {
    if ((parts & hit_material) != 0) fill_material(baked_.lanes[lanes.first], hit);
    fill_junction(over.at, parts, hit);
  } else {
    hit.z = over.at.z, hit.in_junction = true;
  }
  return true;
}

template <typename Answer>
RoadQuery::Followed RoadQuery::follow_cursor(double x, double y, double z_hint, Cursor& cursor, unsigned parts,
                                             Found& here, Answer& hit) const {
  const std::uint32_t station = station_of(baked_, cursor);
  if (station == no_index) return Followed::no;
  const Station& q = baked_.stations[station];
  const StationJunction& junction = baked_.deciding_junction[station];
  if (junction.core_right < junction.core_left && takes_no_foot(baked_.stretches[q.lanes], parts)) {
    const NearPlace near = near_place(q, x, y);
    if (is_in_core(q, junction, near) && find_in_core(junction, q, x, y, z_hint, parts, hit)) {
      cursor = {hit.road, q.s + near.u, station};
      return Followed::alone;
    }
  }
  if (!follow(baked_, station, x, y, z_hint, here)) return Followed::no;
  if (!is_alone(baked_, here)) return Followed::crowded;
  const Station& on = baked_.stations[here.station];
  if constexpr (std::is_same_v<Answer, Hit>)
    fill_hit(baked_, here, parts, hit);
  else
    hit.road = static_cast<int>(baked_.road_of(on)), hit.z = here.on.z;
  cursor.road = hit.road, cursor.s = on.s + here.line.u, cursor.station = here.station;
  return Followed::alone;
}

bool RoadQuery::find_among(const Found* followed, double x, double y, double z_hint, Cursor& cursor, unsigned parts,
                           Hit& hit) const {
  FoundList list;
  const Level level = search(x, y, z_hint, followed, list);
  if (!level.empty() && fill_level(level, x, y, parts, cursor, hit)) return true;
  cursor = {};
  return false;
}

bool RoadQuery::find(double x, double y, double z_hint, Cursor& cursor, unsigned parts, Hit& hit) const {
  Found here;
  const Followed followed = follow_cursor(x, y, z_hint, cursor, parts, here, hit);
  if (followed == Followed::alone) return true;
  return find_among(followed == Followed::crowded ? &here : nullptr, x, y, z_hint, cursor, parts, hit);
}

bool RoadQuery::find_height(double x, double y, double z_hint, Cursor& cursor, HeightHit& hit) const {
  Found here;
  const Followed followed = follow_cursor(x, y, z_hint, cursor, 0, here, hit);
  if (followed == Followed::alone) return true;
  Hit whole;
  const bool found = find_among(followed == Followed::crowded ? &here : nullptr, x, y, z_hint, cursor, 0, whole);
  hit = {whole.road, whole.z, whole.in_junction};
  return found;
}

void RoadQuery::find_batch(std::span<const std::array<double, 3>> points, std::span<Cursor> cursors,
                           std::span<std::optional<Hit>> hits) const {
  for (std::size_t i = 0; i < points.size(); ++i) hits[i] = find(points[i][0], points[i][1], points[i][2], cursors[i]);
}

std::optional<Hit> RoadQuery::at(std::size_t road, double s, double t) const {
  if (road >= map_.roads.size() || std::isnan(s) || !std::isfinite(t)) return std::nullopt;
  Found found;
  found.station = baked_.station_at(road, std::clamp(s, 0.0, map_.roads[road].length));
  if (found.station == no_index || baked_.stations[found.station].shape_count == unusable_station) return std::nullopt;
  const Station& q = baked_.stations[found.station];
  const double half = q.half_m;
  found.line = place_at(q, std::clamp(s - q.s, -half, half), {});
  surface_at_t(baked_, q, found.line.u, t, found.on);
  found.has_relief = baked_.stretches[q.lanes].relief != 0;
  if (found.has_relief) {
    const SurfacePoint p = surface_point(map_.roads[road], q.s + found.line.u, t);
    lay_relief(baked_, q, p.x, p.y, found);
  }
  Hit hit;
  fill_hit(baked_, found, hit_all, hit);
  return hit;
}

std::optional<RoadSection> RoadQuery::section(std::size_t road, double s) const {
  constexpr double rounding_m = 1e-6;  // at a break the cubics that begin there count, as in the exact functions
  if (road >= map_.roads.size() || std::isnan(s)) return std::nullopt;
  s = std::clamp(s, 0.0, map_.roads[road].length);
  const std::uint32_t station = baked_.station_at(road, s + rounding_m);
  if (station == no_index || baked_.stations[station].shape_count == unusable_station) return std::nullopt;
  const Station& q = baked_.stations[station];
  const double u = s - q.s;
  const LinePolynomial line = line_at(q, u);
  const auto point = [&](double t) {
    SurfacePlace on;
    surface_at_t(baked_, q, u, t, on);
    const FramePoint at = place_beside(line, {on.ahead_m, t * on.cos_bank - on.h * on.sin_bank});
    return std::array{q.x + at.along * q.cos_hdg - at.left * q.sin_hdg,
                      q.y + at.along * q.sin_hdg + at.left * q.cos_hdg, on.z};
  };
  const Edges edges = road_edges(map_.roads[road], s);
  return RoadSection{point(edges.left_t), point(edges.right_t), point(0.0)};
}

/// Of the surfaces that end or go by at most reach_m from the point the nearest one of the level's roads.
std::span<Found> RoadQuery::nearest_beside(double x, double y, double reach_m, const std::vector<bool>& is_on_level,
                                           FoundList& list) const {
  list.count = 0;
  const CellEntry* looked_at[4] = {};
  for (int corner = 0; corner < 4; ++corner) {
    const double dx = corner % 2 == 0 ? -reach_m : reach_m, dy = corner < 2 ? -reach_m : reach_m;
    const Cell cell = cells_.at(x + dx, y + dy);
    looked_at[corner] = cell.entries.data();
    if (std::find(looked_at, looked_at + corner, cell.entries.data()) != looked_at + corner) continue;
    // The point's place in its own cell goes by the cell's corner.
    search_stations(baked_, {cell.entries, cell.x - static_cast<float>(dx), cell.y - static_cast<float>(dy)}, x, y,
                    reach_m, false, list);
  }
  const Found* nearest = nullptr;
  for (const Found& found : list.all())
    if (is_on_level[baked_.road_of(baked_.stations[found.station])] && found.inside_m >= -reach_m &&
        (nearest == nullptr || found.inside_m > nearest->inside_m))
      nearest = &found;
  return nearest == nullptr ? std::span<Found>{}
                            : list.all().subspan(static_cast<std::size_t>(nearest - list.all().data()), 1);
}

std::optional<SurfaceSample> RoadQuery::sample(double x, double y, double reach_m,
                                               const std::vector<bool>& is_on_level) const {
  const auto is_anchor = [&](const Found& f) { return is_on_level[baked_.road_of(baked_.stations[f.station])]; };
  FoundList list;
  const Cell cell = cells_.at(x, y);
  search_place(cell, x, y, list);
  double highest = std::numeric_limits<double>::quiet_NaN();
  for (const Found& found : list.all())
    if (is_anchor(found) && !(found.on.z <= highest)) highest = found.on.z;
  Level level;
  if (!std::isnan(highest)) {
    level = with_junction(junctions_.over(cell, x, y, highest), highest, list);
  } else {  // between the roads of a junction
    level.junction = junctions_.over(cell, x, y, highest);
    const auto is_own = [&](std::uint32_t road) { return is_on_level[road]; };
    if (level.junction.junction != no_index) {
      const auto own = junctions_.roads(level.junction.junction);
      if (std::none_of(own.begin(), own.end(), is_own)) level.junction = {};
    }
  }
  constexpr double chord_m = 0.03;  // points of a mesh's border miss the road's by about this
  if (level.empty() && reach_m > chord_m) level.roads = nearest_beside(x, y, chord_m, is_on_level, list);
  if (level.empty() && reach_m > 0.0) level.roads = nearest_beside(x, y, reach_m, is_on_level, list);
  if (level.empty()) return std::nullopt;
  Cursor cursor;
  Hit hit;
  if (!fill_level(level, x, y, hit_normal, cursor, hit)) return std::nullopt;
  SurfaceSample sample{hit.z, hit.normal, 0.0};
  constexpr double between_roads_m = 1e-3;
  sample.inside_m = level.roads.empty() ? between_roads_m : named_of(baked_, level.roads, -1).inside_m;
  return sample;
}

}  // namespace roadquery

// SPDX-License-Identifier: Apache-2.0
// C interface: what is under a point, and where a point of a road is.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "roadquery/c_map.hpp"
#include "roadquery/query/contact_patch.hpp"

namespace {

using roadquery::Cursor;
using roadquery::Hit;
using roadquery::Place;

constexpr bool is_same(int flag, unsigned part) { return static_cast<unsigned>(flag) == part; }
static_assert(is_same(RQ_NORMAL, roadquery::hit_normal) && is_same(RQ_POSITION, roadquery::hit_position) &&
              is_same(RQ_CURVATURE, roadquery::hit_curvature) && is_same(RQ_MATERIAL, roadquery::hit_material) &&
              is_same(RQ_OWN, roadquery::hit_own));

constexpr double no_guess = std::numeric_limits<double>::quiet_NaN();

constexpr int status_of(Place place) {
  switch (place) {
    case Place::none:
      return RQ_NONE;
    case Place::road:
      return RQ_ROAD;
    case Place::junction:
      return RQ_JUNCTION;
    case Place::terrain:
      return RQ_TERRAIN;
  }
  return RQ_NONE;
}

/// A cursor that a program has filled with nonsense is a cursor of the start.
Cursor read_cursor(const rq_cursor& given) {
  Cursor cursor;
  if (std::isfinite(given.s))
    cursor.road = given.road, cursor.s = given.s, cursor.station = static_cast<std::uint32_t>(given.station);
  return cursor;
}
void write_cursor(const Cursor& cursor, rq_cursor& given) {
  given.road = cursor.road, given.s = cursor.s, given.station = static_cast<int32_t>(cursor.station);
}

/// One query with everything checked that is not the library's own. `hit` is fresh.
int find(const rq_map& map, rq_cursor& cursor, double x, double y, double z_guess, unsigned what, Hit& hit) {
  if (!std::isfinite(x) || !std::isfinite(y)) return RQ_BAD_INPUT;
  Cursor at = read_cursor(cursor);
  const Place place = map.ground.find(x, y, z_guess, at, what & (RQ_ALL | RQ_OWN), hit);
  write_cursor(at, cursor);
  return status_of(place);
}

void fill(const rq_map& map, const Hit& hit, unsigned what, rq_hit& out) {
  out.z = hit.z;
  if ((what & RQ_NORMAL) != 0) std::copy(hit.normal.begin(), hit.normal.end(), out.normal);
  if ((what & RQ_POSITION) != 0) {
    const roadquery::RoadIds ids = hit.road >= 0 ? map.ground.ids(hit.road) : roadquery::RoadIds{};
    out.road_id = ids.road;
    out.junction_id = ids.junction;
    out.lane_id = hit.lane_id;
    out.s = hit.s, out.t = hit.t;
  }
  if ((what & RQ_CURVATURE) != 0) out.curvature = hit.curvature;
  if ((what & RQ_MATERIAL) != 0) {
    out.surface_class = static_cast<int32_t>(hit.surface);
    out.friction = hit.friction;
    out.roughness = hit.roughness_m;
  }
}

/// Element i of an array with any stride; doubles of a packed struct need not be aligned.
template <typename T>
T element(const T* first, std::size_t stride_bytes, std::size_t i) {
  T value;
  std::memcpy(&value, reinterpret_cast<const char*>(first) + stride_bytes * i, sizeof value);
  return value;
}
template <typename T>
T& slot(T* first, std::size_t stride_bytes, std::size_t i) {
  return *reinterpret_cast<T*>(reinterpret_cast<char*>(first) + stride_bytes * i);
}

double turned_to_pi(double angle) { return std::remainder(angle, 2.0 * M_PI); }

}  // namespace

int rq_query(const rq_map* map, rq_cursor* cursor, double x, double y, double z_guess, unsigned what, rq_hit* hit) {
  if (hit == nullptr) return RQ_BAD_INPUT;
  Hit found;
  hit->status = map == nullptr || cursor == nullptr ? static_cast<int32_t>(RQ_BAD_INPUT)
                                                    : find(*map, *cursor, x, y, z_guess, what, found);
  if (hit->status > 0) fill(*map, found, what, *hit);
  return hit->status;
}

int rq_height(const rq_map* map, rq_cursor* cursor, double x, double y, double z_guess, double* z) {
  if (map == nullptr || cursor == nullptr || z == nullptr) return RQ_BAD_INPUT;
  if (!std::isfinite(x) || !std::isfinite(y)) return RQ_BAD_INPUT;
  Cursor at = read_cursor(*cursor);
  double found_z = 0.0;
  const int status = status_of(map->ground.find_height(x, y, z_guess, at, found_z));
  write_cursor(at, *cursor);
  if (status > 0) *z = found_z;
  return status;
}

int64_t rq_query_batch(const rq_map* map, size_t count, const double* x, const double* y, const double* z_guess,
                       size_t stride_bytes, rq_cursor* cursors, unsigned what, rq_hit* hits, size_t hit_stride_bytes) {
  if (map == nullptr || x == nullptr || y == nullptr || hits == nullptr || hit_stride_bytes < sizeof(rq_hit))
    return RQ_BAD_INPUT;
  rq_cursor own = RQ_CURSOR_START;
  int64_t with_surface = 0;
  for (size_t i = 0; i < count; ++i) {
    const double guess = z_guess == nullptr ? no_guess : element(z_guess, stride_bytes, i);
    with_surface += rq_query(map, cursors == nullptr ? &own : cursors + i, element(x, stride_bytes, i),
                             element(y, stride_bytes, i), guess, what, &slot(hits, hit_stride_bytes, i)) > 0;
  }
  return with_surface;
}

int rq_terrain_height(const rq_map* map, double x, double y, double* z) {
  if (map == nullptr || z == nullptr || !std::isfinite(x) || !std::isfinite(y)) return RQ_BAD_INPUT;
  const auto& terrain = map->ground.terrain();
  const auto point = terrain ? roadquery::evaluate(*terrain, x, y) : std::nullopt;
  if (!point) return RQ_NONE;
  *z = point->z;
  return RQ_TERRAIN;
}

int rq_contact_patch(const rq_map* map, rq_cursor* cursor, double x, double y, double z_guess, double heading,
                     double length, double width, int along, int across, rq_patch* patch) {
  if (patch == nullptr) return RQ_BAD_INPUT;
  if (along == 0) along = 5;
  if (across == 0) across = 3;
  const auto is_size = [](double metres) { return metres > 0.0 && metres <= 1000.0; };
  const auto is_count = [](int parts) { return parts >= 1 && parts <= 32; };
  if (map == nullptr || cursor == nullptr || !std::isfinite(x) || !std::isfinite(y) || !std::isfinite(heading) ||
      !is_size(length) || !is_size(width) || !is_count(along) || !is_count(across))
    return patch->status = RQ_BAD_INPUT;
  Cursor at = read_cursor(*cursor);
  const roadquery::ContactPatch found =
      contact_patch(map->ground, {x, y, z_guess, heading, length, width, along, across}, at);
  write_cursor(at, *cursor);
  *patch = {status_of(found.place),
            found.partial ? 1 : 0,
            found.covered,
            found.z,
            {found.normal[0], found.normal[1], found.normal[2]},
            found.residual_m,
            found.friction,
            {}};
  return patch->status;
}

int rq_position(const rq_map* map, int32_t road_id, double s, double t, rq_pose* pose) {
  if (pose == nullptr) return RQ_BAD_INPUT;
  const int index = map == nullptr || !std::isfinite(s) || !std::isfinite(t) ? -1 : map->road_index(road_id);
  if (index < 0) return pose->status = RQ_BAD_INPUT;
  const roadquery::Road& road = map->roads().roads[static_cast<std::size_t>(index)];
  if (s < 0.0 || s > road.length) return pose->status = RQ_NONE;
  const roadquery::Edges edges = roadquery::road_edges(road, s);
  const bool inside = t <= edges.left_t && t >= edges.right_t;
  const roadquery::SurfacePoint point = inside ? map->ground.point(index, s, t) : roadquery::surface_point(road, s, t);
  *pose = {!inside             ? static_cast<int32_t>(RQ_NONE)
           : road.junction < 0 ? static_cast<int32_t>(RQ_ROAD)
                               : static_cast<int32_t>(RQ_JUNCTION),
           inside ? roadquery::lane_id_at(road, s, t) : 0,
           point.x,
           point.y,
           point.z,
           turned_to_pi(roadquery::reference_point(road, s).hdg),
           {point.normal[0], point.normal[1], point.normal[2]},
           {}};
  return pose->status;
}

int64_t rq_position_batch(const rq_map* map, size_t count, const int32_t* road_ids, size_t road_stride_bytes,
                          const double* s, const double* t, size_t stride_bytes, rq_pose* poses,
                          size_t pose_stride_bytes) {
  if (map == nullptr || road_ids == nullptr || s == nullptr || t == nullptr || poses == nullptr ||
      pose_stride_bytes < sizeof(rq_pose))
    return RQ_BAD_INPUT;
  int64_t on_road = 0;
  for (size_t i = 0; i < count; ++i)
    on_road += rq_position(map, element(road_ids, road_stride_bytes, i), element(s, stride_bytes, i),
                           element(t, stride_bytes, i), &slot(poses, pose_stride_bytes, i)) > 0;
  return on_road;
}

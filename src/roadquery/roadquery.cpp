// SPDX-License-Identifier: Apache-2.0
// C interface: loading, and what is in the map.

#include "roadquery/roadquery.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <new>

#include "roadquery/c_map.hpp"
#include "roadquery/roads/speed_limits.hpp"

namespace {

void explain(const char* what, char* problem, size_t problem_bytes) {
  if (problem == nullptr || problem_bytes == 0) return;
  const size_t count = std::min(std::strlen(what), problem_bytes - 1);
  std::memcpy(problem, what, count);
  problem[count] = '\0';
}

/// The caller's options over the defaults: a program of before has a shorter struct.
bool read_options(const rq_options* given, rq_options& options) {
  options = RQ_OPTIONS_DEFAULT;
  if (given == nullptr) return true;
  if (given->size < offsetof(rq_options, header_offset) + sizeof(int32_t)) return false;
  std::memcpy(&options, given, std::min(given->size, sizeof options));
  return options.header_offset >= RQ_OFFSET_ADD && options.header_offset <= RQ_OFFSET_SUBTRACT &&
         (options.ignore_crg == 0 || options.ignore_crg == 1) && options.verge_m >= 0.0 && options.verge_m <= 100.0;
}

rq_error error_of(roadquery::GroundStage stage) {
  switch (stage) {
    case roadquery::GroundStage::network:
      return RQ_ERROR_NETWORK;
    case roadquery::GroundStage::terrain:
      return RQ_ERROR_TERRAIN;
    case roadquery::GroundStage::crg:
      return RQ_ERROR_CRG;
  }
  return RQ_ERROR_INTERNAL;
}

}  // namespace

int rq_map::road_index(int32_t id) const {
  const auto& all = roads().roads;
  const auto at = std::lower_bound(all.begin(), all.end(), id, [](const auto& road, int key) { return road.id < key; });
  return at != all.end() && at->id == id ? static_cast<int>(at - all.begin()) : -1;
}

int rq_abi_version(void) { return RQ_ABI_VERSION; }

const char* rq_error_text(int error) {
  switch (error) {
    case RQ_OK:
      return "no error";
    case RQ_ERROR_ARGUMENT:
      return "an argument is NULL or an option is not valid";
    case RQ_ERROR_NETWORK:
      return "the OpenDRIVE file cannot be read";
    case RQ_ERROR_TERRAIN:
      return "the terrain grid cannot be read";
    case RQ_ERROR_CRG:
      return "an OpenCRG file cannot be read";
    case RQ_ERROR_MEMORY:
      return "out of memory";
    case RQ_ERROR_INTERNAL:
      return "internal error";
    default:
      return "unknown error";
  }
}

rq_error rq_load(const char* path, const rq_options* given, rq_map** map, char* problem, size_t problem_bytes) {
  rq_options options;
  if (map != nullptr) *map = nullptr;
  if (path == nullptr || map == nullptr || !read_options(given, options)) {
    explain(path == nullptr  ? "no path given"
            : map == nullptr ? "no place for the map given"
                             : "options are not valid",
            problem, problem_bytes);
    return RQ_ERROR_ARGUMENT;
  }
  roadquery::GroundStage stage = roadquery::GroundStage::network;
  try {
    *map = new rq_map{roadquery::read_ground(
        {.network = path,
         .offset = static_cast<roadquery::HeaderOffset>(options.header_offset),
         .terrain = options.terrain_file == nullptr ? "" : options.terrain_file,
         .verge_m = options.verge_m,
         .ignore_crg = options.ignore_crg != 0,
         .crg_folder = options.crg_folder == nullptr ? std::nullopt : std::optional<std::string>(options.crg_folder)},
        stage)};
    return RQ_OK;
  } catch (const std::bad_alloc&) {
    explain("out of memory", problem, problem_bytes);
    return RQ_ERROR_MEMORY;
  } catch (const std::exception& error) {
    explain(error.what(), problem, problem_bytes);
    return error_of(stage);
  } catch (...) {
    explain("internal error", problem, problem_bytes);
    return RQ_ERROR_INTERNAL;
  }
}

void rq_free(rq_map* map) { delete map; }

int32_t rq_road_count(const rq_map* map) {
  return map == nullptr ? RQ_BAD_INPUT : static_cast<int32_t>(map->roads().roads.size());
}

int rq_get_road(const rq_map* map, int32_t index, rq_road* road) {
  if (map == nullptr || road == nullptr || index < 0 || index >= rq_road_count(map)) return RQ_BAD_INPUT;
  const roadquery::Road& r = map->roads().roads[static_cast<std::size_t>(index)];
  *road = {r.id,
           r.junction,
           r.length,
           r.speed_limit_mps,
           static_cast<int32_t>(r.predecessor.kind),
           r.predecessor.id,
           static_cast<int32_t>(r.successor.kind),
           r.successor.id,
           r.driving_side == roadquery::DrivingSide::left ? 1 : 0,
           r.bridge ? 1 : 0,
           r.tunnel ? 1 : 0,
           0,
           {}};
  return 1;
}

int32_t rq_junction_count(const rq_map* map) {
  return map == nullptr ? RQ_BAD_INPUT : static_cast<int32_t>(map->roads().junctions.size());
}

int rq_get_junction(const rq_map* map, int32_t index, int32_t* junction_id) {
  if (map == nullptr || junction_id == nullptr || index < 0 || index >= rq_junction_count(map)) return RQ_BAD_INPUT;
  *junction_id = map->roads().junctions[static_cast<std::size_t>(index)].id;
  return 1;
}

int32_t rq_lanes_at(const rq_map* map, int32_t road_id, double s, rq_lane* lanes, int32_t capacity) {
  const int index = map == nullptr || !std::isfinite(s) ? -1 : map->road_index(road_id);
  if (index < 0 || capacity < 0 || (lanes == nullptr && capacity > 0)) return RQ_BAD_INPUT;
  const roadquery::Road& road = map->roads().roads[static_cast<std::size_t>(index)];
  if (s < 0.0 || s > road.length) return RQ_BAD_INPUT;
  const roadquery::LaneSection& section = roadquery::section_at(road, s);
  const double middle = roadquery::evaluate(road.lane_offset, s);
  const auto right = static_cast<int32_t>(section.right.size()), left = static_cast<int32_t>(section.left.size());
  const auto put = [&](int32_t place, const roadquery::Lane& lane, double t_right, double t_left) {
    if (place < capacity)
      lanes[place] = {
          lane.id, static_cast<int32_t>(lane.type), t_right, t_left, roadquery::lane_limit_mps(road, lane.id, s), {}};
  };
  double t = middle;
  for (int32_t i = 0; i < right; ++i) {
    const roadquery::Lane& lane = section.right[static_cast<std::size_t>(i)];
    const double width = roadquery::lane_width(lane, s - section.s);
    put(right - 1 - i, lane, t - width, t);
    t -= width;
  }
  t = middle;
  for (int32_t i = 0; i < left; ++i) {
    const roadquery::Lane& lane = section.left[static_cast<std::size_t>(i)];
    const double width = roadquery::lane_width(lane, s - section.s);
    put(right + i, lane, t, t + width);
    t += width;
  }
  return right + left;
}

const char* rq_road_text_id(const rq_map* map, int32_t road_id) {
  const int index = map == nullptr ? -1 : map->road_index(road_id);
  return index < 0 ? nullptr : map->roads().roads[static_cast<std::size_t>(index)].text_id.c_str();
}

int32_t rq_note_count(const rq_map* map) {
  return map == nullptr ? RQ_BAD_INPUT : static_cast<int32_t>(map->roads().notes.size());
}

const char* rq_note(const rq_map* map, int32_t index) {
  if (map == nullptr || index < 0 || index >= rq_note_count(map)) return nullptr;
  return map->roads().notes[static_cast<std::size_t>(index)].message.c_str();
}

const char* rq_geo_reference(const rq_map* map) {
  return map == nullptr ? nullptr : map->roads().geo_reference.c_str();
}

int rq_header_offset(const rq_map* map, double offset[4]) {
  if (map == nullptr || offset == nullptr) return RQ_BAD_INPUT;
  const auto& roads = map->roads();
  for (std::size_t k = 0; k < 3; ++k) offset[k] = roads.header_offset_m[k];
  offset[3] = roads.header_offset_hdg;
  return 1;
}

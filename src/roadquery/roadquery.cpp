#include "roadquery/roadquery.h"

#include <algorithm>
#include <cstring>
#include <exception>

#include "roadquery/road_query.hpp"

struct rq_map {
  roadquery::RoadQuery query;
};

namespace {

void explain(const char* what, char* problem, size_t problem_bytes) {
  if (problem == nullptr || problem_bytes == 0) return;
  const size_t count = std::min(std::strlen(what), problem_bytes - 1);
  std::memcpy(problem, what, count);
  problem[count] = '\0';
}

}  // namespace

rq_map* rq_load(const char* path, char* problem, size_t problem_bytes) {
  if (path == nullptr) {
    explain("no path given", problem, problem_bytes);
    return nullptr;
  }
  try {
    return new rq_map{roadquery::RoadQuery(roadquery::read_opendrive(path))};
  } catch (const std::exception& error) {
    explain(error.what(), problem, problem_bytes);
    return nullptr;
  }
}

void rq_free(rq_map* map) { delete map; }

int rq_query(const rq_map* map, rq_cursor* cursor, double x, double y, double z_hint, rq_hit* hit) {
  if (map == nullptr || cursor == nullptr || hit == nullptr) return 0;
  roadquery::Cursor at{cursor->road, cursor->s};
  const auto found = map->query.find(x, y, z_hint, at);
  *cursor = {at.road, at.s};
  if (!found) return 0;
  *hit = {map->query.map().roads[static_cast<std::size_t>(found->road)].id,
          found->lane_id,
          found->s,
          found->t,
          found->z,
          {found->normal[0], found->normal[1], found->normal[2]}};
  return 1;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* A simulator in C: asks for the road below a point, and for what lies around it.
 * Usage: query FILE X Y Z [TERRAIN.asc] */
#include <math.h>
#include <roadquery/roadquery.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char** argv) {
  char problem[256];
  rq_options options = RQ_OPTIONS_DEFAULT;
  rq_cursor cursor = RQ_CURSOR_START;
  rq_hit hit;
  rq_map* map;
  int i, counts[4] = {0, 0, 0, 0};
  if (argc != 5 && argc != 6) return 2;
  options.terrain_file = argc == 6 ? argv[5] : NULL;
  if (rq_load(argv[1], &options, &map, problem, sizeof problem) != RQ_OK) {
    fprintf(stderr, "%s\n", problem);
    return 1;
  }
  const double x = strtod(argv[2], NULL), y = strtod(argv[3], NULL), z = strtod(argv[4], NULL);
  const int found = rq_query(map, &cursor, x, y, z, RQ_ALL, &hit) > 0;
  if (found) printf("road %d lane %d z %.3f\n", hit.road_id, hit.lane_id, hit.z);
  for (i = 0; i < 41 * 41; ++i) {
    const int east_m = i % 41 - 20, north_m = i / 41 - 20;
    const int status = rq_query(map, &cursor, x + east_m, y + north_m, z, RQ_ALL, &hit);
    if (status < 0 || !(fabs(hit.z - z) < 20.0)) return 3;
    ++counts[status];
  }
  printf("around it: %d nothing, %d road, %d junction, %d terrain\n", counts[0], counts[1], counts[2], counts[3]);
  rq_free(map);
  return found ? 0 : 1;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* How high is the road under a wheel? Loads an OpenDRIVE file and asks along a straight line across it, as a simulator
 * asks a thousand times a second for each tyre. Plain C and libroadquery.so, nothing else.
 *
 * Read first: src/roadquery/roadquery.h. What the numbers mean: docs/c_interface.md. Next: 02_read_a_network.cpp.
 *
 *   example_query_a_network FILE.xodr X0 Y0 X1 Y1      every metre from (X0, Y0) to (X1, Y1), in the file's coordinates
 */
#include <math.h>
#include <roadquery/roadquery.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char** argv) {
  rq_options options = RQ_OPTIONS_DEFAULT;
  rq_cursor cursor = RQ_CURSOR_START; /* remembers where the last query ended: one for every moving point */
  rq_map* map;
  char problem[256];
  double x0, y0, x1, y1, z = NAN; /* NaN: the highest surface; then the one nearest to the last height */
  int i, steps, hits = 0;
  if (argc != 6) return fprintf(stderr, "usage: %s FILE.xodr X0 Y0 X1 Y1\n", argv[0]), 2;

  options.header_offset = RQ_OFFSET_IGNORE; /* coordinates as they stand in the file */
  if (rq_load(argv[1], &options, &map, problem, sizeof problem) != RQ_OK) return fprintf(stderr, "%s\n", problem), 1;
  printf("%d roads, coordinates of %s\n", rq_road_count(map), rq_geo_reference(map));

  x0 = strtod(argv[2], NULL), y0 = strtod(argv[3], NULL), x1 = strtod(argv[4], NULL), y1 = strtod(argv[5], NULL);
  steps = (int)ceil(hypot(x1 - x0, y1 - y0));
  printf("      x       y       z  road  lane       s       t  friction\n");
  for (i = 0; i <= steps; ++i) {
    const double share = steps > 0 ? (double)i / steps : 0.0, x = x0 + share * (x1 - x0), y = y0 + share * (y1 - y0);
    rq_hit hit;
    if (rq_query(map, &cursor, x, y, z, RQ_ALL, &hit) <= 0) continue; /* no road here */
    z = hit.z;
    ++hits;
    printf("%7.2f %7.2f %7.3f %5d %5d %7.2f %7.2f %9.2f\n", x, y, hit.z, hit.road_id, hit.lane_id, hit.s, hit.t,
           hit.friction);
  }
  printf("%d of %d points lie on a road\n", hits, steps + 1);
  rq_free(map);
  return 0;
}

/* The C interface in plain C99: load, query, errors. Prints what failed; exit code 0 when all is well. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "roadquery/roadquery.h"

static int failures = 0;
#define CHECK(condition)                                              \
  do {                                                                \
    if (!(condition)) {                                               \
      ++failures;                                                     \
      fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
    }                                                                 \
  } while (0)

int main(int argc, char** argv) {
  char problem[256] = "", cut[10];
  rq_map* map;
  rq_cursor cursor = RQ_CURSOR_START;
  rq_hit hit;
  if (argc != 2) return 2;

  map = rq_load(argv[1], problem, sizeof problem);
  CHECK(map != NULL);
  if (map == NULL) {
    fprintf(stderr, "%s\n", problem);
    return 1;
  }
  /* Half way along the quarter circle about (0, 100), 2 m outside of it (right). */
  CHECK(rq_query(map, &cursor, 102.0 * sqrt(0.5), 100.0 - 102.0 * sqrt(0.5), 20.0, &hit) == 1);
  CHECK(hit.road_id == 7 && hit.lane_id == -1);
  CHECK(fabs(hit.s - 78.5398163397448) < 1e-6 && fabs(hit.t + 2.0) < 1e-6);
  CHECK(fabs(hit.z - (20.0 + 0.02 * 78.5398163397448)) < 1e-6);
  CHECK(hit.normal[2] > 0.999 && hit.normal[2] < 1.0);
  CHECK(rq_query(map, &cursor, 50.0, 90.0, 20.0, &hit) == 0); /* inside of the bend, off the road */
  CHECK(rq_query(NULL, &cursor, 0.0, 0.0, 0.0, &hit) == 0);
  rq_free(map);
  rq_free(NULL);

  CHECK(rq_load("no_such_file.xodr", problem, sizeof problem) == NULL);
  CHECK(strstr(problem, "no_such_file.xodr: cannot be opened") == problem);
  CHECK(rq_load("no_such_file.xodr", cut, sizeof cut) == NULL);
  CHECK(strcmp(cut, "no_such_f") == 0);
  CHECK(rq_load(NULL, NULL, 0) == NULL);
  return failures == 0 ? 0 : 1;
}

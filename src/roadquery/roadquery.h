/* C interface of the road query, for simulators in any language. Exports of libroadquery.so; no exception leaves it.
 *
 *   char problem[256];
 *   rq_map* map = rq_load("roads.xodr", problem, sizeof problem);
 *   rq_cursor cursor = RQ_CURSOR_START;          one for every moving point
 *   rq_hit hit;
 *   if (rq_query(map, &cursor, x, y, z, &hit)) ...hit.z, hit.normal
 *   rq_free(map);
 *
 * A map may be queried from many threads at once, each with its own cursors. */
#ifndef ROADQUERY_H
#define ROADQUERY_H

#include <stddef.h>

#if defined(__GNUC__)
#define RQ_API __attribute__((visibility("default")))
#else
#define RQ_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rq_map rq_map;

/* Where the last query of a point ended. */
typedef struct rq_cursor {
  int road;
  double s;
} rq_cursor;
#define RQ_CURSOR_START \
  { -1, 0.0 }

typedef struct rq_hit {
  int road_id;      /* OpenDRIVE id */
  int lane_id;      /* OpenDRIVE id of the lane */
  double s, t;      /* m, OpenDRIVE road coordinates */
  double z;         /* m, height of the surface */
  double normal[3]; /* unit, upwards */
} rq_hit;

/* Reads an OpenDRIVE file (1.4 - 1.8). NULL on failure, with one line of explanation in `problem` (cut to
 * problem_bytes; may be NULL with 0). */
RQ_API rq_map* rq_load(const char* path, char* problem, size_t problem_bytes);
/* Frees a map; NULL is fine. */
RQ_API void rq_free(rq_map* map);
/* Surface under (x, y): 1 and *hit filled in, or 0 when there is no road. Among surfaces above each other the one
 * nearest to z_hint; NaN: the highest. */
RQ_API int rq_query(const rq_map* map, rq_cursor* cursor, double x, double y, double z_hint, rq_hit* hit);

#ifdef __cplusplus
}
#endif
#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* C interface of the road query, for simulators in any language. Exports of libroadquery.so; no exception leaves it.
 *
 *   rq_map* map;
 *   char problem[256];
 *   if (rq_load("roads.xodr", NULL, &map, problem, sizeof problem) != RQ_OK) ...problem says why
 *   rq_cursor cursor = RQ_CURSOR_START;          one for every moving point
 *   rq_hit hit;
 *   if (rq_query(map, &cursor, x, y, z, RQ_ALL, &hit) > 0) ...hit.z, hit.normal, hit.friction
 *   rq_free(map);
 *
 * Lengths in m, angles in rad, x east, y north, z up, in the coordinates that rq_options.header_offset chooses.
 * After rq_load no function allocates, locks or calls the system. A map may be queried from many threads at once, each
 * with its own cursors. What the numbers mean: docs/c_interface.md. */
#ifndef ROADQUERY_H
#define ROADQUERY_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define RQ_API __attribute__((visibility("default")))
#else
#define RQ_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The number changes, with the SONAME, when a program must be compiled anew. Fields are added in reserved places, and
 * at the end of rq_options, without it. */
#define RQ_ABI_VERSION 2
RQ_API int rq_abi_version(void);

/* ---- loading ---- */

typedef struct rq_map rq_map;

typedef enum rq_error {
  RQ_OK = 0,
  RQ_ERROR_ARGUMENT = 1, /* a pointer is NULL, an option is not one of those below */
  RQ_ERROR_NETWORK = 2,  /* the OpenDRIVE file cannot be opened, read or understood */
  RQ_ERROR_TERRAIN = 3,  /* the terrain grid cannot be opened, read or understood */
  RQ_ERROR_CRG = 4,      /* an OpenCRG file that the OpenDRIVE file names cannot be opened, read or understood */
  RQ_ERROR_MEMORY = 5,
  RQ_ERROR_INTERNAL = 6
} rq_error;
/* What a number of rq_error means; "unknown error" for others. Never NULL. */
RQ_API const char* rq_error_text(int error);

/* <offset> of the OpenDRIVE header (x, y, z). Readers disagree on it: docs/c_interface.md says who does what. */
enum {
  RQ_OFFSET_ADD = 0,     /* file + offset: the coordinates of the geoReference, as ASAM describes it */
  RQ_OFFSET_IGNORE = 1,  /* as in the file */
  RQ_OFFSET_SUBTRACT = 2 /* file - offset */
};

typedef struct rq_options {
  size_t size;              /* sizeof(rq_options) */
  int32_t header_offset;    /* RQ_OFFSET_... */
  int32_t ignore_crg;       /* 1: without the OpenCRG files that the roads name */
  const char* crg_folder;   /* where they are; NULL: beside the OpenDRIVE file */
  const char* terrain_file; /* ESRI ASCII grid (.asc) in the CRS of the geoReference; NULL: none */
  double verge_m;           /* from a road's edge the ground goes to the terrain over this width */
} rq_options;
#define RQ_OPTIONS_DEFAULT \
  { sizeof(rq_options), RQ_OFFSET_ADD, 0, NULL, NULL, 5.0 }

/* Reads an OpenDRIVE file (1.1 - 1.8). options may be NULL. On failure *map is NULL, and `problem` holds one line of
 * explanation (cut to problem_bytes; may be NULL with 0). */
RQ_API rq_error rq_load(const char* path, const rq_options* options, rq_map** map, char* problem, size_t problem_bytes);
/* Frees a map; NULL is fine. */
RQ_API void rq_free(rq_map* map);

/* ---- what is under a point? ---- */

/* Result of a query: > 0 when there is a surface. */
enum {
  RQ_BAD_INPUT = -1, /* NULL, x or y not finite; for poses also a road that is not there, s or t not finite */
  RQ_NONE = 0,       /* no surface here */
  RQ_ROAD = 1,
  RQ_JUNCTION = 2, /* on a road of a junction, or on a junction's own surface */
  RQ_TERRAIN = 3   /* off the roads, with a terrain grid */
};

/* Where the last query of a point ended. The content is the library's. */
typedef struct rq_cursor {
  int32_t road, station;
  double s;
  double reserved[2];
} rq_cursor;
/* clang-format off */
#define RQ_CURSOR_START {-1, -1, 0.0, {0.0, 0.0}}
/* clang-format on */

/* What rq_query fills in besides status and z. Fields that are not asked for keep their values. */
enum {
  RQ_NORMAL = 1,
  RQ_POSITION = 2,  /* road_id, lane_id, junction_id, s, t */
  RQ_CURVATURE = 4, /* curvature */
  RQ_MATERIAL = 8,  /* surface_class, friction, roughness */
  RQ_ALL = 15,
  /* Besides, by |: z and normal are those of the road that the hit names. Else roads that overlap on one level (1.5 m)
   * are one blended surface, and junctions may have a surface of their own. */
  RQ_OWN = 16
};

enum { RQ_ASPHALT = 0, RQ_CONCRETE = 1, RQ_SETTS = 2, RQ_GRAVEL = 3, RQ_GROUND = 4 };

typedef struct rq_hit {
  int32_t status;        /* as returned */
  int32_t road_id;       /* OpenDRIVE id; -1 on terrain */
  int32_t lane_id;       /* OpenDRIVE id; 0 on terrain, and between lanes */
  int32_t junction_id;   /* OpenDRIVE id; -1 outside junctions */
  int32_t surface_class; /* RQ_ASPHALT, ... */
  int32_t reserved_int;
  double s, t;      /* OpenDRIVE road coordinates */
  double z;         /* height of the surface */
  double normal[3]; /* unit, upwards */
  double curvature; /* 1/m in plan of the line of constant t, positive = left turn */
  double friction;  /* largest force over load that a tyre finds */
  double roughness; /* m, root mean square of the heights over the smooth surface */
  double reserved[5];
} rq_hit;

/* Surface under (x, y): the status, also in *hit. Among surfaces above each other the one nearest to z_guess; NaN: the
 * highest road. Without a surface only the status is filled in. */
RQ_API int rq_query(const rq_map* map, rq_cursor* cursor, double x, double y, double z_guess, unsigned what,
                    rq_hit* hit);
/* The same for the height alone: the fastest way. *z keeps its value where there is no surface. */
RQ_API int rq_height(const rq_map* map, rq_cursor* cursor, double x, double y, double z_guess, double* z);
/* Many points. Coordinates of point i are stride_bytes * i bytes after the first; z_guess may be NULL (NaN for all).
 * `cursors` has one for each point; NULL: the points follow each other along a way. hits[i] is hit_stride_bytes * i
 * bytes after the first, at least sizeof(rq_hit) apart. Returns how many have a surface, or RQ_BAD_INPUT. */
RQ_API int64_t rq_query_batch(const rq_map* map, size_t count, const double* x, const double* y, const double* z_guess,
                              size_t stride_bytes, rq_cursor* cursors, unsigned what, rq_hit* hits,
                              size_t hit_stride_bytes);

/* Height of the terrain grid alone, without roads: RQ_TERRAIN, or RQ_NONE outside it, in its holes, and without one. */
RQ_API int rq_terrain_height(const rq_map* map, double x, double y, double* z);

/* ---- mean plane under a rectangle ---- */

typedef struct rq_patch {
  int32_t status;   /* of the centre, or of the first point that has a surface; RQ_NONE: no plane */
  int32_t partial;  /* 1: a part of the rectangle has no surface, or another status than the centre's */
  double covered;   /* share of the points with a surface, 0 ... 1 */
  double z;         /* of the plane at the centre */
  double normal[3]; /* of the plane: unit, upwards */
  double residual;  /* m, root mean square of the heights over the plane */
  double friction;  /* mean */
  double reserved[4];
} rq_patch;

/* Least-squares plane over the heights at the middles of along x across (1 ... 32; 0: 5 x 3) equal parts of the
 * rectangle around (x, y), its length in the direction `heading` (rad from east, counter-clockwise). Returns the
 * status. Points on a line have no plane. */
RQ_API int rq_contact_patch(const rq_map* map, rq_cursor* cursor, double x, double y, double z_guess, double heading,
                            double length, double width, int along, int across, rq_patch* patch);

/* ---- from road coordinates ---- */

typedef struct rq_pose {
  int32_t status;  /* as returned */
  int32_t lane_id; /* 0 beside the lanes */
  double x, y, z;
  double heading;   /* of increasing s, rad from east, counter-clockwise, -pi ... pi */
  double normal[3]; /* unit, upwards */
  double reserved[4];
} rq_pose;

/* Point (s, t) of a road's own surface, whatever overlaps it (rq_query gives what a wheel stands on). Outside [0,
 * length] RQ_NONE. Beside the road's edges RQ_NONE, too, but the pose is filled in: there the road's surface goes on.
 */
RQ_API int rq_position(const rq_map* map, int32_t road_id, double s, double t, rq_pose* pose);
/* Many points; strides as in rq_query_batch, road_ids has one of its own. Returns how many are on a road. */
RQ_API int64_t rq_position_batch(const rq_map* map, size_t count, const int32_t* road_ids, size_t road_stride_bytes,
                                 const double* s, const double* t, size_t stride_bytes, rq_pose* poses,
                                 size_t pose_stride_bytes);

/* ---- what is in the map? ---- */

enum { RQ_LINK_NONE = 0, RQ_LINK_ROAD = 1, RQ_LINK_JUNCTION = 2 };
typedef struct rq_road {
  int32_t id, junction_id; /* -1: not in a junction */
  double length;
  double speed_limit; /* m/s, of the first <type> that gives one; 0: not known. rq_lanes_at has it at a place */
  int32_t predecessor_kind, predecessor_id, successor_kind, successor_id;
  int32_t left_hand_traffic, bridge, tunnel, reserved_int;
  double reserved[4];
} rq_road;

enum {
  RQ_LANE_NONE = 0,
  RQ_LANE_DRIVING = 1,
  RQ_LANE_SHOULDER = 2,
  RQ_LANE_BORDER = 3,
  RQ_LANE_SIDEWALK = 4,
  RQ_LANE_PARKING = 5,
  RQ_LANE_BIKING = 6,
  RQ_LANE_OTHER = 7,
  RQ_LANE_BIDIRECTIONAL = 8,
  RQ_LANE_BUS = 9,
  RQ_LANE_TAXI = 10
};
typedef struct rq_lane {
  int32_t id; /* > 0 left of the reference line */
  int32_t type;
  double t_right, t_left; /* its borders at that s */
  double speed_limit;     /* m/s at that s: the lane's, else the road's; 0: not known, infinity: no limit */
  double reserved[3];
} rq_lane;

/* Roads and junctions by index, sorted by id. 1, or RQ_BAD_INPUT where there is no such index. */
RQ_API int32_t rq_road_count(const rq_map* map);
RQ_API int rq_get_road(const rq_map* map, int32_t index, rq_road* road);
RQ_API int32_t rq_junction_count(const rq_map* map);
RQ_API int rq_get_junction(const rq_map* map, int32_t index, int32_t* junction_id);
/* Ids as the file has them, where they are no whole numbers of 32 bits and the library has given them numbers; "" for
 * others. NULL where there is none. Valid until rq_free. */
RQ_API const char* rq_road_text_id(const rq_map* map, int32_t road_id);
/* Lanes of a road at s, from right to left, without the centre lane. Their number, also where it is more than
 * `capacity`, or RQ_BAD_INPUT. */
RQ_API int32_t rq_lanes_at(const rq_map* map, int32_t road_id, double s, rq_lane* lanes, int32_t capacity);
/* What was odd in the file, or is not kept of it: lines of text by index. NULL where there is none. Valid until
 * rq_free. */
RQ_API int32_t rq_note_count(const rq_map* map);
RQ_API const char* rq_note(const rq_map* map, int32_t index);
/* PROJ string or WKT as in the header; "" when there is none. NULL for NULL. Valid until rq_free. */
RQ_API const char* rq_geo_reference(const rq_map* map);
/* <offset> as written in the header: x, y, z in m, heading in rad; zeros when there is none. 1, or RQ_BAD_INPUT. */
RQ_API int rq_header_offset(const rq_map* map, double offset[4]);

#ifdef __cplusplus
}
#endif
#endif

/* SPDX-License-Identifier: Apache-2.0 */
/* The C interface in plain C99: load, query, poses, patches, lists, errors. Prints what failed; exit code 0 when all is
 * well. Usage: test_roadquery_c arc.xodr FOLDER (for files that the test writes). */
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
#define NEAR(a, b, tolerance) CHECK(fabs((a) - (b)) <= (tolerance))

static const double pi = 3.14159265358979323846;
static const char* arc_file;
static char path[1024];

static const char* in_folder(const char* folder, const char* name) {
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

static rq_map* load(const rq_options* options) {
  char problem[256] = "";
  rq_map* map = NULL;
  const rq_error error = rq_load(arc_file, options, &map, problem, sizeof problem);
  if (error != RQ_OK) fprintf(stderr, "%s: %s\n", rq_error_text(error), problem);
  CHECK(error == RQ_OK && map != NULL);
  return map;
}

/* Half way along the quarter circle about (0, 100), 2 m outside of it: t = -2, z = 20 + 0.02 s. */
static void point_on_the_arc(double* x, double* y) {
  *x = 102.0 * sin(pi / 4.0);
  *y = 100.0 - 102.0 * cos(pi / 4.0);
}

static void queries(const rq_map* map) {
  rq_cursor cursor = RQ_CURSOR_START;
  rq_hit hit;
  double x, y, z = -1.0;
  point_on_the_arc(&x, &y);
  memset(&hit, 0x7f, sizeof hit);
  CHECK(rq_query(map, &cursor, x, y, NAN, RQ_ALL, &hit) == RQ_ROAD);
  CHECK(hit.status == RQ_ROAD && hit.road_id == 7 && hit.lane_id == -1 && hit.junction_id == -1);
  NEAR(hit.s, 25.0 * pi, 1e-6);
  NEAR(hit.t, -2.0, 1e-6);
  NEAR(hit.z, 20.0 + 0.5 * pi, 2e-4);
  NEAR(hit.normal[0], -0.02 * 100.0 / 102.0 * sqrt(0.5), 1e-4);
  NEAR(hit.normal[0] * hit.normal[0] + hit.normal[1] * hit.normal[1] + hit.normal[2] * hit.normal[2], 1.0, 1e-9);
  CHECK(hit.surface_class == RQ_ASPHALT && hit.friction == 1.0 && hit.roughness == 0.0);
  CHECK(rq_height(map, &cursor, x, y, hit.z, &z) == RQ_ROAD && fabs(z - hit.z) < 1e-6);

  /* What is not asked for is left alone. */
  hit.road_id = 99, hit.s = -5.0, hit.normal[0] = 3.0;
  CHECK(rq_query(map, &cursor, x, y, z, 0, &hit) == RQ_ROAD);
  CHECK(hit.road_id == 99 && hit.s == -5.0 && hit.normal[0] == 3.0 && fabs(hit.z - z) < 1e-6);

  /* Inside of the bend, off the road. */
  CHECK(rq_query(map, &cursor, 50.0, 90.0, 20.0, RQ_ALL, &hit) == RQ_NONE && hit.status == RQ_NONE);
  z = 4.0;
  CHECK(rq_height(map, &cursor, 50.0, 90.0, 20.0, &z) == RQ_NONE && z == 4.0);
  CHECK(rq_terrain_height(map, x, y, &z) == RQ_NONE && z == 4.0);
}

static void bad_queries(const rq_map* map) {
  const double bad[] = {NAN, INFINITY, -INFINITY};
  rq_cursor cursor = RQ_CURSOR_START;
  rq_hit hit;
  rq_patch patch;
  double x, y, z = 4.0;
  size_t i;
  point_on_the_arc(&x, &y);
  for (i = 0; i < 3; ++i) {
    CHECK(rq_query(map, &cursor, bad[i], y, 20.0, RQ_ALL, &hit) == RQ_BAD_INPUT && hit.status == RQ_BAD_INPUT);
    CHECK(rq_query(map, &cursor, x, bad[i], 20.0, RQ_ALL, &hit) == RQ_BAD_INPUT);
    CHECK(rq_height(map, &cursor, bad[i], y, 20.0, &z) == RQ_BAD_INPUT && z == 4.0);
    CHECK(rq_query(map, &cursor, x, y, bad[i], RQ_ALL, &hit) == RQ_ROAD); /* any guess finds the only surface */
    CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, bad[i], 0.2, 0.2, 0, 0, &patch) == RQ_BAD_INPUT);
    CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, 0.0, bad[i], 0.2, 0, 0, &patch) == RQ_BAD_INPUT);
    CHECK(rq_terrain_height(map, bad[i], y, &z) == RQ_BAD_INPUT);
    cursor.s = bad[i], cursor.road = 0, cursor.station = 12345678; /* nonsense in a cursor is no error */
    CHECK(rq_query(map, &cursor, x, y, 20.0, RQ_ALL, &hit) == RQ_ROAD && hit.road_id == 7);
    cursor.s = 10.0, cursor.road = 77, cursor.station = -5;
    CHECK(rq_query(map, &cursor, x, y, 20.0, RQ_ALL, &hit) == RQ_ROAD && hit.road_id == 7);
  }
  CHECK(rq_query(map, &cursor, 1e300, -1e300, 20.0, RQ_ALL, &hit) == RQ_NONE);
  CHECK(rq_query(NULL, &cursor, x, y, 20.0, RQ_ALL, &hit) == RQ_BAD_INPUT && hit.status == RQ_BAD_INPUT);
  CHECK(rq_query(map, NULL, x, y, 20.0, RQ_ALL, &hit) == RQ_BAD_INPUT);
  CHECK(rq_query(map, &cursor, x, y, 20.0, RQ_ALL, NULL) == RQ_BAD_INPUT);
  CHECK(rq_height(map, &cursor, x, y, 20.0, NULL) == RQ_BAD_INPUT);
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, 0.0, 0.2, -0.2, 0, 0, &patch) == RQ_BAD_INPUT);
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, 0.0, 0.2, 0.2, 33, 3, &patch) == RQ_BAD_INPUT);
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, 0.0, 0.2, 0.2, 5, -1, &patch) == RQ_BAD_INPUT);
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, 0.0, 0.2, 0.2, 5, 3, NULL) == RQ_BAD_INPUT);
}

static void poses(const rq_map* map) {
  rq_pose pose, poses[3];
  double x, y;
  const int32_t ids[3] = {7, 8, 7};
  const struct { double s, t; } places[3] = {{25.0 * 3.14159265358979323846, -2.0}, {1.0, 0.0}, {1000.0, 0.0}};
  point_on_the_arc(&x, &y);
  CHECK(rq_position(map, 7, 25.0 * pi, -2.0, &pose) == RQ_ROAD);
  NEAR(pose.x, x, 1e-9);
  NEAR(pose.y, y, 1e-9);
  NEAR(pose.z, 20.0 + 0.5 * pi, 2e-4);
  NEAR(pose.heading, pi / 4.0, 1e-9);
  CHECK(pose.lane_id == -1 && pose.normal[2] > 0.999);
  CHECK(rq_position(map, 7, 50.0, 4.0, &pose) == RQ_NONE && pose.lane_id == 0);
  NEAR(hypot(pose.x, pose.y - 100.0), 96.0, 1e-9); /* beside the road, its surface goes on */
  CHECK(rq_position(map, 7, -0.1, 0.0, &pose) == RQ_NONE && rq_position(map, 7, 158.0, 0.0, &pose) == RQ_NONE);
  CHECK(rq_position(map, 8, 1.0, 0.0, &pose) == RQ_BAD_INPUT && pose.status == RQ_BAD_INPUT);
  CHECK(rq_position(map, 7, NAN, 0.0, &pose) == RQ_BAD_INPUT &&
        rq_position(map, 7, 1.0, INFINITY, &pose) == RQ_BAD_INPUT);
  CHECK(rq_position(NULL, 7, 1.0, 0.0, &pose) == RQ_BAD_INPUT && rq_position(map, 7, 1.0, 0.0, NULL) == RQ_BAD_INPUT);

  CHECK(rq_position_batch(map, 3, ids, sizeof ids[0], &places[0].s, &places[0].t, sizeof places[0], poses,
                          sizeof poses[0]) == 1);
  CHECK(poses[0].status == RQ_ROAD && poses[1].status == RQ_BAD_INPUT && poses[2].status == RQ_NONE);
  NEAR(poses[0].x, x, 1e-9);
  CHECK(rq_position_batch(map, 3, ids, sizeof ids[0], &places[0].s, &places[0].t, sizeof places[0], poses, 8) ==
        RQ_BAD_INPUT);
}

static void batches(const rq_map* map) {
  enum { count = 100 };
  struct {
    double x, y, z;
    char tag;
  } points[count];
  rq_hit hits[count], one;
  rq_cursor cursors[count];
  const rq_cursor start = RQ_CURSOR_START;
  int i;
  for (i = 0; i < count; ++i) {
    const double angle = 0.5 * pi * (i + 0.5) / count, radius = i % 10 == 9 ? 90.0 : 100.0 + 3.0 * sin(i);
    points[i].x = radius * sin(angle), points[i].y = 100.0 - radius * cos(angle), points[i].z = 20.0;
    cursors[i] = start;
  }
  CHECK(rq_query_batch(map, count, &points[0].x, &points[0].y, &points[0].z, sizeof points[0], cursors, RQ_ALL, hits,
                       sizeof hits[0]) == 90);
  for (i = 0; i < count; ++i) {
    rq_cursor cursor = RQ_CURSOR_START;
    CHECK(rq_query(map, &cursor, points[i].x, points[i].y, points[i].z, RQ_ALL, &one) == hits[i].status);
    CHECK(hits[i].status <= 0 || (hits[i].z == one.z && hits[i].s == one.s && hits[i].normal[1] == one.normal[1]));
  }
  CHECK(rq_query_batch(map, count, &points[0].x, &points[0].y, NULL, sizeof points[0], NULL, RQ_ALL, hits,
                       sizeof hits[0]) == 90);
  CHECK(rq_query_batch(map, 0, &points[0].x, &points[0].y, NULL, 8, NULL, RQ_ALL, hits, sizeof hits[0]) == 0);
  CHECK(rq_query_batch(map, 1, NULL, &points[0].y, NULL, 8, NULL, RQ_ALL, hits, sizeof hits[0]) == RQ_BAD_INPUT);
  CHECK(rq_query_batch(map, 1, &points[0].x, &points[0].y, NULL, 8, NULL, RQ_ALL, hits, 8) == RQ_BAD_INPUT);
}

static void patches(const rq_map* map) {
  rq_cursor cursor = RQ_CURSOR_START;
  rq_patch patch;
  double x, y;
  point_on_the_arc(&x, &y);
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, pi / 4.0, 0.3, 0.2, 0, 0, &patch) == RQ_ROAD);
  CHECK(!patch.partial && patch.covered == 1.0 && patch.friction == 1.0);
  NEAR(patch.z, 20.0 + 0.5 * pi, 2e-4);
  NEAR(patch.normal[2], 1.0 / sqrt(1.0 + 0.0004 / (1.02 * 1.02)), 1e-6);
  /* Half of it off the inner edge, 96.5 m from the centre. */
  x = 96.5 * sqrt(0.5), y = 100.0 - x;
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, pi / 4.0, 0.2, 0.4, 4, 4, &patch) > 0);
  CHECK(patch.partial && patch.covered == 0.5);
  /* Points on a line have no plane, and off the road there is none. */
  x = 102.0 * sqrt(0.5), y = 100.0 - x;
  CHECK(rq_contact_patch(map, &cursor, x, y, 20.0, pi / 4.0, 0.2, 0.2, 5, 1, &patch) == RQ_NONE &&
        patch.covered == 1.0);
  CHECK(rq_contact_patch(map, &cursor, 50.0, 90.0, 20.0, 0.0, 0.2, 0.2, 0, 0, &patch) == RQ_NONE &&
        patch.covered == 0.0);
}

static void lists(const rq_map* map) {
  rq_road road;
  rq_lane lanes[4];
  int32_t junction;
  double offset[4];
  CHECK(rq_road_count(map) == 1 && rq_junction_count(map) == 0);
  CHECK(rq_get_road(map, 0, &road) == 1 && road.id == 7 && road.junction_id == -1 && road.bridge && !road.tunnel);
  NEAR(road.length, 50.0 * pi, 1e-9);
  CHECK(road.successor_kind == RQ_LINK_ROAD && road.successor_id == 7 && road.predecessor_kind == RQ_LINK_NONE);
  CHECK(rq_get_road(map, 1, &road) == RQ_BAD_INPUT && rq_get_road(map, -1, &road) == RQ_BAD_INPUT);
  CHECK(rq_get_junction(map, 0, &junction) == RQ_BAD_INPUT);
  CHECK(rq_lanes_at(map, 7, 10.0, lanes, 4) == 3);
  CHECK(lanes[0].id == -2 && lanes[0].type == RQ_LANE_SHOULDER && lanes[1].id == -1 && lanes[2].id == 1);
  CHECK(lanes[0].t_right == -4.5 && lanes[0].t_left == -3.5 && lanes[1].t_left == 0.0 && lanes[2].t_left == 3.5);
  lanes[1].id = 55;
  CHECK(rq_lanes_at(map, 7, 10.0, lanes, 1) == 3 && lanes[0].id == -2 && lanes[1].id == 55);
  CHECK(rq_lanes_at(map, 7, 10.0, NULL, 0) == 3 && rq_lanes_at(map, 7, NAN, lanes, 4) == RQ_BAD_INPUT);
  CHECK(rq_lanes_at(map, 9, 1.0, lanes, 4) == RQ_BAD_INPUT && rq_lanes_at(map, 7, 1e3, lanes, 4) == RQ_BAD_INPUT);
  CHECK(strncmp(rq_geo_reference(map), "+proj=utm +zone=33", 18) == 0 && rq_geo_reference(NULL) == NULL);
  CHECK(rq_header_offset(map, offset) == 1 && offset[0] == 0.0 && offset[3] == 0.0);
  CHECK(rq_header_offset(map, NULL) == RQ_BAD_INPUT && rq_road_count(NULL) == RQ_BAD_INPUT);
}

/* A ramp of 0.1 in x from 10 m at x = 0, a height each 50 m, with one hole. */
static void terrain(const char* folder) {
  rq_options options = RQ_OPTIONS_DEFAULT;
  rq_cursor cursor = RQ_CURSOR_START;
  rq_hit hit;
  rq_map* map;
  double z, x, y;
  FILE* file = fopen(in_folder(folder, "ramp.asc"), "w");
  CHECK(file != NULL);
  if (file == NULL) return;
  fputs("ncols 4\nnrows 3\nxllcenter 0\nyllcenter 0\ncellsize 50\nNODATA_value -9999\n", file);
  fputs("10 15 20 -9999\n10 15 20 25\n10 15 20 25\n", file);
  fclose(file);
  options.terrain_file = path;
  map = load(&options);
  if (map == NULL) return;
  CHECK(rq_query(map, &cursor, 30.0, 60.0, 13.0, RQ_ALL, &hit) == RQ_TERRAIN);
  NEAR(hit.z, 13.0, 1e-5);
  NEAR(hit.normal[0], -0.1 / sqrt(1.01), 1e-6);
  CHECK(hit.road_id == -1 && hit.lane_id == 0 && hit.junction_id == -1 && hit.surface_class == RQ_GROUND);
  CHECK(rq_terrain_height(map, 30.0, 60.0, &z) == RQ_TERRAIN && fabs(z - 13.0) < 1e-5);
  CHECK(rq_terrain_height(map, 140.0, 90.0, &z) == RQ_NONE && rq_terrain_height(map, 1e9, 0.0, &z) == RQ_NONE);
  /* Below the bridge, on it, and without a guess. */
  point_on_the_arc(&x, &y);
  CHECK(rq_query(map, &cursor, x, y, 17.0, RQ_ALL, &hit) == RQ_TERRAIN);
  NEAR(hit.z, 10.0 + 0.1 * x, 1e-5);
  CHECK(rq_query(map, &cursor, x, y, 21.0, RQ_ALL, &hit) == RQ_ROAD);
  CHECK(rq_query(map, &cursor, x, y, NAN, RQ_ALL, &hit) == RQ_ROAD);
  rq_free(map);
}

/* The arc with an OpenCRG file that is not there, and with a header offset. */
static void other_files(const char* folder) {
  static char text[8192], name[1024];
  const char* crg =
      "<surface><CRG file=\"none.crg\" sStart=\"0\" sEnd=\"100\" orientation=\"same\" "
      "mode=\"attached\"/></surface></road>";
  const char* header = "<offset x=\"1000\" y=\"2000\" z=\"5\" hdg=\"0\"/></header>";
  char problem[256] = "";
  rq_options options = RQ_OPTIONS_DEFAULT;
  rq_map* map;
  rq_pose pose;
  double offset[4];
  size_t length;
  int how;
  FILE* file = fopen(arc_file, "rb");
  CHECK(file != NULL);
  if (file == NULL) return;
  length = fread(text, 1, sizeof text - 1, file);
  text[length] = '\0';
  fclose(file);
  snprintf(name, sizeof name, "%s", in_folder(folder, "more.xodr"));
  file = fopen(name, "wb");
  CHECK(file != NULL && strstr(text, "</header>") != NULL && strstr(text, "</road>") != NULL);
  if (file == NULL) return;
  *strstr(text, "</header>") = '\0';
  *strstr(text + strlen(text) + 1, "</road>") = '\0';
  fprintf(file, "%s%s%s%s</OpenDRIVE>", text, header, text + strlen(text) + strlen("</header>"), crg);
  fclose(file);
  CHECK(rq_load(name, &options, &map, problem, sizeof problem) == RQ_ERROR_CRG && map == NULL);
  CHECK(strstr(problem, "none.crg") != NULL);
  options.ignore_crg = 1;
  for (how = RQ_OFFSET_ADD; how <= RQ_OFFSET_SUBTRACT; ++how) {
    const double times = how == RQ_OFFSET_ADD ? 1.0 : how == RQ_OFFSET_IGNORE ? 0.0 : -1.0;
    options.header_offset = how;
    CHECK(rq_load(name, &options, &map, problem, sizeof problem) == RQ_OK);
    CHECK(rq_position(map, 7, 0.0, 0.0, &pose) == RQ_ROAD);
    NEAR(pose.x, 1000.0 * times, 1e-6);
    NEAR(pose.y, 2000.0 * times, 1e-6);
    NEAR(pose.z, 20.0 + 5.0 * times, 1e-3);
    CHECK(rq_header_offset(map, offset) == 1 && offset[0] == 1000.0 && offset[2] == 5.0);
    rq_free(map);
  }
}

static void errors(const char* folder) {
  char problem[256] = "", cut[10];
  rq_options options = RQ_OPTIONS_DEFAULT;
  rq_map* map = (rq_map*)&options;
  int i;
  CHECK(rq_load("no_such_file.xodr", NULL, &map, problem, sizeof problem) == RQ_ERROR_NETWORK && map == NULL);
  CHECK(strstr(problem, "no_such_file.xodr: cannot be opened") == problem);
  CHECK(rq_load("no_such_file.xodr", NULL, &map, cut, sizeof cut) == RQ_ERROR_NETWORK);
  CHECK(strcmp(cut, "no_such_f") == 0);
  CHECK(rq_load(NULL, NULL, &map, NULL, 0) == RQ_ERROR_ARGUMENT);
  CHECK(rq_load(arc_file, NULL, NULL, problem, sizeof problem) == RQ_ERROR_ARGUMENT);
  options.header_offset = 3;
  CHECK(rq_load(arc_file, &options, &map, problem, sizeof problem) == RQ_ERROR_ARGUMENT && map == NULL);
  options.header_offset = 0, options.verge_m = NAN;
  CHECK(rq_load(arc_file, &options, &map, problem, sizeof problem) == RQ_ERROR_ARGUMENT);
  options.verge_m = 5.0, options.size = 0;
  CHECK(rq_load(arc_file, &options, &map, problem, sizeof problem) == RQ_ERROR_ARGUMENT);
  options.size = sizeof options, options.terrain_file = in_folder(folder, "none.asc");
  CHECK(rq_load(arc_file, &options, &map, problem, sizeof problem) == RQ_ERROR_TERRAIN && map == NULL);
  CHECK(strstr(problem, "none.asc: cannot be opened") != NULL);
  options.size = offsetof(rq_options, terrain_file); /* a program that does not know of terrain yet */
  CHECK(rq_load(arc_file, &options, &map, problem, sizeof problem) == RQ_OK && map != NULL);
  rq_free(map);
  rq_free(NULL);
  for (i = RQ_OK; i <= RQ_ERROR_INTERNAL; ++i) CHECK(strcmp(rq_error_text(i), "unknown error") != 0);
  CHECK(strcmp(rq_error_text(-1), "unknown error") == 0 && strcmp(rq_error_text(1000), "unknown error") == 0);
  CHECK(rq_abi_version() == RQ_ABI_VERSION);
}

int main(int argc, char** argv) {
  rq_map* map;
  if (argc != 3) return 2;
  arc_file = argv[1];
  map = load(NULL);
  if (map == NULL) return 1;
  queries(map);
  bad_queries(map);
  poses(map);
  batches(map);
  patches(map);
  lists(map);
  rq_free(map);
  terrain(argv[2]);
  other_files(argv[2]);
  errors(argv[2]);
  return failures == 0 ? 0 : 1;
}

/* SPDX-License-Identifier: Apache-2.0 */
/* After rq_load nothing allocates, and nothing calls the system: malloc and its kin are counted, and the kernel kills
 * the process at any call but write and exit. A lock that waits is a system call, too; that no lock is there at all,
 * check_exports.cmake sees. Usage: test_roadquery_no_calls arc.xodr TERRAIN.asc */
#define _GNU_SOURCE
#include <linux/seccomp.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "roadquery/roadquery.h"

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void __libc_free(void*);
static long allocations = 0;
void* malloc(size_t size) { return ++allocations, __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return ++allocations, __libc_calloc(count, size); }
void* realloc(void* block, size_t size) { return ++allocations, __libc_realloc(block, size); }
void free(void* block) {
  allocations += block != NULL;
  __libc_free(block);
}

enum { count = 200 };
static double xs[count], ys[count];
static rq_hit hits[count];
static rq_pose poses[count];
static int32_t ids[count];

/* Every function but rq_load and rq_free, on and off the road, coherent and not. Returns queries that found something.
 */
static long use_everything(const rq_map* map) {
  rq_cursor cursor = RQ_CURSOR_START;
  rq_patch patch;
  rq_road road;
  rq_lane lanes[8];
  double z, offset[4];
  long found = 0;
  int i, round;
  for (round = 0; round < 50; ++round) {
    for (i = 0; i < count; ++i) {
      xs[i] = -20.0 + (i * 37 % count) * 0.7 + 0.01 * round, ys[i] = -20.0 + (i * 91 % count) * 0.7;
      ids[i] = i % 3 ? 7 : 8;
      found += rq_height(map, &cursor, xs[i], ys[i], 20.0, &z) > 0;
      found += rq_contact_patch(map, &cursor, xs[i], ys[i], 20.0, 0.1 * i, 0.3, 0.2, 0, 0, &patch) > 0;
      found += rq_terrain_height(map, xs[i], ys[i], &z) > 0;
    }
    found += rq_query_batch(map, count, xs, ys, NULL, sizeof(double), NULL, RQ_ALL, hits, sizeof(rq_hit));
    found += rq_position_batch(map, count, ids, sizeof ids[0], xs, ys, sizeof(double), poses, sizeof(rq_pose));
    found += rq_road_count(map) + rq_get_road(map, 0, &road) + rq_junction_count(map);
    found += rq_lanes_at(map, 7, 10.0, lanes, 8) + rq_header_offset(map, offset) + (rq_geo_reference(map) != NULL);
    found += rq_error_text(round) != NULL;
  }
  return found;
}

int main(int argc, char** argv) {
  rq_options options = RQ_OPTIONS_DEFAULT;
  rq_map* map;
  char problem[256];
  long before, found;
  int status;
  if (argc != 3) return 2;
  options.terrain_file = argv[2];
  if (rq_load(argv[1], &options, &map, problem, sizeof problem) != RQ_OK) return fprintf(stderr, "%s\n", problem), 1;
  if (allocations == 0) return fputs("malloc is not counted\n", stderr), 1;
  before = allocations;
  found = use_everything(map);
  if (allocations != before) return fprintf(stderr, "%ld allocations in queries\n", allocations - before), 1;
  if (found < 1000) return fprintf(stderr, "only %ld answers\n", found), 1;

  if (fork() == 0) {
    if (prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0) _exit(77);
    syscall(SYS_exit, use_everything(map) == found ? 0 : 1);
  }
  wait(&status);
  rq_free(map);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) return fputs("SKIPPED: no seccomp here\n", stderr), 77;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fprintf(stderr, "a query called the system (wait status %d)\n", status), 1;
  printf("%ld answers without an allocation or a system call\n", found);
  return 0;
}

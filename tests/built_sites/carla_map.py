# SPDX-License-Identifier: Apache-2.0
"""Compares CARLA's view of an OpenDRIVE file with ours: carla_map.py FILE.xodr ASK.json. ASK holds `points` [road,
lane, s, x, y, z of the surface, z of the reference line] in coordinates of the CRS, `lanes` [road, lane, s of its end]
and `links` [road, lane, next road, next lane]. CARLA's map (no server) is asked for the waypoint at each point and for
what follows each lane.
"""

import json
import math
import pathlib
import re
import sys

import carla

END_M = 0.005


def offset_of(text):
    found = re.search(r'<offset x="([^"]+)" y="([^"]+)"', text)
    return (float(found[1]), float(found[2])) if found else (0.0, 0.0)


def compare_points(points, road_map, offset):
    worst = {"max_xy_m": 0.0, "max_line_z_m": 0.0, "max_surface_z_m": 0.0, "no_waypoint": 0, "points": len(points)}
    for road, lane, s, x, y, z, line_z in points:
        waypoint = road_map.get_waypoint_xodr(road, lane, s)
        if waypoint is None:
            worst["no_waypoint"] += 1
            continue
        at = waypoint.transform.location  # y points south: left-handed
        worst["max_xy_m"] = max(worst["max_xy_m"], math.hypot(at.x - (x - offset[0]), -at.y - (y - offset[1])))
        worst["max_line_z_m"] = max(worst["max_line_z_m"], abs(at.z - line_z))
        worst["max_surface_z_m"] = max(worst["max_surface_z_m"], abs(at.z - z))
    return worst


def compare_links(lanes, links, road_map):
    theirs = set()
    for road, lane, end_s in lanes:
        waypoint = road_map.get_waypoint_xodr(road, lane, end_s - END_M if end_s > 0 else END_M)
        if waypoint is None:
            continue
        for following in waypoint.next(2 * END_M):
            theirs.add((road, lane, following.road_id, following.lane_id))
    # CARLA takes the next waypoint of a road that leads into itself for one on the road.
    ours = {tuple(link) for link in links if link[0] != link[2]}
    theirs = {link for link in theirs if link[0] != link[2]}
    return {"links": len(ours), "only_ours": sorted(ours - theirs)[:20], "only_carla": sorted(theirs - ours)[:20]}


def main(xodr, ask):
    text = pathlib.Path(xodr).read_text(encoding="utf-8")
    with open(ask, encoding="utf-8") as file:
        asked = json.load(file)
    road_map = carla.Map("roads", text)
    print(
        json.dumps(
            {
                **compare_points(asked["points"], road_map, offset_of(text)),
                **compare_links(asked["lanes"], asked["links"], road_map),
            }
        )
    )


main(*sys.argv[1:])

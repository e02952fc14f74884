# SPDX-License-Identifier: Apache-2.0
"""Do the lanes that SUMO reads from our OpenDRIVE connect what OpenStreetMap connects? Prints JSON.

Draws pairs of directed roads (1000, always the same ones) from the largest part of the OSM graph in which every place
can be driven to from every other one, and looks for a route between them in SUMO's network. Prints JSON: pairs, found,
share, and the same without the U-turns that netconvert adds at junctions by itself ("no_u_turns"; at dead ends they
stay).
"""

import json
import pathlib
import random
import re
import sqlite3
import struct
import xml.etree.ElementTree as ElementTree
from collections import defaultdict, deque


def read_paths(file):
    """Paths with their nodes (place, osm_node) in order; centrelines and nodes of roads.gpkg."""
    db = sqlite3.connect(f"file:{file}?mode=ro", uri=True)
    paths = {
        (i, part): {"oneway": oneway != 0, "nodes": []}
        for i, part, oneway in db.execute("select osm_id, part, oneway from centrelines")
    }
    for i, part, osm_node, blob in db.execute(
        "select osm_id, part, osm_node, geom from nodes order by osm_id, part, s_m, fid"
    ):
        paths[(i, part)]["nodes"].append((struct.unpack_from("<dd", blob, len(blob) - 16), osm_node))
    return paths


def osm_edges(paths):
    """Directed edges between places where paths meet or end: {(path, first node, last node): (from, to)} in the path's
    direction.
    """
    visits = defaultdict(int)
    for path in paths.values():
        for _, node in path["nodes"]:
            visits[node] += 1
    edges = {}
    for key, path in paths.items():
        nodes = path["nodes"]

        def name(k):
            return nodes[k][1] or (key, k)  # an end at the border has no node

        first = 0
        for k in range(1, len(nodes)):
            if k + 1 < len(nodes) and (nodes[k][1] == 0 or visits[nodes[k][1]] < 2):
                continue
            edges[(key, first, k)] = (name(first), name(k))
            first = k
    return edges


def strong_parts(successors):
    """Strongly connected parts, largest first. Kosaraju, without recursion."""
    order, seen = [], set()
    for root in successors:
        if root in seen:
            continue
        stack = [(root, iter(successors[root]))]
        seen.add(root)
        while stack:
            node, rest = stack[-1]
            for other in rest:
                if other not in seen:
                    seen.add(other)
                    stack.append((other, iter(successors.get(other, ()))))
                    break
            else:
                order.append(node)
                stack.pop()
    back = defaultdict(list)
    for node, others in successors.items():
        for other in others:
            back[other].append(node)
    parts, seen = [], set()
    for root in reversed(order):
        if root in seen:
            continue
        part, queue = {root}, deque([root])
        seen.add(root)
        while queue:
            for other in back[queue.popleft()]:
                if other not in seen:
                    seen.add(other)
                    part.add(other)
                    queue.append(other)
        parts.append(part)
    return sorted(parts, key=len, reverse=True)


def read_roads(file):
    """{road id: (OSM way, a place near the middle)} of roads outside junctions."""
    roads, offset = {}, (0.0, 0.0)
    for _, element in ElementTree.iterparse(file):
        if element.tag == "offset" and not roads:
            offset = (float(element.get("x")), float(element.get("y")))
        if element.tag != "road":
            continue
        if element.get("junction") == "-1":
            middle = 0.5 * float(element.get("length"))
            place = [
                (float(g.get("x")) + offset[0], float(g.get("y")) + offset[1])
                for g in element.iter("geometry")
                if float(g.get("s")) <= middle
            ][-1]
            way = next(int(u.get("value")) for u in element.iter("userData") if u.get("code") == "osm_id")
            roads[int(element.get("id"))] = (way, place)
        element.clear()
    return roads


def read_net(file):
    """Edges of each road and direction in driving order, and which edge leads into which; U-turns apart."""
    edges, leads, u_turns = {}, defaultdict(set), defaultdict(set)
    incoming, outgoing = defaultdict(set), defaultdict(set)
    for _, element in ElementTree.iterparse(file):
        if element.tag == "edge" and element.get("function") is None:
            edges[element.get("id")] = (element.get("from"), element.get("to"))
            incoming[element.get("to")].add(element.get("id"))
            outgoing[element.get("from")].add(element.get("id"))
        elif element.tag == "connection" and not element.get("from").startswith(":"):
            (u_turns if element.get("dir") == "t" else leads)[element.get("from")].add(element.get("to"))
        if element.tag in ("edge", "connection", "junction"):
            element.clear()
    for edge, others in u_turns.items():
        if len(outgoing[edges[edge][1]]) == 1:  # a dead end
            leads[edge] |= others
    of_road = defaultdict(list)
    for edge in edges:
        match = re.match(r"(-?)(\d+)", edge)
        of_road[(int(match[2]), match[1] == "-")].append(edge)  # "-12": the right lanes, along s
    return edges, leads, u_turns, of_road


def reached_from(start, successors):
    seen, queue = {start}, deque([start])
    while queue:
        for other in successors(queue.popleft()):
            if other not in seen:
                seen.add(other)
                queue.append(other)
    return seen


def compare(gpkg, xodr, net, count=1000):
    paths = read_paths(gpkg)
    edges = osm_edges(paths)
    successors = defaultdict(list)
    for (key, _, _), (a, b) in edges.items():
        successors[a].append(b)
        successors[b]
        if not paths[key]["oneway"]:
            successors[b].append(a)
    part = strong_parts(successors)[0]

    parts_of_way = defaultdict(list)
    for key in paths:
        parts_of_way[key[0]].append(key)
    edges_of_path = defaultdict(list)
    for (key, first, last), ends in edges.items():
        edges_of_path[key].append((first, last, ends))
    _net_edges, leads, u_turns, of_road = read_net(net)
    drivable = []
    for road, (way, place) in sorted(read_roads(xodr).items()):
        _squared, key, k = min(
            ((p[0] - place[0]) ** 2 + (p[1] - place[1]) ** 2, key, k)
            for key in parts_of_way[way]
            for k, (p, _) in enumerate(paths[key]["nodes"])
        )
        ends = next(ends for first, last, ends in edges_of_path[key] if first <= k <= last)
        if not (ends[0] in part and ends[1] in part):
            continue
        for along in (True, False):
            here = of_road.get((road, along))
            if here and (along or not paths[key]["oneway"]):
                drivable.append((here, road))
    random.seed(1)
    pairs = [random.sample(drivable, 2) for _ in range(count)]
    result = {"directed_roads": len(drivable), "pairs": count}

    def both(edge):
        return leads[edge] | u_turns[edge]

    for name, step in (("", both), ("no_u_turns_", lambda edge: leads[edge])):
        reached, missing = {}, []
        for (origin, road_a), (target, road_b) in pairs:
            start = origin[0]
            if start not in reached:
                reached[start] = reached_from(start, step)
            if not any(edge in reached[start] for edge in target):
                missing.append((road_a, road_b))
        result[name + "found"] = count - len(missing)
        result[name + "share"] = (count - len(missing)) / count
        if missing:
            result[name + "missing"] = missing[:10]
    return result


def add_arguments(parser):
    parser.add_argument("roads", type=pathlib.Path, help="ROADS.gpkg, from which the network was made")
    parser.add_argument("network", type=pathlib.Path, help="ROADS.xodr")
    parser.add_argument("net", type=pathlib.Path, help="NET.xml, as netconvert reads the network")
    parser.add_argument("--pairs", type=int, default=1000)


def run(args):
    print(json.dumps(compare(args.roads, args.network, args.net, args.pairs)))

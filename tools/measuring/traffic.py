# SPDX-License-Identifier: Apache-2.0
"""Random trips of SUMO on the roads of built sites. Writes docs/measured/traffic.md.

    tools/measure traffic Kvarnbyn=out/kvarnbyn --osm Kvarnbyn=../shared/data/kvarnbyn/roads.osm

Counts collisions, teleports and emergency brakings, and says where they were. A site is a folder that `orthodrive
build` wrote (roads.xodr; roads.gpkg names the nodes of OSM), or an OpenDRIVE file. With --osm a map is imported by
SUMO's own netconvert and gets as many trips, to compare with. Two runs go on at a time; seeds that are done count when
it is called again. What is not named keeps its last numbers. Trips: tests/built_sites/sumo_trips.py. Needs Debian's
sumo and sumo-tools.
"""

import concurrent.futures
import hashlib
import itertools
import json
import math
import os
import pathlib
import sqlite3
import subprocess
import sys
from xml.etree import ElementTree

from measuring.common import (
    PAGES,
    ROOT,
    add_table,
    commit,
    fixed,
    header,
    point_of,
    read_results,
    row,
    run_program,
    write_page,
    write_results,
)

STORE, PAGE = "traffic.json", PAGES / "traffic.md"
SCRIPT = ROOT / "tests/built_sites/sumo_trips.py"
COUNTS = ["collisions", "teleports", "emergency_brakings"]
MOST_BRAKINGS = 1e-3  # a trip
RUNS_AT_A_TIME = 2
ENVIRONMENT = {**os.environ, "SUMO_HOME": "/usr/share/sumo"}


def named_path(text):
    name, _, file = text.partition("=")
    if not file:
        raise ValueError
    return name, pathlib.Path(file).resolve()


def add_arguments(parser):
    parser.add_argument(
        "site", nargs="*", type=named_path, metavar="NAME=FOLDER", help="a built site, or an OpenDRIVE file"
    )
    parser.add_argument(
        "--osm",
        type=named_path,
        action="append",
        default=[],
        metavar="NAME=FILE",
        help="a map for netconvert's own import",
    )
    parser.add_argument("--seeds", type=int, default=20, help="runs with other trips (20)")
    parser.add_argument("--trips", type=int, default=300, help="of a run (300)")
    parser.add_argument(
        "--out", type=pathlib.Path, default=ROOT / "out/traffic", help="folder for what is made (out/traffic)"
    )
    add_table(parser)


def netconvert(net, *words):
    run_program(
        "/usr/bin/netconvert",
        *words,
        "--xml-validation",
        "never",
        "-o",
        net,
        stderr=subprocess.DEVNULL,
        env=ENVIRONMENT,
    )


class Places:
    """Where a metre of a lane lies, and which node of OSM is next to it."""

    def __init__(self, net, xodr=None, gpkg=None):
        self.lanes, header, self.nodes = {}, (0.0, 0.0), []
        for _, element in ElementTree.iterparse(net):
            if element.tag == "location":
                shift = tuple(map(float, element.get("netOffset").split(",")))
            elif element.tag == "lane":
                self.lanes[element.get("id")] = [
                    tuple(map(float, p.split(",")[:2])) for p in element.get("shape").split()
                ]
        if xodr:
            offset = next((e for _, e in ElementTree.iterparse(xodr, ["start"]) if e.tag in ("offset", "road")), None)
            if offset is not None and offset.tag == "offset":
                header = (float(offset.get("x")), float(offset.get("y")))
        # SUMO 1.15 subtracts the offset of OpenDRIVE's header where it had to add it.
        self.utm_from_net = tuple(2.0 * h - s for h, s in zip(header, shift, strict=True))
        if gpkg and gpkg.exists():
            rows = sqlite3.connect(f"file:{gpkg}?mode=ro", uri=True).execute(
                "select osm_node, geom from nodes where osm_node != 0"
            )
            self.nodes = [(node, point_of(blob)) for node, blob in rows]

    def of(self, lane, pos_m):
        line = self.lanes[lane]
        place = line[-1]
        for a, b in itertools.pairwise(line):
            length = math.dist(a, b)
            if pos_m <= length and length > 0:
                place = tuple(p + (q - p) * pos_m / length for p, q in zip(a, b, strict=True))
                break
            pos_m -= length
        x, y = (p + d for p, d in zip(place, self.utm_from_net, strict=True))
        node = min(self.nodes, key=lambda n: math.dist(n[1], (x, y)))[0] if self.nodes else None
        return {"x": round(x, 1), "y": round(y, 1), "osm_node": node}


def one_run(net, folder, trips, seed):
    """What a run before has found on the same net counts: twenty seeds take long. The first comment of a net holds the
    date.
    """
    done, asked = (
        folder / f"seed_{seed}.json",
        {"net": hashlib.sha256(net.read_bytes().split(b"-->", 1)[-1]).hexdigest(), "trips": trips},
    )
    if done.exists() and (before := json.loads(done.read_text()))["asked"] == asked:
        return seed, before["result"]
    result = json.loads(
        run_program("/usr/bin/python3", SCRIPT, net, folder / f"seed_{seed}", "--trips", trips, "--seed", seed)
    )
    done.write_text(json.dumps({"asked": asked, "result": result}))
    return seed, result


def measure(net, folder, places, args):
    """Sums over all seeds; events with their seed and place."""
    with concurrent.futures.ThreadPoolExecutor(RUNS_AT_A_TIME) as pool:
        runs = list(pool.map(lambda seed: one_run(net, folder, args.trips, seed), range(1, args.seeds + 1)))
    sums = {name: sum(run[name] for _, run in runs) for name in ("trips", "arrived", *COUNTS)}
    events = [
        {"seed": seed, **event, **places.of(event["lane"], event["pos_m"])}
        for seed, run in runs
        for event in run["events"]
    ]
    return {
        "commit": commit(),
        "seeds": args.seeds,
        "seeds_with_collisions": sum(run["collisions"] > 0 for _, run in runs),
        **sums,
        "events": events,
    }


def measure_site(built, folder, args):
    xodr = built if built.is_file() else built / "roads.xodr"
    net = folder / "net.xml"
    folder.mkdir(parents=True, exist_ok=True)
    # Without the option SUMO draws curves of its own between the ends of connecting roads.
    netconvert(net, "--opendrive-files", xodr, "--opendrive.internal-shapes", "true")
    return measure(net, folder, Places(net, xodr, xodr.parent / "roads.gpkg"), args)


def measure_osm(file, folder, args):
    net = folder / "net.xml"
    folder.mkdir(parents=True, exist_ok=True)
    netconvert(net, "--osm-files", file)
    return measure(net, folder, Places(net), args)


def table(numbers):
    sites, maps = numbers["sites"], numbers["osm"]
    columns = [*sites.values(), *maps.values()]
    text = header(["", "asked", *sites, *(f"{name}, netconvert's own" for name in maps)])
    text += row(["seeds", 20, *(n["seeds"] for n in columns)])
    text += row(["trips", 6000, *(n["trips"] for n in columns)])
    text += row(["trips that did not arrive", 0, *(n["trips"] - n["arrived"] for n in columns)])
    text += row(["collisions", 0, *(n["collisions"] for n in columns)])
    text += row(["seeds with a collision", 0, *(n["seeds_with_collisions"] for n in columns)])
    text += row(["teleports", 0, *(n["teleports"] for n in columns)])
    text += row(["emergency brakings", "-", *(n["emergency_brakings"] for n in columns)])
    text += row(
        [
            "emergency brakings, of 1000 trips",
            fixed(1000 * MOST_BRAKINGS, 1),
            *(fixed(1000 * n["emergency_brakings"] / n["trips"], 2) for n in columns),
        ]
    )
    return text


def events_table(sites):
    text = header(["site", "seed", "what", "lane", "x, y", "node of OSM", ""])
    for name, numbers in sites.items():
        for event in numbers["events"]:
            text += row(
                [
                    name,
                    event["seed"],
                    event["kind"],
                    f"`{event['lane']}`",
                    f"{event['x']:.1f}, {event['y']:.1f}",
                    event["osm_node"] or "-",
                    event["what"],
                ]
            )
    return text


def run(args):
    for name, file in args.site + args.osm:
        if not file.exists():
            sys.exit(f"traffic: {name}: {file} is not there")
    numbers = read_results(STORE, {"sites": {}, "osm": {}})
    if not args.table:
        for kind, given, measure_one in (("sites", args.site, measure_site), ("osm", args.osm, measure_osm)):
            for name, file in given:
                numbers[kind][name] = measure_one(file, args.out / kind / name, args)
                write_results(STORE, numbers)
                print(name, {k: v for k, v in numbers[kind][name].items() if k != "events"}, flush=True)
    write_page(PAGE, [STORE], {"traffic": table(numbers), "events": events_table(numbers["sites"])})

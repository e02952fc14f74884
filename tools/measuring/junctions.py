# SPDX-License-Identifier: Apache-2.0
"""Junction surfaces of built sites: size, heights, kerb radii. Writes the table of docs/measured/junctions.md.

Give built sites as NAME=FOLDER, for example  --sites village=out/village kvarnbyn=out/kvarnbyn
"""

import json
import pathlib
import sqlite3
import statistics
import xml.etree.ElementTree as ElementTree

from measuring.common import PAGES, add_table, commit, fixed, header, read_results, row, write_page, write_results

STORE, PAGE = "junctions.json", PAGES / "junctions.md"
RANKS = {
    "motorway": 9,
    "trunk": 8,
    "primary": 7,
    "motorway_link": 6,
    "trunk_link": 6,
    "secondary": 6,
    "primary_link": 5,
    "secondary_link": 5,
    "tertiary": 5,
    "tertiary_link": 4,
    "raceway": 4,
    "unclassified": 3,
    "residential": 3,
    "road": 3,
    "living_street": 2,
    "service": 1,
    "track": 0,
}
CLASSES = [
    ("primary and higher", 7, 12),
    ("tertiary, secondary, links", 4, 8),
    ("residential, living street", 2, 5),
    ("service, track", 0, 3),
]


def add_arguments(parser):
    add_table(parser)
    parser.add_argument(
        "--sites", nargs="+", default=[], metavar="NAME=FOLDER", help="built sites; the others keep their last values"
    )


def vlq(text):
    """Whole numbers as Base64 VLQ of source maps."""
    digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
    values, bits, shift = [], 0, 0
    for character in text:
        digit = digits.index(character)
        bits, shift = bits | (digit % 32) << shift, shift + 5
        if digit < 32:
            values.append(-(bits >> 1) if bits % 2 else bits >> 1)
            bits = shift = 0
    return values


def extents(xodr):
    """The longer side of the box of each boundary, m, and the bytes of all surfaces."""
    sizes, size_bytes = [], 0
    for _, node in ElementTree.iterparse(xodr):
        if node.tag == "userData" and node.get("code", "").startswith("junction"):
            size_bytes += len(node.get("value"))
        if node.tag == "userData" and node.get("code") == "junctionBoundary":
            steps = vlq(node.get("value").split()[2])
            side = 0.0
            for axis in (0, 1):
                low = high = place = 0.0
                for step in steps[axis::2]:
                    place += step / 1000
                    low, high = min(low, place), max(high, place)
                side = max(side, high - low)
            sizes.append(side)
        if node.tag == "road":
            node.clear()
    return sizes, size_bytes


def kerb_radii(gpkg):
    """Of every node where ways meet and a radius was seen: the rank of the third arm and the radius."""
    arms, radius = {}, {}
    with sqlite3.connect(f"file:{gpkg}?mode=ro", uri=True) as database:
        classes = {
            (way, part): highway
            for way, part, highway in database.execute("select osm_id, part, highway from centrelines")
        }
        nodes = database.execute(
            "select osm_id, part, osm_node, s_m, kerb_radius_m from nodes order by osm_id, part, s_m"
        ).fetchall()
    for i, (way, part, node, _, seen) in enumerate(nodes):
        if not node:
            continue
        ends = sum(not 0 <= k < len(nodes) or nodes[k][:2] != (way, part) for k in (i - 1, i + 1))
        arms.setdefault(node, []).extend([RANKS.get(classes.get((way, part)), 1)] * (2 - ends))
        if seen:
            radius[node] = seen
    junctions = {node: sorted(ranks, reverse=True) for node, ranks in arms.items() if len(ranks) > 2}
    return len(junctions), [(junctions[node][2], r) for node, r in radius.items() if node in junctions]


def measure(folder):
    stages = json.loads((folder / "run.json").read_text())
    numbers = next(s for s in stages["stages"] if s["stage"] == "network")["numbers"]["junction_surfaces"]
    sizes, size_bytes = extents(folder / "roads.xodr")
    nodes, seen = kerb_radii(folder / "roads.gpkg")
    by_class = []
    for (_, least, _), most in zip(CLASSES, [99, *(c[1] for c in CLASSES)], strict=False):
        radii = [r for rank, r in seen if least <= rank < most]
        by_class.append([len(radii), *(statistics.quantiles(radii, n=4) if len(radii) > 1 else radii * 3)])
    return {
        "commit": commit(),
        **numbers,
        "largest_m": max(sizes),
        "median_size_m": statistics.median(sizes),
        "bytes": size_bytes,
        "file_bytes": (folder / "roads.xodr").stat().st_size,
        "nodes": nodes,
        "seen": len(seen),
        "kerb_radius_m": by_class,
    }


def table(numbers):
    sites = numbers.values()
    text = header(["", "asked", *numbers])
    text += row(["junctions with a surface", "", *(n["surfaces"] for n in sites)])
    text += row(["paved area, m2", "", *(fixed(n["area_m2"], 0) for n in sites)])
    text += row(
        [
            "extent, m: median, largest",
            "no bus terminal of 90",
            *(f"{fixed(n['median_size_m'], 0)}, {fixed(n['largest_m'], 0)}" for n in sites),
        ]
    )
    text += row(["connecting roads differ before, m: largest", "", *(fixed(n["max_disagreement_m"], 3) for n in sites)])
    text += row(
        [
            "a connecting road's own profile off the surface, m: largest before, after",
            "",
            *(f"{fixed(n['max_road_off_before_m'], 3)}, {fixed(n['max_road_off_after_m'], 3)}" for n in sites),
        ]
    )
    text += row(
        [
            "in the file, MB: surfaces, all",
            "",
            *(f"{fixed(n['bytes'] / 1e6, 1)}, {fixed(n['file_bytes'] / 1e6, 1)}" for n in sites),
        ]
    )
    text += row(
        [
            "nodes where ways meet; with a kerb radius from the labels",
            "",
            *(f"{n['nodes']}; {n['seen']}" for n in sites),
        ]
    )
    for i, (name, _, by_class) in enumerate(CLASSES):
        values = (n["kerb_radius_m"][i] for n in sites)
        text += row(
            [
                f"kerb radius seen, third arm {name} (else {by_class} m): number; quartiles, m",
                "",
                *(f"{v[0]}; {', '.join(fixed(q, 1) for q in v[1:])}" if v[0] else "0" for v in values),
            ]
        )
    return text


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for pair in args.sites:
            name, folder = pair.split("=", 1)
            numbers[name] = measure(pathlib.Path(folder))
            write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"junctions": table(numbers)})

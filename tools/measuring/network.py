# SPDX-License-Identifier: Apache-2.0
"""OpenDRIVE networks of the real towns: scores, schema, SUMO. Writes the tables of docs/measured/network.md.

Needs the refined roads "SITE drawn.default.gpkg" that `tools/measure refine` leaves in out/refinement/roads,
netconvert, xmllint and ../shared/data.
"""

import collections
import json
import os
import pathlib
import re
import subprocess
import sys

from measuring import routes
from measuring.common import (
    DATA,
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    exponential,
    fixed,
    header,
    percent,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "network.json", PAGES / "network.md"
STORES = [STORE, "opendrive.json"]  # of the page: tools/measure opendrive writes the other part
DTM = {"kvarnbyn": "kvarnbyn/dtm_10m_utm33.tif", "pardubice": "pardubice/dtm_20m.tif"}


def add_arguments(parser):
    add_tool(parser, "out/network")
    add_only(parser, DTM)
    add_table(parser)
    parser.add_argument(
        "--roads", type=pathlib.Path, default=ROOT / "out/refinement/roads", help="folder of the refined roads"
    )


def try_program(*words, **options):
    return subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False, **options)


def sumo(xodr, net):
    """Warnings by their text without names and numbers, {"Found sharp turn with radius # at the start of edge #.":
    3}.
    """
    made = try_program(
        "netconvert",
        "--opendrive-files",
        xodr,
        "--xml-validation",
        "never",
        "--aggregate-warnings",
        "-1",
        "-o",
        net,
        env={**os.environ, "SUMO_HOME": "/usr/share/sumo"},
    )
    lines = [line for line in (made.stdout + made.stderr).split("\n") if re.match("Warning|Error", line)]
    kinds = collections.Counter(re.sub(r"'[^']*'|-?\d+(\.\d+)?", "#", line) for line in lines)
    return {
        "status": made.returncode,
        "errors": sum(line.startswith("Error") for line in lines),
        "warnings": sum(line.startswith("Warning") for line in lines),
        "kinds": dict(kinds),
    }


def schema_18(folder, copy):
    """The 1.8.1 schema is XSD 1.1, xmllint knows 1.0: without assertions and types by attribute (our junctions are
    common ones).
    """
    copy.mkdir(parents=True, exist_ok=True)
    for file in sorted(folder.iterdir()):
        lines = [
            line.replace('name="junction" type="t_junction"', 'name="junction" type="t_junction_common"')
            for line in file.read_text().split("\n")
            if not re.search(r"<xs:(assert|alternative)", line)
        ]
        (copy / file.name).write_text("\n".join(lines))
    return copy / "OpenDRIVE_Core.xsd"


def is_valid(schema, file):
    return try_program("xmllint", "--noout", "--schema", schema, file).returncode == 0


def measure(site, args):
    tool, out = Tool(args.tool), args.out
    gpkg, xodr, xodr18, net = (out / f"{site}.{ending}" for ending in ("gpkg", "xodr", "18.xodr", "net.xml"))
    findings_file = out / f"{site}.findings.geojson"
    tool("elevate", "--roads", args.roads / f"{site} drawn.default.gpkg", "--dtm", DATA / DTM[site], "-o", gpkg)
    # Once timed, once with the file read back.
    built = try_program(
        "/usr/bin/time",
        "-f",
        "took %U %S s %M kB",
        tool.file,
        "network",
        "--roads",
        gpkg,
        "-o",
        xodr,
        "--findings",
        findings_file,
    )
    if built.returncode:
        sys.exit(built.stderr)
    user, system, kilobytes = map(float, re.search(r"took ([\d.]+) ([\d.]+) s (\d+) kB", built.stderr).groups())
    chain_km, chain_elements = re.search(r"chains of ([\d.]+) km fitted with (\d+) elements", built.stderr).groups()
    plan_m, profile_m = re.search(r"nodes lie within ([\d.]+) m of the lines and ([\d.]+) m", built.stderr).groups()
    checked = try_program(tool.file, "network", "--roads", gpkg, "-o", xodr, "--check")
    if checked.returncode:
        sys.exit(checked.stderr)
    points, round_trip_m = re.search(r"(\d+) points of the surface lie within (\S+) m", checked.stderr).groups()
    tool("network", "--roads", gpkg, "-o", xodr18, "--opendrive", "1.8")
    scores = tool.json("evaluate", "network", xodr, "--json")
    xsd = DATA / "opendrive/xsd"
    netconvert = sumo(xodr, net)
    found = collections.Counter(f["properties"]["code"] for f in json.loads(findings_file.read_text())["features"])
    return {
        "commit": commit(),
        "scores": scores,
        "valid": is_valid(xsd / "1.7.0/opendrive_17_core.xsd", xodr),
        "valid_18": is_valid(schema_18(xsd / "1.8.1", out / "xsd18"), xodr18),
        "netconvert": netconvert,
        "routes": routes.compare(gpkg, xodr, net),
        "findings": dict(found),
        "seconds": round(user + system, 2),
        "memory_mb": round(kilobytes / 1024),
        "plan_deviation_m": float(plan_m),
        "elevation_error_m": float(profile_m),
        "round_trip_m": float(round_trip_m),
        "round_trip_points": int(points),
        "chain_km": float(chain_km),
        "chain_elements": int(chain_elements),
        "file_mb": round(xodr.stat().st_size / 1e6, 1),
    }


def tiny(value):
    return "-" if value is None else "below 1e-6" if value < 1e-6 else fixed(value, 6)


def grades(n):
    return sum(count for kind, count in n["netconvert"]["kinds"].items() if "grade" in kind.lower())


ELEMENTS = ["line", "arc", "spiral", "paramPoly3"]
ROWS = [  # what, asked, value
    (
        "roads + connecting roads",
        "",
        lambda n: f"{n['scores']['roads'] - n['scores']['connecting_roads']} + {n['scores']['connecting_roads']}",
    ),
    ("junctions", "", lambda n: n["scores"]["junctions"]),
    ("length, connecting roads included, km", "", lambda n: fixed(n["scores"]["length_m"] / 1000, 1)),
    (
        "elements: line / arc / spiral / paramPoly3",
        "",
        lambda n: " / ".join(str(n["scores"]["elements"][k]) for k in ELEMENTS) if n["scores"]["elements"] else "-",
    ),
    ("metres an element, roads outside junctions", "20", lambda n: fixed(n["scores"]["mean_road_element_m"], 2)),
    (
        "metres an element, whole chains before they are cut",
        "20",
        lambda n: fixed(1000 * n["chain_km"] / n["chain_elements"], 1),
    ),
    ("largest distance of a node from the reference line, m", "0.10", lambda n: fixed(n["plan_deviation_m"], 3)),
    ("largest distance of a node from the profile, m", "", lambda n: fixed(n["elevation_error_m"], 3)),
    ("largest curvature jump outside junctions, 1/m", "0", lambda n: tiny(n["scores"]["max_curvature_jump"])),
    (
        "largest curvature rate outside junctions, 1/m2",
        "bounded",
        lambda n: fixed(n["scores"]["max_curvature_rate"], 3),
    ),
    ("largest heading jump, rad", "0", lambda n: tiny(n["scores"]["max_heading_jump_rad"])),
    ("largest gap between ends that meet, m", "", lambda n: tiny(n["scores"]["max_joint_gap_m"])),
    ("largest gradient kink", "0.001", lambda n: tiny(n["scores"]["max_gradient_kink"])),
    (
        "valid against the 1.7.0 / 1.8.1 schema",
        "yes / yes",
        lambda n: f"{'yes' if n['valid'] else 'NO'} / {'yes' if n['valid_18'] else 'NO'}",
    ),
    ("netconvert: errors", "0", lambda n: n["netconvert"]["errors"]),
    ("netconvert: warnings about geometry or links", "0", lambda n: n["netconvert"]["warnings"] - grades(n)),
    ("netconvert: warnings about grades ([elevate.md](elevate.md))", "", grades),
    ("routes of OSM that SUMO finds", "99 %", lambda n: f"{percent(n['routes']['share'])} %"),
    ("the same without the U-turns netconvert adds", "", lambda n: f"{percent(n['routes']['no_u_turns_share'])} %"),
    ("connected share of the length", "", lambda n: f"{percent(n['scores']['connected_share'])} %"),
    (
        "links without an answer, lane link errors, dead lanes",
        "0, 0, 0",
        lambda n: ", ".join(str(n["scores"][k]) for k in ("broken_links", "lane_link_errors", "dead_lanes")),
    ),
    ("narrowest driving lane where it is widest, m", "", lambda n: fixed(n["scores"]["min_lane_width_m"], 2)),
    ("crossings on two levels", "", lambda n: n["scores"]["crossings"]),
    ("smallest clearance there, m", "4.7", lambda n: fixed(n["scores"]["min_clearance_m"], 2)),
    ("surface read back, largest difference, m", "0.001", lambda n: exponential(n["round_trip_m"])),
    ("network stage with reading and writing, s of processor time", "", lambda n: fixed(n["seconds"], 1)),
    ("memory, MB", "", lambda n: n["memory_mb"]),
    ("file, MB", "", lambda n: fixed(n["file_mb"], 1) if n["file_mb"] % 1 else int(n["file_mb"])),
]


def numbers_table(numbers):
    return header(["", "asked", *(site.capitalize() for site in numbers)]).replace("|  |", "| |", 1) + "".join(
        row([what, asked, *(value(n) for n in numbers.values())]) for what, asked, value in ROWS
    )


def crossings_table(numbers):
    """Every crossing on two levels of every town, by clearance."""

    def end(e):
        return f"{e['highway']}{', way ' + str(e['osm_id']) if e.get('osm_id') else ' (in a junction)'}"

    def near(x):
        return fixed(x, 0)

    return header(["town", "place (x, y), m", "above", "below", "clearance, m"]) + "".join(
        row([site, f"{near(c['x'])}, {near(c['y'])}", end(c["upper"]), end(c["lower"]), fixed(c["clearance_m"], 2)])
        for site, n in numbers.items()
        for c in n["scores"]["crossing_places"]
    )


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        args.out.mkdir(parents=True, exist_ok=True)
        for site in args.only:
            numbers[site] = measure(site, args)
            write_results(STORE, numbers)
    write_page(PAGE, STORES, {"network": numbers_table(numbers), "crossings": crossings_table(numbers)})

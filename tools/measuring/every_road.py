# SPDX-License-Identifier: Apache-2.0
"""A family car on every road of a town, by drive --all-roads. Writes docs/measured/every_road.md.

Give networks as NAME=FILE, for example  --files Kvarnbyn=out/kvarnbyn/roads.xodr Pardubice=out/pardubice/roads.xodr Two
threads each: some ten processor minutes for a town of 23 km2. With --table nothing runs: the page is written from the
last results, bench/results/every_road.json.
"""

import csv
import json
import re

from measuring.common import (
    PAGES,
    Tool,
    add_table,
    add_tool,
    children_seconds,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "every_road.json", PAGES / "every_road.md"
KINDS = {
    "drive.off_road": "off the road",
    "drive.jolt": "above 5 m/s2 vertically",
    "drive.bump": "step of the surface",
    "drive.too_tight": "tighter than the car can turn",
    "drive.not_finished": "not finished",
}
SHOWN = 12  # places of a kind and network


def add_arguments(parser):
    add_tool(parser, "out/every_road")
    add_table(parser)
    parser.add_argument(
        "--files", nargs="+", default=[], metavar="NAME=FILE", help="networks; the others keep their last values"
    )


def measure(tool, file, folder):
    before = children_seconds()
    wall_s = tool.timed(
        "--threads", "2", "drive", "--network", file, "--all-roads", "--vehicle", "family", "-o", folder
    )
    numbers = json.loads((folder / "all_roads.json").read_text())
    with (folder / "all_roads.csv").open() as rows:
        places = [{**r, "x_m": float(r["x_m"]), "y_m": float(r["y_m"])} for r in csv.DictReader(rows)]
    return {
        "commit": commit(),
        "machine": machine(),
        "wall_s": round(wall_s, 1),
        "processor_s": round(children_seconds() - before, 1),
        **numbers,
        "places": places,
    }


def size_of(place):
    """The number of a finding's message, so that the worst comes first."""
    found = re.search(r"(?:by|of) ([+-]?[\d.]+) m", place["message"])
    return abs(float(found[1])) if found else 0.0


def worst(places, kind):
    """Largest first; bends: the smallest radius first."""
    sign = 1 if kind == "drive.too_tight" else -1
    return sorted((p for p in places if p["code"] == kind), key=lambda p: (sign * size_of(p), p["x_m"], p["y_m"]))


def page(results):
    def of(get):
        return [get(n) for n in results.values()]

    def counted(kind):
        return of(lambda n: len(worst(n["places"], kind)))

    text = (
        "# Measured: a family car on every road\n\nMethod: [drive.md](../drive.md). Written by `tools/measure "
        "every-road`.\n\n"
    )
    text += "Every road of the largest connected part in every direction, connecting roads too, at the legal speed.\n"
    text += "Places within 10 m of each other count once.\n\n"
    rows = [
        ["routes", "-", *of(lambda n: n["routes"])],
        ["routes too short for the car", "-", *of(lambda n: n["routes_too_short"])],
        ["km of routes", "-", *of(lambda n: fixed(n["routes_m"] / 1000, 1))],
        ["km driven", "-", *of(lambda n: fixed(n["length_m"] / 1000, 1))],
        ["hours driven", "-", *of(lambda n: fixed(n["driven_s"] / 3600, 1))],
        ["places where a tyre leaves the road", 0, *counted("drive.off_road")],
        [
            "share of tyre contacts beside the road, per million",
            0,
            *of(lambda n: fixed(1e6 * n["tyre_misses"] / max(n["tyre_queries"], 1), 1)),
        ],
        ["places above 5 m/s2 vertically", 0, *counted("drive.jolt")],
        ["largest vertical acceleration, m/s2", "5.0", *of(lambda n: fixed(n["max_vertical_mps2"], 1))],
        ["steps of the surface above 20 mm", 0, *counted("drive.bump")],
        ["bends tighter than the car can turn: it stops before and goes on behind", "-", *counted("drive.too_tight")],
        ["routes not driven to the end", 0, *of(lambda n: n["routes"] - n["routes_too_short"] - n["routes_finished"])],
        ["processor time, s", "-", *of(lambda n: fixed(n["processor_s"], 0))],
        ["wall time, two threads, s", "-", *of(lambda n: fixed(n["wall_s"], 0))],
        ["times real time (processor)", "-", *of(lambda n: fixed(n["driven_s"] / n["processor_s"], 0))],
    ]
    text += header(["", "asked", *results]).replace("|  |", "| |", 1) + "".join(map(row, rows))
    text += (
        "\nA bend counts as too tight over a whole wheelbase; a route that ends before one and has nothing left "
        "behind it is not driven to the end.\n"
    )
    text += (
        f"Measured on {next(iter(results.values()))['machine']['cpu']}; other work may have run beside it, so "
        "processor time is what counts.\n\n## Places\n\n"
    )
    text += f"At most {SHOWN} of a kind, the worst first.\n\n" + header(["network", "kind", "x, y", "what"])
    for name, n in results.items():
        for kind, title in KINDS.items():
            for p in worst(n["places"], kind)[:SHOWN]:
                text += row([name, title, f"{fixed(p['x_m'], 1)}, {fixed(p['y_m'], 1)}", p["message"]])
    return text


def run(args):
    results = read_results(STORE, {})
    if not args.table:
        for pair in args.files:
            name, file = pair.split("=", 1)
            numbers = measure(Tool(args.tool), file, args.out / name)
            results = dict(
                sorted({**read_results(STORE, {}), name: numbers}.items())
            )  # another run may have written in between
            write_results(STORE, results)
    write_page(PAGE, [STORE], page(results))

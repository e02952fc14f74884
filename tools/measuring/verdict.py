# SPDX-License-Identifier: Apache-2.0
"""Verdict of `evaluate network` on OpenDRIVE files. Writes the tables of docs/measured/verdict.md.

Give files as NAME=FILE, for example  --files village=out/village/roads.xodr kvarnbyn=out/kvarnbyn/roads.xodr
"""

from measuring.common import (
    PAGES,
    Tool,
    add_table,
    add_tool,
    children_seconds,
    commit,
    fixed,
    header,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "verdict.json", PAGES / "verdict.md"
KINDS = {  # kind: unit, factor, digits
    "hole": ("m", 1, 2),
    "step": ("mm", 1000, 0),
    "vertical_acceleration": ("m/s2", 1, 2),
    "twist": ("%", 100, 1),
    "gap": ("m", 1, 3),
    "heading_jump": ("rad", 1, 4),
    "curvature_jump": ("m/s2", 1, 2),
    "width_jump": ("m", 1, 3),
    "grip_jump": ("factor", 1, 2),
}


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument(
        "--files", nargs="+", default=[], metavar="NAME=FILE", help="networks; the others keep their last values"
    )


def measure(tool, file):
    before = children_seconds()
    scores = tool.json("evaluate", "network", file, "--json")
    return {
        "commit": commit(),
        "seconds": round(children_seconds() - before, 1),
        "verdict": scores["verdict"],
        "faults": scores["faults"],
        "length_m": scores["length_m"],
    }


def verdict_table(numbers):
    rows = [
        ["verdict", "", *("pass" if n["verdict"]["pass"] else "FAIL" for n in numbers.values())],
        ["lanes, links", "", *(f"{n['verdict']['lanes']}, {n['verdict']['links']}" for n in numbers.values())],
        ["wheel tracks, km", "", *(fixed(n["verdict"]["track_km"], 1) for n in numbers.values())],
    ]
    for kind, (unit, factor, digits) in KINDS.items():
        values = [n["verdict"][kind] for n in numbers.values()]
        rows.append(
            [
                f"{kind.replace('_', ' ')}, {unit}: worst (places)",
                fixed(factor * values[0]["limit"], digits),
                *(f"{fixed(factor * v['worst'], digits)} ({v['places']})" for v in values),
            ]
        )
    rows.append(["processor time of `evaluate network`, s", "", *(fixed(n["seconds"], 1) for n in numbers.values())])
    return header(["", "limit", *numbers]).replace("|  |", "| |", 1) + "".join(map(row, rows))


def places_table(numbers):
    """The worst three of every kind of every network."""
    text = header(["network", "kind", "value", "road, lane, s", "x, y"])
    for name, n in numbers.items():
        shown = {}
        for f in n["faults"]:
            shown[f["kind"]] = shown.get(f["kind"], 0) + 1
            if shown[f["kind"]] > 3:
                continue
            unit, factor, digits = KINDS[f["kind"]]
            text += row(
                [
                    name,
                    f["kind"].replace("_", " "),
                    f"{fixed(factor * f['value'], digits)} {unit}",
                    f"{f['road']}, {f['lane']}, {fixed(f['s'], 1)}",
                    f"{fixed(f['x'], 1)}, {fixed(f['y'], 1)}",
                ]
            )
    return text


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for pair in args.files:
            name, file = pair.split("=", 1)
            numbers[name] = measure(Tool(args.tool), file)
            write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"verdict": verdict_table(numbers), "places": places_table(numbers)})

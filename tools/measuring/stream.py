# SPDX-License-Identifier: Apache-2.0
"""The viewer on a large site: first picture, memory, holes, triangles and draw calls while driving. Writes
docs/measured/stream.md.

Give sites as NAME=OUT, OUT the folder that `orthodrive build` wrote, for example
  --sites region=region/out
Chromium draws with the processor, and by the clock: nothing else should run beside it.
"""

import json
import math
import os
import pathlib

from measuring.common import (
    PAGES,
    ROOT,
    Tool,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    run_program,
    write_page,
    write_results,
)

STORE, PAGE = "stream.json", PAGES / "stream.md"


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument(
        "--sites", nargs="+", default=[], metavar="NAME=OUT", help="built sites; the others keep their last values"
    )
    parser.add_argument(
        "--cameras", nargs="+", default=["driver", "follow"], help="that are driven with (driver follow)"
    )


def measure(tool, out, cameras):
    script = ROOT / "viewer/scripts/measure_stream.mjs"
    return {
        "commit": commit(),
        "machine": machine(),
        "load": round(os.getloadavg()[0], 1),
        "tileset_bytes": (out / "scene/tileset.json").stat().st_size,
        "cameras": {
            camera: json.loads(run_program("node", script, out, tool.file, f"camera={camera}")) for camera in cameras
        },
    }


def table(numbers):
    columns = [(name, camera, n, n["cameras"][camera]) for name, n in numbers.items() for camera in n["cameras"]]

    def first(c, view, key):
        return fixed(c["first"].get(view, {}).get(key) or math.nan, 1)

    def drive(key, digits=0):
        return lambda n, camera, c: fixed(c["drive"][key], digits)

    rows = [
        ("first picture from the air: all of it, s", "3", lambda n, camera, c: first(c, "fly", "first_s")),
        ("... as fine as it gets, s", "", lambda n, camera, c: first(c, "fly", "whole_s")),
        ("first picture from this camera: all of it, s", "3", lambda n, camera, c: first(c, camera, "first_s")),
        ("... with the road's own mesh under the car, s", "", lambda n, camera, c: first(c, camera, "road_s")),
        ("... as fine as it gets, s", "", lambda n, camera, c: first(c, camera, "whole_s")),
        (
            "driven, m; m/s",
            "10000; 50",
            lambda n, camera, c: (
                f"{fixed(c['drive']['driven_m'], 0)}; {fixed(c['drive']['driven_m'] / c['drive']['seconds'], 0)}"
            ),
        ),
        ("pictures", "", drive("pictures")),
        ("longest picture, s", "", drive("longest_picture_s", 1)),
        ("tiles held, MB of the graphics card", "400", drive("graphics_mb")),
        ("... of files", "", drive("file_mb")),
        ("... number", "", drive("tiles")),
        ("holes in the road within 300 m, places", "0", drive("holes")),
        ("places of the road within 300 m ever shown by a coarser level", "", drive("coarse")),
        ("triangles of a picture with its shadows", "2,000,000", lambda n, camera, c: f"{c['drive']['triangles']:,}"),
        ("draw calls of a picture with its shadows", "600", drive("calls")),
        ("tileset.json, MB", "", lambda n, camera, c: fixed(n["tileset_bytes"] / 1e6)),
        ("others' load of the machine at the start", "", lambda n, camera, c: n["load"]),
    ]
    return header(
        ["largest of all pictures", "asked", *(f"{name}, {camera}" for name, camera, _, _ in columns)]
    ) + "".join(
        row([what, asked, *(value(n, camera, c) for _, camera, n, c in columns)]) for what, asked, value in rows
    )


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for pair in args.sites:
            name, out = pair.split("=")
            numbers[name] = measure(Tool(args.tool), pathlib.Path(out).resolve(), args.cameras)
            write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"stream": table(numbers)})

# SPDX-License-Identifier: Apache-2.0
"""Pictures of built sites, from the driver's seat and from the air, for docs/pictures.md; with --sheets twenty a site.

    tools/measure pictures --sites kvarnbyn=out/kvarnbyn ring=out/ring tools/measure pictures --sites
    kvarnbyn=out/kvarnbyn --sheets sheets    # sheets/kvarnbyn.jpg and a folder of its pictures

Wants Chromium and the built viewer. The pictures "before" are of the commit that the page names; they are not made
anew.
"""

import pathlib
import sys

from measuring.common import IMAGES, ROOT, add_tool, run_program

# seconds of the lap at which a site is looked at
VIEWS = {"village": 5, "kvarnbyn": 11, "pardubice": 20, "ring": 40, "virtual_ring": 40}
HIDDEN = "off=route"  # the line that shows the lap


def add_arguments(parser):
    add_tool(parser)
    parser.add_argument(
        "--sites", nargs="+", required=True, metavar="NAME=OUT", help=f"built sites; names: {', '.join(VIEWS)}"
    )
    parser.add_argument(
        "--sheets",
        type=pathlib.Path,
        metavar="DIR",
        help="write contact sheets of twenty pictures into a folder instead",
    )


def run(args):
    for pair in args.sites:
        name, out = pair.split("=")
        if name not in VIEWS:
            sys.exit(f"no views are known of {name}; known are {', '.join(VIEWS)}")

        def script(file, *words):
            return run_program(
                "node", ROOT / "viewer/scripts" / file, pathlib.Path(out).resolve(), args.tool.resolve(), *words
            )

        if args.sheets:
            args.sheets.mkdir(parents=True, exist_ok=True)
            script("contact_sheet.mjs", args.sheets / f"{name}.jpg")
            continue
        for view, camera in {"seat": "driver", "air": "fly"}.items():
            script("screenshot.mjs", IMAGES / f"{name}_{view}.jpg", f"?camera={camera}&t={VIEWS[name]}&{HIDDEN}")

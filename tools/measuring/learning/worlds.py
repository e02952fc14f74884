# SPDX-License-Identifier: Apache-2.0
"""Makes the synthetic sites of other worlds that models/training/worlds.txt lists, in out/synth.

Sites that are there already are left as they are. --experiment prints the [[raster]] tables that an experiment in
models/ names them by (docs/train.md)."""

import pathlib
import time

from measuring.common import ROOT, Tool, add_tool


def listed_sites():
    """Rows of preset, world, seed, size, gsd, by name."""
    text = (ROOT / "models/training/worlds.txt").read_text()
    rows = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
    return {"-".join(row[:3]): row for row in rows}


def add_arguments(parser):
    add_tool(parser)
    parser.add_argument("--only", default="", metavar="TEXT", help="sites whose name contains this")
    parser.add_argument(
        "--textures", type=pathlib.Path, help="textures of photos for them, as tools/paint quilt writes them"
    )
    parser.add_argument(
        "--experiment", type=float, metavar="WEIGHT", help="make none: print tables whose weights sum to this"
    )


def run(args):
    sites = {name: row for name, row in listed_sites().items() if args.only in name}
    if args.experiment is not None:
        for name in sites:
            print(
                f'[[raster]]\nname = "{name}"\nfolder = "../out/synth/{name}"\nmin_zoom = 0.8\nmax_zoom = 1.5\nweight '
                f"= {args.experiment / len(sites):.4f}\n"
            )
        return
    tool = Tool(args.tool)
    for name, (preset, world, seed, size, gsd) in sites.items():
        start = time.monotonic()
        more = ["--textures", args.textures] if args.textures else []
        tool.synth(
            ROOT / "out/synth" / name,
            "--preset",
            preset,
            "--world",
            world,
            "--seed",
            seed,
            "--size",
            size,
            "--gsd",
            gsd,
            *more,
        )
        print(f"{name}: {time.monotonic() - start:.1f} s", flush=True)

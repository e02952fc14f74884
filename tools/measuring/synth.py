# SPDX-License-Identifier: Apache-2.0
"""Synthetic sites: what making them takes, how far their map is from their truth. Writes docs/measured/synth.md.

Makes every site anew: two minutes. The Red Bull Ring needs ../shared/data/spielberg.
"""

import shutil

from measuring.common import (
    PAGES,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    read_results,
    row,
    write_page,
    write_results,
)
from measuring.refine import SYNTHETIC
from measuring.scene import run_measured

STORE, PAGE = "synth.json", PAGES / "synth.md"
SITES = {
    "village, seed 7": ["--preset", "village", "--seed", "7"],
    "village, seed 11": ["--preset", "village", "--seed", "11"],
    "circuit, seed 7": ["--preset", "circuit", "--seed", "7"],
    "junction, seed 7": ["--preset", "junction", "--seed", "7"],
    "Red Bull Ring": SYNTHETIC["ring"],
}


def add_arguments(parser):
    add_tool(parser, "out/synth_measured")
    add_only(parser, SITES)
    add_table(parser)


def measure(tool, site, options):
    shutil.rmtree(site, ignore_errors=True)
    _, processor_s, memory_mb = run_measured(tool.file, "--quiet", "synth", *options, "-o", site)
    scores = tool.json("evaluate", "roads", site / "roads.osm", site / "truth", "--json")
    return {
        "commit": commit(),
        "processor_s": round(processor_s, 1),
        "memory_mb": round(memory_mb),
        "surface_iou": scores["surface_iou"],
        "offset_m": scores["offset_m"],
        "width_m": scores["width_m"],
    }


def table(numbers):
    text = header(["site", "surface IoU", "offset mean, p95", "width error mean", "processor s", "memory, MB"])
    for name in SITES:
        if n := numbers.get(name):
            text += row(
                [
                    name,
                    fixed(n["surface_iou"]),
                    f"{fixed(n['offset_m']['mean_abs'])} m, {fixed(n['offset_m']['p95'])} m",
                    f"{fixed(n['width_m']['mean_abs'])} m",
                    fixed(n.get("processor_s"), 0),
                    n.get("memory_mb", "-"),
                ]
            )
    return text


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        args.out.mkdir(parents=True, exist_ok=True)
        for name in args.only:
            numbers[name] = measure(Tool(args.tool), args.out / name.replace(", ", "_").replace(" ", "_"), SITES[name])
            write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"synth": table(numbers)})

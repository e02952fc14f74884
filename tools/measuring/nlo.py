# SPDX-License-Identifier: Apache-2.0
"""The reference's nonlinear optimisation (baselines/nlo_roads): table 3.4 of the thesis on our sites, and how much its
results hang on what the thesis leaves open, on sites with exact truth. Writes docs/measured/nlo.md. 35 runs a synthetic
site, 11 a real one.
"""

import math
import random
import re

from measuring import refine
from measuring.common import (
    PAGES,
    add_only,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    percent,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "nlo.json", PAGES / "nlo.md"
SITES = {
    "village": "village 99",
    "circuit": "circuit 7",
    "junction": "junction 7",
    "ring": "Red Bull Ring",
    "kvarnbyn": "Kvarnbyn, drawn",
    "pardubice": "Pardubice, drawn",
}
ROWS = {  # of table 3.4: options, published IoU % and variance of the width
    "set 1, 1 x 20": (["--weights", "1"], "80.09", "0.378"),
    "set 1, 1 x 40": (["--weights", "1", "--iterations", "40"], "80.19", "0.370"),
    "set 1, 2 x 20": (["--weights", "1+1"], "80.40", "0.410"),
    "set 2, 1 x 20": (["--weights", "2"], "65.97", "0.091"),
    "set 2, 1 x 40": (["--weights", "2", "--iterations", "40"], "65.89", "0.084"),
    "set 2, 2 x 20": (["--weights", "2+2"], "66.38", "0.069"),
    "set 1+2, 20 + 20": (["--weights", "1+2"], "80.32", "0.179"),
    "set 1+2, 40 + 40": (["--weights", "1+2", "--iterations", "40"], "80.31", "0.17"),
    "set 1+2, filter and join": (["--weights", "1+2", "--filter-and-join"], "80.69", "-"),
}
OPEN = {  # one thing changed at a time
    "as it is": [],
    "offset within 3 m": ["--search-radius", "3"],
    "offset within 8 m": ["--search-radius", "8"],
    "offset within 50 m": ["--search-radius", "50"],
    "width 0.67 to 1.5 times": ["--width-factors", "0.67", "1.5"],
    "width 0.33 to 3 times": ["--width-factors", "0.33", "3"],
    "no label costs 0.5": ["--unlabelled-cost", "0.5"],
    "no label costs 0": ["--unlabelled-cost", "0"],
    "strips of 0.75 m": ["--strip", "0.75"],
    "strips of 2.5 m": ["--strip", "2.5"],
    "nodes every 1 m": ["--spacing", "1"],
    "nodes every 4 m": ["--spacing", "4"],
}
SCATTER_M = (0, 1, 2, 3)  # of each node of the map by itself: standard deviation in x and y
SCATTERED = ("village", "ring")


def scatter(source, target, size_m):
    """OSM whose nodes each err by themselves."""
    chance = random.Random(1)
    north = 111320

    def moved(match):
        lat, lon = map(float, match.groups())
        up, right = (chance.gauss(0, size_m) / north for _ in range(2))
        return f'lat="{lat + up:.8f}" lon="{lon + right / math.cos(math.radians(lat)):.8f}"'

    target.write_text(re.sub(r'lat="([-\d.]+)" lon="([-\d.]+)"', moved, source.read_text()))


def add_arguments(parser):
    add_tool(parser, "out/refinement")
    add_only(parser, SITES)
    add_table(parser)


class Runs:
    """Runs of the baseline and of what it is compared with, each kept as it comes."""

    def __init__(self, args):
        self.sites, self.out, self.commit = refine.Sites(args), args.out / "nlo", commit()
        self.out.mkdir(parents=True, exist_ok=True)
        self.numbers = read_results(STORE, {"runs": {}})

    def score(self, site, name, options, osm=None):
        given, truth, more = self.sites.of(site)
        osm = osm or given["osm"]
        file, before = self.out / f"{site}.gpkg", self.out / f"{site}.map.gpkg"
        tool = self.sites.tool
        if not before.exists():
            tool("refine", "--osm", given["osm"], "--labels", given["labels"], "-o", before, "--method", "none")
        seconds = tool.timed("refine", "--osm", osm, "--labels", given["labels"], "-o", file, *options)
        scores = tool.json("evaluate", "roads", file, truth, "--before", before, *more, "--json")
        self.numbers["runs"][f"{site}, {name}"] = {
            "commit": self.commit,
            "seconds": round(seconds, 2),
            **{k: scores[k] for k in ("surface_iou", "width_variance_m2", "offset_m", "width_m")},
        }
        write_results(STORE, self.numbers)
        print(site, name, fixed(100 * scores["surface_iou"]), fixed(scores["width_variance_m2"], 3), flush=True)

    def measure(self, site):
        given = self.sites.of(site)[0]
        self.score(site, "map", ["--method", "none"])
        self.score(site, "default", ["--road-probability", given["probability"]])
        for name, (options, *_) in ROWS.items():
            self.score(site, name, ["--method", "nlo", *options])
        for name, options in OPEN.items() if site in refine.SYNTHETIC else ():
            for weights in ("1", "1+2"):
                self.score(site, f"{name}, {weights}", ["--method", "nlo", "--weights", weights, *options])
        for size_m in SCATTER_M if site in SCATTERED else ():
            osm = self.out / f"{site}.scattered.osm"
            scatter(given["osm"], osm, size_m)
            for weights in ("1", "2", "1+2"):
                name = f"scattered by {size_m} m, {weights}"
                self.score(site, name, ["--method", "nlo", "--weights", weights], osm)
            self.score(site, f"scattered by {size_m} m, default", ["--road-probability", given["probability"]], osm)


def published_table(runs):
    sites = [s for s in SITES if all(f"{s}, {name}" in runs for name in ("map", "default", *ROWS))]
    text = header(["IoU %, variance of the width m2", "thesis", *(SITES[s] for s in sites)])
    for name, published in [("map", ""), *((n, f"{iou}, {var}") for n, (_, iou, var) in ROWS.items()), ("default", "")]:
        found = [runs[f"{s}, {name}"] for s in sites]
        text += row(
            [name, published, *(f"{percent(r['surface_iou'], 2)}, {fixed(r['width_variance_m2'], 3)}" for r in found)]
        )
    missing = [title for site, title in SITES.items() if site not in sites]
    return text + (f"\nNot measured yet: {', '.join(missing)}.\n" if missing else "")


def open_table(runs):
    sites = [s for s in SITES if all(f"{s}, {name}, {w}" in runs for name in OPEN for w in ("1", "1+2"))]
    text = header(["IoU %: set 1, set 1+2", *(SITES[s] for s in sites), "largest change of set 1+2, points"])
    for name in OPEN:
        found = [[runs[f"{s}, {name}, {w}"] for w in ("1", "1+2")] for s in sites]
        changes = [
            both[1]["surface_iou"] - runs[f"{s}, as it is, 1+2"]["surface_iou"]
            for s, both in zip(sites, found, strict=True)
        ]
        largest = percent(max(changes, key=abs, default=None))
        text += row([name, *(", ".join(percent(r["surface_iou"]) for r in both) for both in found), largest])
    return text


def scatter_table(runs):
    methods = {"1": "set 1", "2": "set 2", "1+2": "set 1+2", "default": "default"}
    text = header(["IoU %", *(f"{SITES[s]}: {title}" for s in SCATTERED for title in methods.values())])
    for size_m in SCATTER_M:
        found = [runs.get(f"{s}, scattered by {size_m} m, {m}") for s in SCATTERED for m in methods]
        text += row([f"nodes off by {size_m} m", *(percent(r["surface_iou"]) if r else "-" for r in found)])
    return text


def run(args):
    if not args.table:
        runs = Runs(args)
        for site in args.only:
            runs.measure(site)
    runs = read_results(STORE, {"runs": {}})["runs"]
    tables = {"table 3.4": published_table(runs), "open": open_table(runs), "scatter": scatter_table(runs)}
    write_page(PAGE, [STORE], tables)

# SPDX-License-Identifier: Apache-2.0
"""The example of the thesis, sec. 4.3: sites/ring.toml fetched and built. Writes docs/measured/virtual_ring.md.

Servers on loopback give the synthetic ring (real edges, OSM way and heights, all else made up) in place of the real
ones; the site file is the shipped one but for their addresses. Ten minutes on two cores that do nothing else. Needs
python3-gdal, python3-numpy, python3-pil.
"""

import csv
import json
import shutil
import sqlite3
import sys
import time

from measuring import refine
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
    percent,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "virtual_ring.json", PAGES / "virtual_ring.md"
ZOOM = 18  # the finest that the stand-in has: 0.41 m a pixel, of a photo of 0.5 m; the thesis' is 19
OFFICIAL_LAP_M = 4318  # of the track's operator; the thesis does not state it


def add_arguments(parser):
    add_tool(parser, "out/virtual_ring")
    add_table(parser)


def fetch_and_build(tool, out):
    """Seconds of both; the folders are begun anew."""
    sys.path.insert(0, str(ROOT / "tests/fetch"))
    import served_site  # noqa: PLC0415 (of the tests; its folder is named in the line above)

    synthetic = tool.synth(out / "synthetic", *refine.SYNTHETIC["ring"], "--size", 4800, "--gsd", 0.5)
    for folder in ("ring", "built"):
        shutil.rmtree(out / folder, ignore_errors=True)
    running, text = served_site.serve(ROOT / "sites/ring.toml", synthetic, ZOOM)
    (out / "ring.toml").write_text(text)
    try:
        fetched = tool.timed("fetch", out / "ring.toml")
    finally:
        for server in running:
            server.close()
    start = time.monotonic()
    tool("build", out / "ring.toml", "-o", out / "built")
    return fetched, time.monotonic() - start


def lap_of(folder):
    rows = list(csv.DictReader((folder / "drive/lap.csv").open()))
    return {"length_m": float(rows[-1]["s_m"]) - float(rows[0]["s_m"]), "seconds": float(rows[-1]["t_s"])}


def measure(tool, out):
    fetched, built = fetch_and_build(tool, out)
    folder = out / "built"
    stages = json.loads((folder / "run.json").read_text())["stages"]
    photo = json.loads((out / "ring/photo.mbtiles.source.json").read_text())
    with sqlite3.connect(folder / "roads.gpkg") as base:
        nodes = base.execute("select count(*) from nodes").fetchone()[0]
    return {
        "commit": commit(),
        "machine": machine(),
        "fetch_seconds": round(fetched, 1),
        "build_seconds": round(built, 1),
        "photo": {k: photo[k] for k in ("tiles", "zoom", "resolution_m", "missing_tiles")},
        "photo_mb": round((out / "ring/photo.mbtiles").stat().st_size / 1e6, 1),
        "nodes": nodes,
        "peak_gb": max(s["peak_memory_bytes"] for s in stages) / 1e9,
        "stages": {
            s["stage"]: {
                "seconds": round(s["seconds"], 1),
                "peak_mb": round(s["peak_memory_bytes"] / 1e6),
                "numbers": s.get("numbers", {}),
            }
            for s in stages
        },
        "scene": tool.json("evaluate", "scene", folder / "scene", folder / "roads.xodr", "--json"),
        "truth": tool.json("evaluate", "site", folder, "--truth", out / "synthetic/truth", "--json"),
        "lap": lap_of(folder),
    }


def run(args):
    if not args.table:
        args.out.mkdir(parents=True, exist_ok=True)
        write_results(STORE, measure(Tool(args.tool), args.out))
    write_page(
        PAGE, [STORE], {"steps": steps(read_results(STORE, {})), "stages": stages_table(read_results(STORE, {}))}
    )

# SPDX-License-Identifier: Apache-2.0
"""The example of the thesis, sec. 4.3: sites/ring.toml fetched and built. Writes docs/measured/virtual_ring.md.

Servers on loopback give the synthetic ring (real edges, OSM way and heights, all else made up) in place of the real
ones; the site file is the shipped one but for their addresses. Ten minutes on two cores that do nothing else. Needs
python3-gdal, python3-numpy, python3-pil.
"""

import csv
import json
import os
import shutil
import sqlite3
import sys
import time
import tomllib
import xml.etree.ElementTree

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
TRACK = "Red Bull Ring"  # of the OSM way
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
    """Of the track's reference line, and as driven, which is shorter: bends are cut within the lane."""
    rows = list(csv.DictReader((folder / "drive/lap.csv").open()))
    roads = xml.etree.ElementTree.parse(folder / "roads.xodr").getroot().findall("road")
    return {
        "track_m": sum(float(road.get("length")) for road in roads if road.get("name") == TRACK),
        "driven_m": float(rows[-1]["s_m"]) - float(rows[0]["s_m"]),
        "seconds": float(rows[-1]["t_s"]) - float(rows[0]["t_s"]),
    }


def scores(tool, out):
    """Within the site's area; the synthetic site is larger."""
    west, south, east, north = tomllib.loads((out / "ring.toml").read_text())["area"]["bbox_wgs84"]
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    polygon = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    area = out / "area.geojson"
    area.write_text(json.dumps({"type": "FeatureCollection", "features": [polygon]}))
    return tool.json("evaluate", "site", out / "built", "--truth", out / "synthetic/truth", "--area", area, "--json")


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
        "load": round(os.getloadavg()[2], 1),
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
        "truth": scores(tool, out),
        "lap": lap_of(folder),
    }


# ---- what the pages say


def number(result, stage, name):
    return result["stages"][stage]["numbers"].get(name)


def seconds_of(result, *stages):
    return sum(result["stages"][stage]["seconds"] for stage in stages)


def listed(*values):
    return "; ".join(map(str, values))


def on_the_map(result):
    """Steps up to the refined roads: step, thesis, ours."""
    photo, roads, labels = result["photo"], result["truth"]["roads"], result["truth"]["labels"]
    tiles = number(result, "segment", "pixels") / 256**2
    seconds = seconds_of(result, "segment")
    offset, width = fixed(roads["offset_m"]["mean_abs"]), fixed(roads["width_m"]["mean_abs"])
    level, metres = photo["zoom"], fixed(photo["resolution_m"])
    return [
        ("area, km2", "about 20", fixed(result["scene"]["ground_km2"], 1)),
        ("photo: level of the WMTS; m a pixel", "19; 0.20", listed(level, metres)),
        (
            "fetched: tiles of the photo; MB of them; s of all sources",
            "not stated",
            listed(photo["tiles"], result["photo_mb"], fixed(result["fetch_seconds"], 0)),
        ),
        (
            "labels: accuracy %; IoU of roads %",
            "90.51 on 38 classes; not stated",
            listed(f"{percent(labels['pixel_accuracy'])} on 8 classes", percent(labels["road_iou"])),
        ),
        (
            "labels: s a tile of 256 x 256 px, without a CRF",
            "0.410",
            f"{fixed(seconds / tiles, 4)}, of {fixed(tiles, 0)} tiles",
        ),
        (
            "refined roads: IoU %; mean offset, m; mean error of the width, m",
            "80.69; not stated",
            listed(percent(roads["surface_iou"]), offset, width),
        ),
        (
            "refined roads: nodes; time",
            "17714; 37 minutes",
            listed(result["nodes"], f"{fixed(seconds_of(result, 'refine'), 1)} s"),
        ),
    ]


def in_space(result):
    """Steps from the heights to the lap."""
    z, scene, lap = result["truth"]["heights"]["z_m"], result["scene"], result["lap"]
    roads, junctions = number(result, "network", "roads"), number(result, "network", "junctions")
    return [
        (
            "heights against the true road: mean, 95 %, m; s",
            "not stated",
            listed(f"{fixed(z['mean_abs'])}, {fixed(z['p95'])}", fixed(seconds_of(result, "elevate"), 1)),
        ),
        (
            "network: roads; junctions; km; s",
            "without junctions and lanes",
            listed(
                roads,
                junctions,
                fixed(number(result, "network", "length_m") / 1000, 1),
                fixed(seconds_of(result, "network"), 1),
            ),
        ),
        (
            "scene: tiles of 480 m; triangles; MB a km2",
            "not stated",
            listed(scene["tiles_of_level_0"], f"{scene['triangles']:,}", fixed(scene["mb_per_km2"], 1)),
        ),
        (
            "scene: s a km2",
            "up to 40 for textures, less than 20 for the rest",
            f"{fixed(seconds_of(result, 'scene') / scene['ground_km2'], 1)} for all",
        ),
        (
            "lap: m along the track's middle; m driven; s of a sports car",
            f"not stated ({OFFICIAL_LAP_M} by the operator of the track); figure 4.4",
            listed(*(fixed(lap[key], 0) for key in ("track_m", "driven_m")), fixed(lap["seconds"], 1)),
        ),
        (
            "evaluations of the road a second, while the car drives",
            "at least 1000 a tyre",
            fixed(number(result, "drive", "tyre_queries_per_s"), 0),
        ),
        ("build: s; GB of memory", "not stated", listed(fixed(result["build_seconds"], 0), fixed(result["peak_gb"]))),
    ]


def steps(result):
    return header(["step", "thesis", "ours"]) + "".join(row(cells) for cells in on_the_map(result) + in_space(result))


def stages_table(result):
    on = result["machine"]
    text = f"{on['cores']} cores ({on['cpu']}), {on['memory_gb']} GB; load of the last quarter of an hour: "
    text += f"{result['load']}.\n\n"
    return (
        text
        + header(["stage", "seconds", "peak MB"])
        + "".join(row([name, fixed(s["seconds"], 1), s["peak_mb"]]) for name, s in result["stages"].items())
    )


def published_rows():
    """Number, published, ours, for docs/reference.md."""
    r = read_results(STORE, None)
    scene_s = seconds_of(r, "scene") / r["scene"]["ground_km2"] if r else None
    return [
        ("area, km2", "20", fixed(r["scene"]["ground_km2"], 1) if r else None),
        ("IoU of the roads, %", "80.69", percent(r["truth"]["roads"]["surface_iou"], 2) if r else None),
        ("textures and meshes, s a km2", "40 and less than 20", fixed(scene_s, 1) if r else None),
        (
            "a lap of a sports car, m; s",
            "figure 4.4: no number in the text",
            f"{fixed(r['lap']['track_m'], 0)}; {fixed(r['lap']['seconds'], 1)}" if r else None,
        ),
    ]


def run(args):
    if not args.table:
        args.out.mkdir(parents=True, exist_ok=True)
        write_results(STORE, measure(Tool(args.tool), args.out))
    write_page(
        PAGE, [STORE], {"steps": steps(read_results(STORE, {})), "stages": stages_table(read_results(STORE, {}))}
    )

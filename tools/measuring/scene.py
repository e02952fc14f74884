# SPDX-License-Identifier: Apache-2.0
"""The scene stage on built sites: time, memory, size, and what `evaluate scene` finds. Writes docs/measured/scene.md.

Give sites as NAME=SITE_TOML=OUT, OUT the folder that `orthodrive build SITE_TOML` wrote, for example
  --sites village=village/site.toml=village/out
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib

from measuring.common import (
    PAGES,
    Tool,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "scene.json", PAGES / "scene.md"
STORES = [STORE, "scene_parts.json"]  # of the page: tools/measure scene-parts writes the other part


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument(
        "--sites", nargs="+", default=[], metavar="NAME=SITE=OUT", help="built sites; the others keep their last values"
    )


def scene_options(site_file, out):
    """What a build gives the scene stage."""
    site = tomllib.loads(site_file.read_text())
    sources = site["sources"]

    def listed(value):
        return [value] if isinstance(value, str) else list(value)

    maps = listed(sources["osm"])
    options = [
        "--network",
        out / "roads.xodr",
        "--labels",
        out / "labels.tif",
        "--photo",
        site_file.parent / sources["photo"],
    ]
    for name, key in [("dtm", "dtm"), ("buildings", "buildings"), ("trees", "trees"), ("surroundings", "surroundings")]:
        for file in listed(sources.get(key, maps)):
            options += [f"--{name}", site_file.parent / file]
    return options


def run_measured(*words):
    """Seconds on the clock, seconds of processors, largest resident memory in MB of one run."""
    start = time.monotonic()
    process = subprocess.Popen(list(map(str, words)), stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{words[0]}: exit status {os.waitstatus_to_exitcode(status)}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000


def measure(tool, site_file, out):
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        seconds, processor, memory_mb = run_measured(
            tool.file, "--quiet", "scene", *scene_options(site_file, out), "-o", folder / "scene"
        )
        photo = site_file.parent / tomllib.loads(site_file.read_text())["sources"]["photo"]
        scores = tool.json("evaluate", "scene", folder / "scene", out / "roads.xodr", "--photo", photo, "--json")

        def files(pattern):
            return sum(f.stat().st_size for f in (folder / "scene").glob(pattern))

        return {
            "commit": commit(),
            "machine": machine(),
            "seconds": round(seconds, 1),
            "processor_s": round(processor, 1),
            "memory_mb": round(memory_mb),
            "material_bytes": files("materials/*"),
            "scores": scores,
        }
    finally:
        shutil.rmtree(folder)


def table(numbers):
    def rows():
        def per_km2(n, value):
            return value / n["scores"]["ground_km2"]

        yield (
            "ground, km2; tiles; levels",
            "",
            lambda n: f"{fixed(n['scores']['ground_km2'])}; {n['scores']['tiles']}; {n['scores']['levels']}",
        )
        yield "time, s/km2", "2.5", lambda n: fixed(per_km2(n, n["seconds"]))
        yield "time of processors, s/km2", "", lambda n: fixed(per_km2(n, n["processor_s"]))
        yield "memory, MB", "1500", lambda n: n["memory_mb"]
        yield "tiles, MB/km2", "6", lambda n: fixed(n["scores"]["mb_per_km2"])
        yield "pictures of materials, MB in all", "", lambda n: fixed(n["material_bytes"] / 1e6)
        yield (
            "triangles and draw calls of level 0",
            "",
            lambda n: f"{n['scores']['triangles']:,}; {n['scores']['draw_calls']:,}",
        )
        yield (
            "place of the photo, largest error, texels; windows",
            "0.1",
            lambda n: (
                f"{fixed(n['scores']['texture']['error_px'], 3)}; {n['scores']['texture']['windows']:,}"
                if "texture" in n["scores"]
                else ""
            ),
        )
        yield "open edges", "0", lambda n: n["scores"]["open_edges"]
        yield "edges of more than two triangles", "0", lambda n: n["scores"]["crowded_edges"]
        yield "road mesh from the surface, largest, m", "0.02", lambda n: fixed(n["scores"]["road_error_m"], 3)
        yield (
            "places of it over 2 cm, of all",
            "0",
            lambda n: f"{n['scores']['road_samples_off']:,} of {n['scores']['road_samples']:,}",
        )
        yield (
            "normals at tile borders, largest difference, degrees",
            "0.1",
            lambda n: fixed(n["scores"]["normal_error_deg"], 3),
        )
        yield (
            "vertices on a road, of those that stand",
            "0",
            lambda n: f"{n['scores']['on_road']:,} of {n['scores']['standing_vertices']:,}",
        )
        yield (
            "vertices of trees, barriers, lamps and objects in buildings",
            "0",
            lambda n: n["scores"].get("in_building", ""),
        )

    return header(["", "asked", *numbers]) + "".join(
        row([name, asked, *(value(n) for n in numbers.values())]) for name, asked, value in rows()
    )


def faults_table(numbers):
    """The first three of every kind of every site."""
    text = header(["site", "fault", "what", "x, y"])
    for name, n in numbers.items():
        shown = {}
        for fault in n["scores"]["faults"]:
            shown[fault["code"]] = shown.get(fault["code"], 0) + 1
            if shown[fault["code"]] <= 3:
                text += row(
                    [
                        name,
                        fault["code"].removeprefix("scene."),
                        fault["message"],
                        f"{fixed(fault['x'], 1)}, {fixed(fault['y'], 1)}",
                    ]
                )
    return text


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for triple in args.sites:
            name, site_file, out = triple.split("=")
            numbers[name] = measure(Tool(args.tool), pathlib.Path(site_file).resolve(), pathlib.Path(out).resolve())
            write_results(STORE, numbers)
    write_page(PAGE, STORES, {"scene": table(numbers), "faults": faults_table(numbers)})

# SPDX-License-Identifier: Apache-2.0
"""Where the scene stage's time goes, by perf: samples of the processor whose call stack holds a function of a part.

    tools/measure scene-parts --sites village=village/site.toml=village/out

Wants Debian's linux-perf. Writes the table of parts in docs/measured/scene.md. Seconds are those of both processors; on
the clock a stage that keeps two busy takes half.
"""

import pathlib
import shutil
import subprocess
import tempfile

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
    run_program,
    write_page,
    write_results,
)
from measuring.scene import STORES, scene_options

STORE, PAGE = "scene_parts.json", PAGES / "scene.md"

# In this order: the first part that has a function on the stack counts it.
PARTS = {
    "textures: photo read and warped, tiles' pictures, JPEG": [
        "tile_texture",
        "tile_labels",
        "find_shadows",
        "without_shadows",
        "PhotoWindow",
        "WarpedPhoto",
        "encode_jpeg",
        "encode_png",
        "half_size",
    ],
    "coarse levels": ["make_coarse_tile", "coarse_tile", "coarse_ground", "TileLevels::finish"],
    "files: compression, JSON": ["write_tile_glb", "write_tileset", "write_material", "make_surface_texture"],
    "meshes: ground, roads, decks": [
        "add_ground",
        "add_level",
        "triangulate",
        "add_road_materials",
        "name_roads",
        "drape",
        "add_verge",
        "add_kerbs",
    ],
    "surroundings": [
        "place_buildings",
        "building_mesh",
        "plant_trees",
        "find_crowns",
        "footprints_of_labels",
        "add_surroundings",
        "tree_instances",
        "object_faces",
        "barrier_faces",
        "track_faces",
        "place_lamps",
        "place_covers",
        "cover_meshes",
    ],
    "layout: road surface, noding, terrain": ["lay_roads", "SceneLayout", "lay_out_block", "SceneFrame"],
}
OTHER = "rest: reading roads and maps"


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument(
        "--sites", nargs="+", default=[], metavar="NAME=SITE=OUT", help="built sites; the others keep their last values"
    )


def part_of(stack):
    for part, names in PARTS.items():
        if any(name in stack for name in names):
            return part
    return OTHER


def measure(tool, site_file, out):
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        rate_hz = 49
        run_program(
            "perf",
            "record",
            "-q",
            "-e",
            "cpu-clock",
            "-F",
            rate_hz,
            "--call-graph",
            "dwarf,32768",
            "-o",
            folder / "perf.data",
            "--",
            tool.file,
            "--quiet",
            "scene",
            *scene_options(site_file, out),
            "-o",
            folder / "scene",
        )
        ground_km2 = tool.json("evaluate", "scene", folder / "scene", out / "roads.xodr", "--json")["ground_km2"]
        text = run_program(
            "perf", "script", "-i", folder / "perf.data", "-F", "ip,sym", "--no-inline", stderr=subprocess.DEVNULL
        )
        samples = dict.fromkeys([*PARTS, OTHER], 0)
        for stack in text.split("\n\n"):
            if stack.strip():
                samples[part_of(stack)] += 1
        return {
            "commit": commit(),
            "machine": machine(),
            "ground_km2": ground_km2,
            "processor_s": {k: round(v / rate_hz, 2) for k, v in samples.items()},
        }
    finally:
        shutil.rmtree(folder)


def table(numbers):
    text = header(["processors, s/km2", *numbers])
    for part in [*PARTS, OTHER]:
        text += row([part, *(fixed(n["processor_s"][part] / n["ground_km2"]) for n in numbers.values())])
    text += row(["all", *(fixed(sum(n["processor_s"].values()) / n["ground_km2"]) for n in numbers.values())])
    return text


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        for triple in args.sites:
            name, site_file, out = triple.split("=")
            numbers[name] = measure(Tool(args.tool), pathlib.Path(site_file).resolve(), pathlib.Path(out).resolve())
            write_results(STORE, numbers)
    write_page(PAGE, STORES, {"parts": table(numbers)})

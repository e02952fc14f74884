#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Blender imports what `orthodrive export` writes of a built site: the same objects, triangles, places and pictures.

Usage: blender_test.py TOOL SITE_FOLDER BUILT_FOLDER OUT_FOLDER. Exit code 77: there is no Blender.
"""

import collections
import io
import json
import math
import os
import shutil
import struct
import subprocess
import sys
from pathlib import Path

import numpy
from PIL import Image

Image.MAX_IMAGE_PIXELS = None
COMPONENT_BYTES = {5121: 1, 5123: 2, 5125: 4, 5126: 4}


def read_glb(path):
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def matrix_of(node):
    """translation * rotation * scale, 4 x 4."""
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    matrix = numpy.eye(4)
    matrix[:3, :3] = turn * numpy.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def positions_of(gltf, binary, accessor):
    entry = gltf["accessors"][accessor]
    view = gltf["bufferViews"][entry["bufferView"]]
    assert entry["componentType"] == 5126 and view.get("byteStride", 12) == 12
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    return numpy.frombuffer(binary, "<f4", 3 * entry["count"], start).reshape(-1, 3).astype(float)


def expected_of(path):
    """What Blender should have: counts by the nodes' names, bounds with z up, sizes of pictures."""
    gltf, binary = read_glb(path)
    objects, triangles, lows, highs, materials = collections.Counter(), collections.Counter(), [], [], set()

    def visit(index, parent):
        node = gltf["nodes"][index]
        world = parent @ matrix_of(node)
        objects[node["name"]] += 1
        if "mesh" in node:
            for part in gltf["meshes"][node["mesh"]]["primitives"]:
                triangles[node["name"]] += gltf["accessors"][part["indices"]]["count"] // 3
                materials.add(part["material"])
                at = positions_of(gltf, binary, part["attributes"]["POSITION"]) @ world[:3, :3].T + world[:3, 3]
                lows.append(at.min(axis=0))
                highs.append(at.max(axis=0))
        for child in node.get("children", []):
            visit(child, world)

    for root in gltf["scenes"][0]["nodes"]:
        visit(root, numpy.eye(4))
    pictures = []
    for image in gltf["images"]:
        view = gltf["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        pictures.append(list(Image.open(io.BytesIO(binary[start : start + view["byteLength"]])).size))
    (x0, y0, z0), (x1, y1, z1) = numpy.min(lows, axis=0), numpy.max(highs, axis=0)
    return {
        "objects": objects,
        "triangles": triangles,
        "pictures": sorted(pictures),
        "materials": len(materials),
        "low": [x0, -z1, y0],
        "high": [x1, -z0, y1],
    }


def differences(expected, found):
    lines = [
        f"{name}: the file has {expected[name]}, Blender {found[name]}"
        for name in ("objects", "triangles", "pictures", "materials")
        if expected[name] != found[name]
    ]
    for name in ("low", "high"):
        if not all(math.isclose(a, b, abs_tol=1e-3) for a, b in zip(expected[name], found[name], strict=True)):
            lines.append(f"{name} corner: the file has {expected[name]}, Blender {found[name]}")
    return lines


def ask_blender(glb, out):
    script = Path(__file__).with_name("blender_import.py")
    run = subprocess.run(
        [
            "blender",
            "-b",
            "--factory-startup",
            "-noaudio",
            "--python-exit-code",
            "1",
            "--python",
            script,
            "--",
            glb,
            out,
        ],
        capture_output=True,
        text=True,
        env={**os.environ, "HOME": str(out.parent)},
        check=False,
    )
    if run.returncode != 0:
        sys.exit(f"Blender failed:\n{run.stdout[-3000:]}\n{run.stderr[-3000:]}")
    return json.loads(out.read_text())


def without_a_triangle(path, out):
    """The same file, but one mesh has a triangle less."""
    gltf, _ = read_glb(path)
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    mesh = next(node["mesh"] for node in gltf["nodes"] if "mesh" in node)
    gltf["accessors"][gltf["meshes"][mesh]["primitives"][0]["indices"]]["count"] -= 3
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    out.write_bytes(
        struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
        + struct.pack("<I4s", len(text), b"JSON")
        + text
        + rest
    )


def main():
    tool, sources, built, out = sys.argv[1], *map(Path, sys.argv[2:5])
    if not shutil.which("blender"):
        print("SKIPPED, NOT TESTED: there is no Blender; run tools/setup --peers", file=sys.stderr)
        sys.exit(77)
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    glb = out / "area.glb"
    subprocess.run(
        [
            tool,
            "export",
            "--network",
            built / "roads.xodr",
            "--labels",
            built / "labels.tif",
            "--photo",
            sources / "ortho.tif",
            "--dtm",
            sources / "dtm_1m.tif",
            "--buildings",
            sources / "roads.osm",
            "--trees",
            sources / "roads.osm",
            "--surroundings",
            sources / "roads.osm",
            "--glb",
            glb,
        ],
        check=True,
    )
    expected, found = expected_of(glb), ask_blender(glb, out / "blender.json")
    print(
        f"Blender has {sum(found['objects'].values())} objects, {sum(found['triangles'].values())} triangles, "
        f"{len(found['pictures'])} pictures: {found['objects']}"
    )
    problems = differences(expected, found)
    # The test can fail.
    broken = out / "broken.glb"
    without_a_triangle(glb, broken)
    if not differences(expected, ask_blender(broken, out / "broken.json")):
        problems.append("a missing triangle is not seen")
    sys.exit("\n".join(problems) or 0)


main()

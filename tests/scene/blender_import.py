# SPDX-License-Identifier: Apache-2.0
"""Inside Blender: imports a glTF file and writes what has come of it as JSON.

blender -b --factory-startup --python blender_import.py -- FILE.glb OUT.json
"""

import collections
import json
import sys

import bpy
import numpy

numpy.bool = bool  # Debian 12's importer asks for this name, which Debian 12's numpy has no more


def kind_of(name):
    """Blender keeps names apart by numbers: tree, tree.001."""
    return name.rsplit(".", 1)[0] if name.rsplit(".", 1)[-1].isdigit() else name


def corners_of(thing):
    """Vertices in the world, n x 3."""
    flat = numpy.empty(3 * len(thing.data.vertices))
    thing.data.vertices.foreach_get("co", flat)
    world = numpy.array(thing.matrix_world)
    return flat.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]


def main():
    glb, out = sys.argv[sys.argv.index("--") + 1 :]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=glb, merge_vertices=False)
    objects, triangles, lows, highs, used = collections.Counter(), collections.Counter(), [], [], set()
    for thing in bpy.data.objects:
        kind = kind_of(thing.name)
        objects[kind] += 1
        if thing.type != "MESH":
            continue
        triangles[kind] += sum(len(face.vertices) - 2 for face in thing.data.polygons)
        corners = corners_of(thing)
        lows.append(corners.min(axis=0))
        highs.append(corners.max(axis=0))
        used.update(slot.material.name for slot in thing.material_slots)
    pictures = [list(image.size) for image in bpy.data.images if image.type == "IMAGE"]
    result = {
        "objects": objects,
        "triangles": triangles,
        "pictures": sorted(pictures),
        "materials": len(used),
        "low": numpy.min(lows, axis=0).tolist(),
        "high": numpy.max(highs, axis=0).tolist(),
    }
    with open(out, "w") as file:
        json.dump(result, file)


main()

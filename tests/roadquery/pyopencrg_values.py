#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Heights and slopes of one OpenCRG file under every option and modifier that changes them, by a real peer: PyOpenCRG
0.2.2.

    pip install numpy PyOpenCRG==0.2.2 tests/roadquery/pyopencrg_values.py
    ../shared/data/opencrg/handmade_curved_banked_sloped.crg > tests/roadquery/pyopencrg_values.txt

Missing values are filled as OpenCRG's default modifier says where a file sets none.
"""

import pathlib
import sys
import tempfile
import warnings

import pyopencrg

CASES = [
    ("plain", ""),
    ("repeat_reflect", "$ROAD_CRG_OPTS\nBORDER_MODE_U = 3\nBORDER_MODE_V = 4\n"),
    ("reflect_repeat", "$ROAD_CRG_OPTS\nBORDER_MODE_U = 4\nBORDER_MODE_V = 3\n"),
    (
        "zero_with_offsets",
        "$ROAD_CRG_OPTS\nBORDER_MODE_U = 1\nBORDER_MODE_V = 1\nBORDER_OFFSET_U = 0.5\nBORDER_OFFSET_V = 0.25\n",
    ),
    ("keep_with_offsets", "$ROAD_CRG_OPTS\nBORDER_OFFSET_U = 0.5\nBORDER_OFFSET_V = 0.25\n"),
    ("none", "$ROAD_CRG_OPTS\nBORDER_MODE_U = 0\nBORDER_MODE_V = 0\n"),
    ("smooth", "$ROAD_CRG_OPTS\nBORDER_SMOOTH_UBEG = 5.0\nBORDER_SMOOTH_UEND = 4.0\n"),
    (
        "scales",
        (
            "$ROAD_CRG_MODS\nSCALE_Z_GRID = 2.0\nSCALE_SLOPE = 0.5\nSCALE_BANKING = 3.0\nSCALE_LENGTH = 1.5\n"
            "SCALE_WIDTH = 2.0\nSCALE_CURVATURE = 0.5\nGRID_NAN_MODE = 2\n"
        ),
    ),
    (
        "reference_point",
        (
            "$ROAD_CRG_MODS\nGRID_NAN_MODE = 2\nREFPOINT_U_FRACTION = 0.4\nREFPOINT_V = 0.5\n"
            "REFPOINT_V_OFFSET = 0.25\nREFPOINT_X = 100.0\nREFPOINT_Y = 200.0\nREFPOINT_Z = 10.0\nREFPOINT_PHI = 1.0\n"
        ),
    ),
    (
        "offsets",
        (
            "$ROAD_CRG_MODS\nGRID_NAN_MODE = 2\nREFLINE_ROTCENTER_X = 3.0\nREFLINE_ROTCENTER_Y = -2.0\n"
            "REFLINE_OFFSET_PHI = 0.75\nREFLINE_OFFSET_X = 50.0\nREFLINE_OFFSET_Y = -20.0\nREFLINE_OFFSET_Z = 1.5\n"
        ),
    ),
    ("missing_to_value", "$ROAD_CRG_MODS\nGRID_NAN_MODE = 1\nGRID_NAN_OFFSET = 0.125\n"),
    ("missing_keeps_last_with_offset", "$ROAD_CRG_MODS\nGRID_NAN_MODE = 2\nGRID_NAN_OFFSET = 0.125\n"),
]
UV = [
    (3.3, 0.4),
    (11.4, -1.3),
    (17.9, 1.3),
    (-1.5, 0.2),
    (23.5, -1.0),
    (5.1, 2.5),
    (8.2, -3.25),
    (-30.25, 4.1),
    (50.5, -7.3),
    (1.25, 0.9),
    (20.75, -0.7),
    (36.3, 2.2),
]
PLACES = [(2.6, 0.3), (9.2, -1.1), (15.3, 1.2), (-2.0, 0.5), (24.5, -0.75)]


def main(source):
    original = pathlib.Path(source).read_bytes().decode("latin1")
    print(
        f"# Heights and slopes of {pathlib.Path(source).name} as PyOpenCRG 0.2.2 has them; written by "
        "pyopencrg_values.py."
    )
    print("# case NAME, the lines to put before $KD_Definition, then")
    print("# uv  u v z dz/du dz/dv")
    print("# xy  x y z dz/dx dz/dy")
    warnings.simplefilter("ignore")
    for name, block in CASES:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "case.crg"
            path.write_bytes(original.replace("$KD_Definition", block + "$KD_Definition", 1).encode("latin1"))
            road = pyopencrg.read(str(path))
        road = road.apply_mods() if "MODS" in block else road.fill_nan(2, 0.0)
        print(f"case {name}\n{block}", end="")
        for u, v in UV:
            print("uv", u, v, *(float(value) for value in (road.uv_to_z(u, v), *road.uv_to_gradient(u, v))))
        for u, v in PLACES:
            x, y = (round(float(value), 3) for value in road.uv_to_xy(u, v))
            z, nx, ny, nz = road.evaluator().xy_to_z(x, y, with_normal=True)
            print("xy", *(float(value) for value in (x, y, z, -nx / nz, -ny / nz)))


if __name__ == "__main__":
    main(sys.argv[1])

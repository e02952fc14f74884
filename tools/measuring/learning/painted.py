# SPDX-License-Identifier: Apache-2.0
"""Renders images and labels of the painted pieces into out/painted, for experiments with [[images]]."""

from measuring.common import DATA, ROOT, run_program

PHOTOS = {"estonia": "segmentation/estonia/images", "banepa": "segmentation/nepal_banepa"}


def render_painted():
    """Where they are not there yet."""
    for name, photos in PHOTOS.items():
        out = ROOT / "out/painted" / name
        if not (out / "labels").exists():
            run_program(
                ROOT / "tools/paint",
                "render",
                ROOT / f"models/training/painted_{name}.geojson",
                DATA / photos,
                "-o",
                out,
            )


def add_arguments(parser):
    del parser


def run(args):
    del args
    render_painted()

# SPDX-License-Identifier: Apache-2.0
"""Segmentation: speed, memory, windows against the whole, road IoU. Writes a table of docs/measured/segment.md.

A quarter of an hour on two idle cores; parts that are not named keep their last values from
bench/results/segmentation_numbers.json. Needs ../shared/data and a release build with benchmarks; makes the synthetic
site. The comparison of networks is a note, because it needs trainings: `tools/measure networks`.
"""

import os
import pathlib
import sys
import tempfile
import time

from measuring.common import (
    DATA,
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "segmentation_numbers.json", PAGES / "segment.md"
PARTS = ["mosaic", "windows", "labels"]
VARIANTS = (("network", []), ("crf", ["--crf"]))


def add_arguments(parser):
    add_tool(parser)
    add_only(parser, PARTS)
    add_table(parser)


def timed(tool, *words):
    """Seconds and peak memory in GB of one run of the tool."""
    start = time.monotonic()
    pid = os.posix_spawn(tool.file, [str(tool.file), "-q", *map(str, words)], os.environ)
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        sys.exit(f"failed: {words}")
    return time.monotonic() - start, usage.ru_maxrss * 1024 / 1e9


def differing(tool, a, b):
    return 1.0 - tool.json("evaluate", "labels", a, b, "--json")["pixel_accuracy"]


def pixels(tool, labels):
    scores = tool.json("evaluate", "labels", labels, labels, "--json")
    return scores["confusion"] and sum(map(sum, scores["confusion"]["pixels_by_truth"]))


def measure(tool, parts, work, keep):
    if "mosaic" in parts:
        for name, more in VARIANTS:
            labels = work / f"pardubice_{name}.tif"
            seconds, memory = timed(
                tool,
                "segment",
                DATA / "pardubice/ortho.tif",
                "-o",
                labels,
                "--confidence",
                work / "confidence.tif",
                *more,
            )
            keep(f"mosaic_{name}", {"megapixels": pixels(tool, labels) / 1e6, "seconds": seconds, "peak_gb": memory})
    if "windows" in parts:
        photo = DATA / "kvarnbyn/ortho.jpg"
        for name, more in VARIANTS:
            whole = work / f"whole_{name}.tif"
            tool("segment", photo, "-o", whole, "--window", 8000, "--threads", 1, *more)
            for window in (512, 1024):
                part = work / f"part_{name}_{window}.tif"
                tool("segment", photo, "-o", part, "--window", window, *more)
                keep(f"window_{name}_{window}", differing(tool, part, whole))
    if "labels" in parts:
        site = tool.synth(ROOT / "out/synth/village-99", "--preset", "village", "--seed", 99)
        for name, more in VARIANTS:
            labels = work / f"village_{name}.tif"
            tool("segment", site / "ortho.tif", "-o", labels, *more)
            keep(
                f"village_road_iou_{name}",
                tool.json("evaluate", "labels", labels, site / "truth/labels.tif", "--json")["road_iou"],
            )
            keep(
                f"handmade_road_iou_{name}",
                tool.json("train", ROOT / "models/default.toml", "--measure", "default", *more)["handmade"]["road_iou"],
            )


def table(n):
    def mosaic(name):
        m = n[f"mosaic_{name}"]
        return (
            f"{m['megapixels'] / m['seconds']:.2f} Mpx/s, {m['peak_gb']:.2f} GB ({m['megapixels']:.0f} Mpx of "
            "Pardubice, reading and writing included)"
        )

    def each(keys, show):
        return ", ".join(show(n[k]) if k in n else "not measured" for k in keys)

    def of_both(name):
        return each((f"{name}_network", f"{name}_crf"), lambda v: f"{v:.3f}") + " (without, with CRF)"

    return "| asked | reached |\n|---|---|\n" + "".join(
        row(cells)
        for cells in [
            ("whole mosaic without CRF >= 2.5 Mpx/s, <= 2 GB", mosaic("network")),
            ("the same with CRF", mosaic("crf")),
            (
                "windows 512, 1024 against whole image: <= 1 label in 100,000 differs",
                each(("window_network_512", "window_network_1024"), lambda v: f"{1e5 * v:.2f}"),
            ),
            (
                "windows 512, 1024 with CRF: <= 0.1 % differ",
                each(("window_crf_512", "window_crf_1024"), lambda v: f"{100 * v:.4f} %"),
            ),
            ("village of an unseen seed, 0.2 m/px: road IoU >= 0.90", of_both("village_road_iou")),
            ("hand-made test set: road IoU >= 0.75", of_both("handmade_road_iou")),
        ]
    )


def run(args):
    numbers = read_results(STORE, {})

    def keep(key, value):
        numbers[key] = value
        numbers.setdefault("commits", {})[key] = commit()
        write_results(STORE, numbers)
        print(key, value, flush=True)

    if not args.table:
        with tempfile.TemporaryDirectory() as work:
            measure(Tool(args.tool), args.only, pathlib.Path(work), keep)
    write_page(PAGE, [STORE], {"numbers": table(numbers)})

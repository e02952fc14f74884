# SPDX-License-Identifier: Apache-2.0
"""The dense CRF: megapixels a second, and how exact it is. Writes docs/measured/dense_crf.md.

Runs bench_crf on a piece of Kvarnbyn's photo (two windows of 1024 x 1024 px on two threads) and the tests that compare
with exact sums; a minute. Needs gdal-bin and ../shared/data.
"""

import json
import os
import pathlib
import re
import tempfile

from measuring.common import (
    DATA,
    PAGES,
    ROOT,
    add_table,
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

STORE, PAGE = "dense_crf.json", PAGES / "dense_crf.md"
BUILD = ROOT / "build/release"
WIDTHS = ["13.5, 11, 1.75", "80, 13, 3"]
COMPARED = r"^(?:theta|window against|.*relative error).*$"  # what tests/crf prints of a comparison


def add_arguments(parser):
    add_table(parser)
    parser.add_argument(
        "--bench", type=pathlib.Path, default=BUILD / "bench/speed/bench_crf", help="the built benchmark"
    )
    parser.add_argument("--test", type=pathlib.Path, default=BUILD / "tests/crf/test_crf", help="the built test")


def measure(args):
    with tempfile.TemporaryDirectory() as folder:
        photo = pathlib.Path(folder) / "photo.ppm"
        run_program(
            "gdal_translate",
            "-q",
            "-of",
            "PNM",
            "-b",
            1,
            "-b",
            2,
            "-b",
            3,
            "-srcwin",
            0,
            0,
            2048,
            1024,
            DATA / "kvarnbyn/ortho.jpg",
            photo,
        )
        bench = json.loads(
            run_program(args.bench, "--benchmark_format=json", env={**os.environ, "ORTHODRIVE_BENCH_PPM": str(photo)})
        )
    return {
        "commit": commit(),
        "machine": machine(),
        "bench": {b["name"]: {k: v for k, v in b.items() if isinstance(v, float)} for b in bench["benchmarks"]},
        "lines": re.findall(COMPARED, run_program(args.test, "--gtest_filter=*DenseCrf*:*Crf*"), re.MULTILINE),
    }


def table(n):
    def of(classes, widths):
        return n["bench"][f"dense_crf/two_windows/classes:{classes}/widths:{widths}/real_time"]

    def speed(classes, widths):
        return f"{fixed(of(classes, widths)['items_per_second'] / 1e6)} Mpx/s"

    text = header(["theta alpha, beta, gamma", "vertices a px", "8 classes", "38 classes"])
    text += "".join(
        row([name, fixed(of(8, i)["vertices_per_px"]), speed(8, i), speed(38, i)]) for i, name in enumerate(WIDTHS)
    )
    text += "\nAsked with theta alpha 13.5: 2 and 0.6 Mpx/s.\n"
    return text + "".join(f"\n    {line}" for line in n.get("lines", [])) + "\n"


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        numbers = measure(args)
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"dense-crf": table(numbers)})

# SPDX-License-Identifier: Apache-2.0
"""Drive logs: simulated drives with exact truth, their roughness, the real minute. Writes docs/measured/drive_logs.md.

The drives and their truth are those of tests/elevate. Each test records what it measures as a property of its result
(`measured_1`, `measured_2`, ...); this command runs them, reads the properties from googletest's JSON report, keeps
them in bench/results/drive_logs.json and writes the page. The real minute needs ../shared/data/drives.
"""

import json
import pathlib
import sys
import tempfile

from measuring.common import (
    PAGES,
    RESULTS,
    ROOT,
    add_table,
    commit,
    machine,
    read_results,
    run_program,
    write_page,
    write_results,
)

STORE, PAGE = "drive_logs.json", PAGES / "drive_logs.md"
TITLES = {
    "FuseDriveLogs": "Simulated drives over a road that is known exactly",
    "MeasureRoughness": "Roughness of simulated drives",
    "RealDrive": "The real minute of comma2k19",
}


def add_arguments(parser):
    add_table(parser)
    parser.add_argument(
        "--tests",
        type=pathlib.Path,
        default=ROOT / "build/release/tests/elevate/test_elevate",
        help="the test program of elevate",
    )


def measure(program):
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        run_program(
            program,
            "--gtest_brief=1",
            "--gtest_filter=" + ":".join(f"{suite}.*" for suite in TITLES),
            f"--gtest_output=json:{report}",
        )
        suites = json.loads(report.read_text())["testsuites"]
    lines = {suite: [] for suite in TITLES}
    for suite in suites:
        for test in suite["testsuite"]:
            recorded = [
                (int(key.removeprefix("measured_")), value)
                for key, value in test.items()
                if key.startswith("measured_")
            ]
            lines[suite["name"]] += [value for _, value in sorted(recorded)]
    return {"commit": commit(), **machine(), "lines": lines}


def run(args):
    if args.table:
        numbers = read_results(STORE, None) or sys.exit(f"{RESULTS / STORE}: not measured yet")
    else:
        numbers = measure(args.tests)
        write_results(STORE, numbers)
    write_page(
        PAGE,
        [STORE],
        {
            "drive-logs": "\n"
            + "\n".join(
                f"{TITLES[suite]}:\n\n" + "".join(f"    {line}\n" for line in lines)
                for suite, lines in numbers["lines"].items()
                if lines
            )
        },
    )

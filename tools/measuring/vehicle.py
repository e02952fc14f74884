# SPDX-License-Identifier: Apache-2.0
"""The car: its checks against closed forms and its speed. Writes docs/measured/vehicle.md.

Runs test_vehicle and bench_vehicle of build/release (a minute). With --table nothing runs: the page is written from the
last results, bench/results/vehicle.json.
"""

import json
import pathlib
import re
import subprocess
import tempfile

from measuring import common

BUILD = common.ROOT / "build/release"


def add_arguments(parser):
    common.add_table(parser)
    parser.add_argument(
        "--test", type=pathlib.Path, default=BUILD / "tests/vehicle/test_vehicle", help="the built test"
    )
    parser.add_argument(
        "--bench", type=pathlib.Path, default=BUILD / "bench/speed/bench_vehicle", help="the built benchmark"
    )


def checks(test):
    """Rows [what, asked, reached] that the tests keep as properties (tests/vehicle/cars.hpp)."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        subprocess.run([test, f"--gtest_output=json:{report}"], check=True, stdout=subprocess.DEVNULL)
        suites = json.loads(report.read_text())["testsuites"]
    cases = [case for suite in suites for case in suite["testsuite"]]

    def keys(case):
        return sorted((k for k in case if re.fullmatch(r"measured_\d+", k)), key=lambda k: int(k.split("_")[1]))

    return [case[key].split(" | ") for case in cases for key in keys(case)]


def speeds(bench):
    """CPU time in ns: median of five runs, and the smallest."""
    out = subprocess.run(
        [bench, "--benchmark_format=json", "--benchmark_repetitions=5", "--benchmark_min_time=0.2"],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    ).stdout
    runs = json.loads(out)["benchmarks"]
    names = list(dict.fromkeys(r["run_name"] for r in runs))
    times = {
        n: sorted(r["cpu_time"] for r in runs if r["run_name"] == n and r["run_type"] == "iteration") for n in names
    }
    return {n: {"median_ns": round(t[len(t) // 2]), "least_ns": round(t[0])} for n, t in times.items()}


def page(results):
    text = "# Measured: the car\n\nMethod: [vehicle.md](../vehicle.md). Written by `tools/measure vehicle` from "
    text += "`bench/results/vehicle.json`.\n\n## Checks\n\n"
    text += "Asked: the closed form of the test in `tests/vehicle`, or what the line names first.\n\n"
    text += common.header(["check", "asked", "reached"]) + "".join(common.row(r) for r in results["checks"])
    text += "\nThe envelope leaves out what locking differentials, camber and the tilt of the car "
    text += "under downforce do to the tyres; that is the difference between planned and reached grip.\n"
    text += "\n## Speed\n\nSteps of 1 ms, CPU time, one core of " + results["machine"]["cpu"] + ". "
    text += "Asked: 300 times real time with four tyres on a road, 3.33 us a step.\n\n"
    text += common.header(["case", "median", "best of five", "times real time (median)"])
    for name, s in results["speeds"].items():
        factor = "-" if name.endswith("envelope") else str(round(1e6 / s["median_ns"]))
        text += common.row([name, f"{s['median_ns'] / 1000:.2f} us", f"{s['least_ns'] / 1000:.2f} us", factor])
    return text


def run(args):
    results = common.read_results("vehicle.json", {})
    if not args.table:
        results = {
            "commit": common.commit(),
            "machine": common.machine(),
            "checks": checks(args.test),
            "speeds": speeds(args.bench),
        }
        common.write_results("vehicle.json", results)
    common.write_page(common.PAGES / "vehicle.md", ["vehicle.json"], page(results))

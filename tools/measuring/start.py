# SPDX-License-Identifier: Apache-2.0
"""How long the tool takes to start, and how many libraries it loads. Writes docs/measured/start.md.

Each run is a process of its own; the files are in the system's cache after the first, which does not count.
"""

import os
import pathlib
import re
import statistics
import subprocess
import tempfile
import time

from measuring.common import (
    PAGES,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_between,
    write_results,
)

STORE, PAGE = "start.json", PAGES / "start.md"
RUNS = {
    "version": ["version"],
    "help of a command": ["build", "--help"],
    "wrong usage": ["segment"],
    "a command, up to its first file": ["plan", "/nowhere/site.toml"],
}


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)
    parser.add_argument("--runs", type=int, default=20, help="of each, the middle one counts (20)")


def milliseconds(words, runs):
    def one():
        begin = time.perf_counter()
        subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        return 1000 * (time.perf_counter() - begin)

    one()
    return [one() for _ in range(runs)]


def libraries(words):
    """All that the loader loads, at the start or later."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "LD_DEBUG": "files", "LD_DEBUG_OUTPUT": f"{folder}/log"}
        subprocess.run(words, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        return len(
            {
                name
                for log in pathlib.Path(folder).iterdir()
                for name in re.findall(r"calling init: (\S+)", log.read_text())
            }
        )


def measure(tool, runs):
    rows = {}
    for name, arguments in RUNS.items():
        words = [tool, *arguments]
        times = milliseconds(words, runs)
        rows[name] = {
            "median_ms": statistics.median(times),
            "fastest_ms": min(times),
            "slowest_ms": max(times),
            "libraries": libraries(words),
        }
    return {"commit": commit(), "machine": machine(), "load": round(os.getloadavg()[0], 1), "runs": runs, "rows": rows}


def table(n):
    asked = {"version": ("60", "80")}
    lines = header(
        ["what starts", "asked, ms", "median, ms", "fastest to slowest, ms", "asked, libraries", "libraries"]
    )
    for name, r in n["rows"].items():
        ms, count = asked.get(name, ("", ""))
        lines += row(
            [
                name,
                ms,
                fixed(r["median_ms"], 0),
                f"{fixed(r['fastest_ms'], 0)} to {fixed(r['slowest_ms'], 0)}",
                count,
                r["libraries"],
            ]
        )
    return (
        f"Commit {n['commit']}, {n['runs']} runs each, {n['machine']['cores']} cores, {n['machine']['cpu']}, load "
        f"{n['load']} at the start.\n\n"
    ) + lines


def run(args):
    numbers = read_results(STORE, None)
    if not args.table:
        numbers = measure(args.tool.resolve(), args.runs)
        write_results(STORE, numbers)
    write_between(PAGE, "start", table(numbers))

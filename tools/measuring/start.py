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

from measuring import common

STORE, PAGE = "start.json", common.PAGES / "start.md"
RUNS = {
    "version": ["version"],
    "help of a command": ["build", "--help"],
    "wrong usage": ["segment"],
    "a command, up to its first file": ["plan", "/nowhere/site.toml"],
}


def add_arguments(parser):
    common.add_tool(parser)
    common.add_table(parser)
    parser.add_argument("--runs", type=int, default=20, help="of each, the middle one counts (20)")


def milliseconds(words, runs):
    def one():
        begin = time.perf_counter()
        subprocess.run(words, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return 1000 * (time.perf_counter() - begin)

    one()
    return [one() for _ in range(runs)]


def libraries(words):
    """All that the loader loads, at the start or later."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "LD_DEBUG": "files", "LD_DEBUG_OUTPUT": f"{folder}/log"}
        subprocess.run(words, check=False, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        logs = "".join(log.read_text() for log in pathlib.Path(folder).iterdir())
        return len(set(re.findall(r"calling init: (\S+)", logs)))


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
    return {
        "commit": common.commit(),
        "machine": common.machine(),
        "load": round(os.getloadavg()[0], 1),
        "runs": runs,
        "rows": rows,
    }


def page(n):
    asked = {"version": ("60", "80")}
    lines = common.header(
        ["what starts", "asked, ms", "median, ms", "fastest to slowest, ms", "asked, libraries", "libraries"]
    )
    for name, r in n["rows"].items():
        ms, count = asked.get(name, ("", ""))
        span = f"{common.fixed(r['fastest_ms'], 0)} to {common.fixed(r['slowest_ms'], 0)}"
        lines += common.row([name, ms, common.fixed(r["median_ms"], 0), span, count, r["libraries"]])
    machine_text = f"{n['machine']['cores']} cores, {n['machine']['cpu']}, load {n['load']} at the start"
    return f"""# Measured: start of the tool

Method: [a library behind a launcher](../decisions/library_behind_a_launcher.md). Written by `tools/measure start`:
{n["runs"]} runs each, every one a process of its own, files in the system's cache; {machine_text}.

{lines}"""


def run(args):
    numbers = common.read_results(STORE, None)
    if not args.table:
        numbers = measure(args.tool.resolve(), args.runs)
        common.write_results(STORE, numbers)
    common.write_page(PAGE, [STORE], page(numbers))

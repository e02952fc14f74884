# SPDX-License-Identifier: Apache-2.0
"""What a newcomer waits for: the README's two commands, and CI, on a clean clone. Writes docs/measured/clone.md.

    tools/measure clone               tools/demo and tools/test on one clone, .ci/run on another
    tools/measure clone --only test   that alone; what is not named keeps its last numbers

Each clone is of the present commit, without a compiler cache and without ../shared (links lead there). System packages
that are installed already cost nothing here: on a bare machine setup takes some minutes more. Nothing else should run.
"""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time

from measuring import common

STORE, PAGE = "clone.json", common.PAGES / "clone.md"
ASKED_MIN = {"demo": 6, "test": 15, "ci": 35}
COMMANDS = {"demo": "tools/demo", "test": "tools/test", "ci": ".ci/run"}


def add_arguments(parser):
    common.add_table(parser)
    parser.add_argument("--only", choices=[*COMMANDS], action="append", help="one of them, behind those it needs")


def fresh_clone(folder):
    clone = folder / "orthodrive"
    subprocess.run(["git", "clone", "--quiet", common.ROOT, clone], check=True)
    (folder / "shared").symlink_to((common.ROOT / "../shared").resolve())
    return clone


def timed(clone, command):
    """Minutes and exit code. All it says lies beside the clone."""
    environment = {**os.environ, "CCACHE_DIR": str(clone.parent / "ccache")}
    log = clone.parent / (re.sub(r"\W", "_", command) + ".log")
    load, begin = os.getloadavg()[0], time.monotonic()
    with log.open("wb") as output:
        code = subprocess.run(
            [clone / command], cwd=clone, env=environment, stdout=output, stderr=subprocess.STDOUT, check=False
        ).returncode
    if code:
        shutil.copy(log, common.ROOT / "out")
    passed = re.findall(r"tests passed, (\d+) tests failed out of (\d+)", log.read_text(errors="replace"))
    return {
        "commit": common.commit(),
        "machine": common.machine(),
        "minutes": (time.monotonic() - begin) / 60,
        "exit_code": code,
        "load": round(load, 1),
        "tests": int(passed[-1][1]) if passed else None,
        "failed": int(passed[-1][0]) if passed else None,
    }


def measure(names, numbers):
    (common.ROOT / "out").mkdir(exist_ok=True)
    for group in (["demo", "test"], ["ci"]):
        wanted = [name for name in group if name in names]
        if not wanted:
            continue
        with tempfile.TemporaryDirectory(dir=common.ROOT / "out") as folder:
            clone = fresh_clone(pathlib.Path(folder))
            for name in group[: group.index(wanted[-1]) + 1]:
                numbers[name] = timed(clone, COMMANDS[name])
                common.write_results(STORE, numbers)
                print(name, numbers[name], flush=True)


def page(numbers):
    lines = common.header(["command", "asked, min", "minutes", "exit code", "tests", "failed", "load before"])
    for name, n in numbers.items():
        lines += common.row(
            [
                f"`{COMMANDS[name]}`",
                ASKED_MIN[name],
                common.fixed(n["minutes"], 1),
                n["exit_code"],
                "" if n["tests"] is None else n["tests"],
                "" if n["failed"] is None else n["failed"],
                n["load"],
            ]
        )
    machine = next(iter(numbers.values()), {"machine": common.machine()})["machine"]
    return f"""# Measured: a clean clone

Method: [testing.md](../testing.md). Written by `tools/measure clone`: a clone of the commit, nothing built, no compiler
cache, system packages installed; {machine["cores"]} cores, {machine["cpu"]}. `tools/test` runs behind `tools/demo`,
`.ci/run` on a clone of its own. `tests` are entries of ctest.

{lines}"""


def run(args):
    numbers = common.read_results(STORE, {})
    if not args.table:
        measure(args.only or [*COMMANDS], numbers)
    common.write_page(PAGE, [STORE], page({name: numbers[name] for name in COMMANDS if name in numbers}))

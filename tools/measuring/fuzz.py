# SPDX-License-Identifier: Apache-2.0
"""How often readers of foreign files were run by libFuzzer without a finding left. Writes docs/measured/fuzz.md.

Runs `tools/fuzz` and adds what ran to bench/results/fuzz.json. A finding takes the count of its reader back to nothing,
and so does --forget READER.
"""

import datetime
import os
import re
import subprocess

from measuring.common import (
    PAGES,
    ROOT,
    add_table,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "fuzz.json", PAGES / "fuzz.md"


def add_arguments(parser):
    add_table(parser)
    parser.add_argument("--only", nargs="+", metavar="READER", help="these readers; all of them otherwise")
    parser.add_argument("--seconds", type=int, default=1800, help="of each reader (1800)")
    parser.add_argument(
        "--forget", nargs="+", default=[], metavar="READER", help="readers whose counts begin anew; all: every one"
    )


def names():
    script = (ROOT / "tools/fuzz").read_text()
    return [
        name
        for group in ("own", "of_files")
        for name in re.search(rf"^{group}=\(([^)]*)\)", script, re.MULTILINE)[1].split()
    ]


def add_run(results, name):
    """From the log of the last run; a finding takes the count back to nothing."""
    log = (ROOT / "build/fuzz" / f"{name}.log").read_text(errors="replace")
    done, covered = re.search(r"^Done (\d+) runs in (\d+) second", log, re.MULTILINE), re.findall(r"\bcov: (\d+)", log)
    if not done:
        results.pop(name, None)
        print(f"{name}: a finding, see build/fuzz/{name}.log")
        return
    before = results.get(name, {"runs": 0, "seconds": 0})
    results[name] = {
        "runs": before["runs"] + int(done[1]),
        "seconds": before["seconds"] + int(done[2]),
        "edges": int(covered[-1]) if covered else 0,
        "last": datetime.date.today().isoformat(),
        "commit": commit(),
        **machine(),
    }


def add_runs(ran):
    results = read_results(STORE, {})  # anew: another process may run other readers
    for name in ran:
        add_run(results, name)
    write_results(STORE, results)


def run(args):
    if args.forget:
        write_results(
            STORE,
            {
                name: r
                for name, r in read_results(STORE, {}).items()
                if name not in args.forget and "all" not in args.forget
            },
        )
    if args.only and not args.table:
        for name in args.only:
            subprocess.run([str(ROOT / "tools/fuzz"), name, str(args.seconds)], cwd=ROOT, check=False)
            add_runs([name])
    elif not args.table:
        readers = names()
        cores = min(os.cpu_count(), len(readers))
        subprocess.run(
            [str(ROOT / "tools/fuzz"), "all", str(args.seconds * len(readers) // cores)], cwd=ROOT, check=False
        )
        add_runs(readers)
    results = read_results(STORE, {})
    table = header(["reader", "runs", "minutes", "branches seen", "ten million runs or 30 minutes"])
    for name in names():
        if name not in results:
            table += row([name, 0, 0, "", "no"])
            continue
        r = results[name]
        reached = r["runs"] >= 10_000_000 or r["seconds"] >= 1800
        table += row(
            [
                name,
                f"{r['runs']:,}".replace(",", " "),
                fixed(r["seconds"] / 60, 1),
                r["edges"],
                "yes" if reached else "no",
            ]
        )
    write_page(PAGE, [STORE], {"fuzz": table})

# SPDX-License-Identifier: Apache-2.0
"""Debian packages: sizes, and what a bare Debian 12 takes to use them. Writes docs/measured/packaging.md.

Runs `tools/package --test` and `tools/package --reproduce`: a quarter of an hour. Needs root, debootstrap and the net;
what cannot be done is said on the page.
"""

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

STORE, PAGE = "packaging.json", PAGES / "packaging.md"
PACKAGES = ROOT / "build/packages"


def add_arguments(parser):
    add_table(parser)


def said_by(lines):
    """What tests/package/inside says: a title, some spaces, a value."""
    return [list(found) for line in lines if len(found := re.split(r" {2,}", line.strip(), maxsplit=1)) == 2]


def measure():
    rows = []
    run = subprocess.run(
        [str(ROOT / "tools/package"), "--test"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    rows += [
        [file.name.split("_")[0], f"{fixed(file.stat().st_size / 1e6, 2)} MB"]
        for file in sorted(PACKAGES.glob("*.deb"))
    ]
    rows += said_by(run.stdout.splitlines())
    rows.append(["all of it in a bare Debian", "right" if run.returncode == 0 else run.stdout.strip().splitlines()[-1]])
    again = subprocess.run(
        [str(ROOT / "tools/package"), "--reproduce"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    rows.append(
        ["the same commit built in another folder", again.stdout.strip().splitlines()[-1].removeprefix("package: ")]
    )
    return {"commit": commit(), "machine": machine(), "load": round(os.getloadavg()[0], 1), "rows": rows}


def table(n):
    return (
        header(["number", "value"]) + "".join(map(row, n["rows"])) + "\nAsked: the village built in under a minute.\n"
    )


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        numbers = measure()
        write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"packaging": table(numbers)})

# SPDX-License-Identifier: Apache-2.0
"""What the sub-commands of tools/measure share: paths, running the tool, numbers as text, results, tables in pages."""

import decimal
import json
import math
import os
import pathlib
import re
import resource
import sqlite3
import struct
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DATA = ROOT.parent / "shared/data"
RESULTS = ROOT / "bench/results"
PAGES = ROOT / "docs/measured"
NOTES = ROOT / "docs/notes"
IMAGES = ROOT / "docs/images"


def add_tool(parser, out=None):
    """--tool (a copy may be given, so that building can go on) and the folder for what is made."""
    parser.add_argument(
        "--tool", type=pathlib.Path, default=ROOT / "build/release/orthodrive", help="the program that is measured"
    )
    if out:
        parser.add_argument("--out", type=pathlib.Path, default=ROOT / out, help=f"folder for what is made ({out})")


def add_only(parser, names):
    parser.add_argument(
        "--only",
        type=lambda text: text.split(","),
        default=list(names),
        metavar="NAME,...",
        help=f"of {','.join(names)}; the others keep their last values",
    )


def add_table(parser):
    parser.add_argument("--table", action="store_true", help="measure nothing: write the page from the last results")


def run_program(*words, **options):
    return subprocess.run(list(map(str, words)), check=True, stdout=subprocess.PIPE, text=True, **options).stdout


class Tool:
    """The built program."""

    def __init__(self, file):
        self.file = pathlib.Path(file).resolve()

    def __call__(self, *words):
        return run_program(self.file, "--quiet", *words)

    def json(self, *words):
        return json.loads(self(*words))

    def timed(self, *words):
        """Seconds of one run."""
        start = time.monotonic()
        self(*words)
        return time.monotonic() - start

    def synth(self, site, *options):
        """A synthetic site, made where it is not there yet."""
        if not (site / "truth").exists():
            self("synth", *options, "-o", site)
        return site


def commit():
    """Of the checkout; "unknown" for a tree without a history."""
    if not (ROOT / ".git").exists():
        return "unknown"

    def git(*words):
        return run_program("git", "-C", ROOT, *words).strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!bench/results", ":!docs")
    return git("rev-parse", "--short", "HEAD") + (" + changes" if changed else "")


def machine():
    cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return {"cores": os.cpu_count(), "cpu": cpu[1] if cpu else "unknown", "memory_gb": round(memory / 1e9)}


# ---- results and pages


def read_results(name, otherwise):
    file = RESULTS / name
    return json.loads(file.read_text()) if file.exists() else otherwise


def write_results(name, value):
    RESULTS.mkdir(parents=True, exist_ok=True)
    (RESULTS / name).write_text(json.dumps(value, indent=1, ensure_ascii=False) + "\n")


STAMP = re.compile(r"^Measured on commit (.+)\.$", re.MULTILINE)


def commits_of(value):
    """Every commit that results name, each once, in their order."""
    found = {}
    for key, part in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        if key == "commit":
            found[part] = None
        else:  # "commits" holds them by part
            found |= dict.fromkeys(part.values() if key == "commits" else commits_of(part))
    return list(found)


def stamped(text, stores):
    """A page with the commits of its results in lines of their own below its title: one, where all was measured in one
    run.
    """
    found = dict.fromkeys(c for store in stores for c in commits_of(read_results(store, {})))
    title, _, rest = STAMP.sub("", text).partition("\n")
    return (
        f"{title}\n\n" + "".join(f"Measured on commit {c}.\n" for c in found or ["unknown"]) + "\n" + rest.lstrip("\n")
    )


def write_page(page, stores, text):
    """`text` is the whole page, or by name what stands between <!-- measured: NAME --> and <!-- /measured --> of it;
    what stands outside the marks is the page's template.
    """
    if isinstance(text, dict):
        for name, part in text.items():
            write_between(page, name, part)
        text = page.read_text()
    page.write_text(stamped(text, stores))


def write_between(page, name, text):
    """Replaces the text between <!-- measured: NAME --> and <!-- /measured --> of a page."""
    begin, end = f"<!-- measured: {name} -->\n", "<!-- /measured -->"
    parts = page.read_text().split(begin)
    if len(parts) != 2 or end not in parts[1]:
        sys.exit(f"{page}: the marks {begin.strip()} ... {end} are missing")
    page.write_text(parts[0] + begin + text.rstrip("\n") + "\n" + end + parts[1].split(end, 1)[1])


def header(cells):
    return f"| {' | '.join(cells)} |\n|{'|'.join('---' for _ in cells)}|\n"


def row(cells):
    return f"| {' | '.join(map(str, cells))} |\n"


# ---- numbers as text


def fixed(value, digits=2, otherwise="-"):
    """With so many digits; halves away from zero."""
    if value is None or math.isnan(value):
        return otherwise
    if value == 0:
        value = 0.0
    step = decimal.Decimal(1).scaleb(-digits)
    return str(decimal.Decimal(value).quantize(step, decimal.ROUND_HALF_UP, decimal.Context(prec=40)))


def percent(share, digits=1):
    return "-" if share is None else fixed(100 * share, digits)


def exponential(value):
    return re.sub(r"e([+-])0", r"e\1", f"{value:.1e}")


# ---- roads.gpkg, without GDAL


def point_of(blob):
    """x, y of a GeoPackage point."""
    at = 8 + [0, 32, 48, 48, 64][(blob[3] >> 1) & 7] + 5
    return struct.unpack_from("<dd" if blob[3] & 1 else ">dd", blob, at)


def longest_way(file):
    return (
        sqlite3.connect(file)
        .execute("select osm_id from nodes where part = 0 group by osm_id order by max(s_m) desc, osm_id")
        .fetchone()[0]
    )


def children_seconds():
    """Processor time of the programs that were run so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime

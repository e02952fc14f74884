# SPDX-License-Identifier: Apache-2.0
"""Data of strangers in one table: what is asked of files of others, and what is reached. Runs the cases of
../shared/cases; the other numbers are those of the pages that it links. Writes docs/measured/strangers.md.
"""

import os
import re
import subprocess

from measuring import foreign_opendrive, foreign_osm
from measuring.common import (
    PAGES,
    ROOT,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "strangers.json", PAGES / "strangers.md"
CASES = ROOT.parent / "shared/cases"
CASE_S = 600  # of one case
COUNTRIES = ROOT / "docs/countries.md"
COUNTRIES_ASKED = 28 + 4  # of Europe; USA, Canada, Japan, New Zealand


def add_arguments(parser):
    add_tool(parser)
    add_table(parser)


def run_cases(tool):
    """Empty by the name of each case that came out right, else its last line."""
    found = {}
    for script in sorted(CASES.glob("*/run.sh")):
        name = script.parent.name
        try:
            ran = subprocess.run(
                ["bash", script],
                env={**os.environ, "ORTHODRIVE": str(tool)},
                capture_output=True,
                text=True,
                timeout=CASE_S,
                check=False,
            )
            lines = (ran.stdout + ran.stderr).strip().splitlines()
            found[name] = "" if ran.returncode == 0 else (lines or ["no output"])[-1]
        except subprocess.TimeoutExpired:
            found[name] = f"no end within {CASE_S} s"
        print(f"{name}: {found[name] or 'right'}", flush=True)
    return found


# ---- rows: what, asked, reached, page


def cases_row(cases):
    right = sum(not said for said in cases.values())
    return ["cases that are right", f"{len(cases)} of {len(cases)}", f"{right} of {len(cases)}", ""]


def opendrive_rows(results):
    files = results.get("files", {})
    valid = [f for name, f in files.items() if not foreign_opendrive.is_broken(name)]
    broken = [f for name, f in files.items() if foreign_opendrive.is_broken(name)]
    page = "[foreign_opendrive](foreign_opendrive.md)"
    missing = results.get("of", len(files)) - len(files)
    rows = []
    for step in foreign_opendrive.LIMITS_S:
        done = sum(step not in f["faults"] for f in valid)
        rows.append(
            [f"valid OpenDRIVE files: {step}", f"{len(valid)} of {len(valid)}", f"{done} of {len(valid)}", page]
        )
    clear = sum(not any(text.startswith("!") for text in f["faults"].values()) for f in broken)
    asked = f"{len(broken)} of {len(broken)}"
    rows.append(["broken ones: read on, or one clear line", asked, f"{clear} of {len(broken)}", page])
    if missing:
        rows.append(["OpenDRIVE files not measured yet", "0", missing, page])
    return rows


def osm_rows(verdicts, lanes):
    page = "[foreign_osm](foreign_osm.md)"
    links = sum(n["broken_links"] + n["lane_link_errors"] for n in verdicts.values())
    passed = sum(n["verdict"]["pass"] for n in verdicts.values())
    rows = [
        [
            "OSM extracts whose verdict is pass",
            f"{len(verdicts)} of {len(verdicts)}",
            f"{passed} of {len(verdicts)}",
            page,
        ],
        ["their broken links", "0", links, page],
    ]
    for what, name in (("lanes", "lanes as netconvert has them"), ("speeds", "limits as netconvert has them")):
        equal = sum(n[what]["equal_km"] for n in lanes.values())
        total = equal + sum(e["km"] for n in lanes.values() for e in n[what]["different"].values())
        reached = f"{fixed(equal, 1)} of {fixed(total, 1)} km; the others with a reason each"
        rows.append([name, "equal, or better with a reason", reached, page])
    return rows


def countries_row():
    """Of the page that tools/catalogue/countries_page writes from the catalogue."""
    table = COUNTRIES.read_text().split("<!-- countries")[1].split("<!-- end -->")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines() if line.startswith("| ")][
        1:
    ]
    good = [
        cells
        for cells in rows
        if cells[1] and cells[2] and cells[3] in ("left", "right") and re.search(r"\d", cells[4])
    ]
    by_hand = sum("by hand" in cells[1] for cells in good)
    reached = f"{len(good)}, {by_hand} of them with a photo that is fetched by hand"
    return ["countries with photo, terrain, side and speeds", COUNTRIES_ASKED, reached, "[countries](../countries.md)"]


ABOUT = """# Measured: data of strangers

`tools/measure strangers` runs the cases of `../shared/cases` (small inputs after public reports) and takes the other
numbers from the pages that the last column names, which name their own commits.

"""


def page(cases, opendrive, verdicts, lanes):
    text = ABOUT + header(["what", "asked", "reached", "page"])
    for cells in [cases_row(cases), *opendrive_rows(opendrive), *osm_rows(verdicts, lanes), countries_row()]:
        text += row(cells)
    wrong = {name: said for name, said in cases.items() if said}
    if wrong:
        text += "\n" + header(["case that is wrong", "its last line"])
        text += "".join(row([name, foreign_opendrive.cut(said)]) for name, said in wrong.items())
    return text


def run(args):
    results = read_results(STORE, {"cases": {}})
    if not args.table:
        results = {"commit": commit(), "cases": run_cases(args.tool.resolve())}
        write_results(STORE, results)
    verdicts, lanes = (read_results(store, {"extracts": {}})["extracts"] for store in foreign_osm.STORES.values())
    opendrive = read_results(foreign_opendrive.STORE, {})
    write_page(PAGE, [STORE], page(results["cases"], opendrive, verdicts, lanes))

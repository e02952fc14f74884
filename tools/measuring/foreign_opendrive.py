# SPDX-License-Identifier: Apache-2.0
"""OpenDRIVE files of others (../shared/foreign/opendrive): each is read, driven, exported and packed as an FMU.
Writes docs/measured/foreign_opendrive.md.

One process after another, small files first, each with a time limit; called again it goes on with the files that have
no result of this commit. With FMPy (tools/setup --peers) every tenth FMU is checked and its car drives a second.
"""

import json
import re
import shutil
import signal
import subprocess
import time

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

STORE, PAGE = "foreign_opendrive.json", PAGES / "foreign_opendrive.md"
MAPS = ROOT.parent / "shared/foreign/opendrive"
PYTHON = ROOT / "build/peers/fmi/bin/python"
LIMITS_S = {"read": 60, "drive": 120, "all roads": 300, "export": 300, "FMU": 60}  # of a step; longer is a hang
WALL_SHARE = 40
FMU_SHARE = 10  # one FMU in ten runs in FMPy
BROKEN = re.compile("invalid|negative|_issue|unsupported")  # in names of asam_qc: breaks a rule on purpose
# Rules of elements that are passed over, which `opendrive.passed_over` says: signals, objects that are not read.
IN_PASSED = re.compile(r"road_object|road\.object|corner_(road|local)_element|signal_reference|optional_param")
FINDING = re.compile(r"^([a-z_]+\.[a-z_]+)(?: at [^:]*)?: (.*)")
USUAL = {"opendrive.passed_over", "drive.open_route", "drive.no_gpx", "scene.local_frame"}  # say nothing of a fault
ENDED = ("routes_finished", "routes_too_short")
SHOWN = 25  # rows of a list


def add_arguments(parser):
    add_tool(parser, "out/foreign_opendrive")
    add_table(parser)
    parser.add_argument("--keep", action="store_true", help="keep good results of other commits, too")


# ---- one file


def steps_of(tool, file, folder):
    """Words of each step's command."""
    network = ["--network", file]
    return {
        "read": [tool, "evaluate", "network", file, "--json"],
        "drive": [tool, "drive", *network, "-o", folder / "drive"],
        "all roads": [tool, "drive", *network, "--all-roads", "-o", folder / "all"],
        "export": [tool, "export", *network, "--glb", folder / "scene.glb"],
        "FMU": [tool, "fmu", *network, "--car", "family_car", "-o", folder / "car.fmu"],
    }


def run_step(words, limit_s):
    """(exit code or None after the limit, lines of stderr, stdout). The limit is of processor time; where others use
    the machine, too, the clock may show WALL_SHARE times as much.
    """
    words = ["prlimit", f"--cpu={limit_s}", *map(str, words)]
    try:
        ran = subprocess.run(words, capture_output=True, timeout=WALL_SHARE * limit_s, check=False)
    except subprocess.TimeoutExpired as late:
        return None, (late.stderr or b"").decode(errors="replace").splitlines(), ""
    if ran.returncode in (-signal.SIGKILL, -signal.SIGXCPU):
        return None, ran.stderr.decode(errors="replace").splitlines(), ""
    return ran.returncode, ran.stderr.decode(errors="replace").splitlines(), ran.stdout.decode(errors="replace")


def fault_of(code, lines, file, limit_s):
    """Empty for a step that ended well, else what it said; with "!" before where that is not one clear line."""
    if code == 0:
        return ""
    if code is None:
        return f"! no end within {limit_s} s"
    said = [line.removeprefix("orthodrive: ") for line in lines if line.startswith("orthodrive: ")]
    if code != 1 or len(said) != 1 or not said[0].startswith(str(file)):
        return f"! exit code {code}: {' / '.join(said or lines[-2:])}"
    return said[0].removeprefix(f"{file}: ")


def car_drives(folder):
    """Empty, or what FMPy finds wrong with the car's FMU."""
    rows = (folder / "drive/lap.csv").read_text().splitlines()
    start = dict(zip(rows[0].split(","), rows[len(rows) // 2].split(","), strict=True))
    pose = [start[name] for name in ("x_m", "y_m", "z_m", "heading_rad")]
    script = ROOT / "tools/measuring/fmu_steps.py"
    code, lines, _ = run_step([PYTHON, script, folder / "car.fmu", *pose], LIMITS_S["FMU"])
    return "" if code == 0 else f"! FMPy: {lines[-1] if lines else code}"


def checks_of(scores):
    """What `evaluate network --json` finds fault with: the worst of each kind of its verdict; wrong links."""
    faults = {kind: of["worst"] for kind, of in scores["verdict"].items() if isinstance(of, dict) and of.get("places")}
    return faults | {key: scores[key] for key in ("broken_links", "lane_link_errors") if scores[key]}


def drive_numbers(lines, folder):
    """What the summaries of both drives say."""
    numbers = {}
    off = [line for line in lines if line.startswith("Tyre contacts off the road: ")]
    if off:
        numbers["off_percent"] = float(off[0].split(": ")[1].split(" ")[0])
    file = folder / "all/all_roads.json"
    if file.exists():
        of_all = json.loads(file.read_text())
        wanted = ("routes", "routes_finished", "routes_too_short", "off_road_places", "jolt_places", "bump_places")
        numbers |= {key: of_all[key] for key in wanted} | {"km": round(of_all["length_m"] / 1000, 2)}
    return numbers


def measure(tool, file, folder, on, with_fmpy):
    """What came of each step, findings by code with their first text, seconds."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    start, faults, findings, checks, heard = time.monotonic(), {}, {}, {}, []
    for step, words in steps_of(tool, file, folder).items():
        code, lines, printed = run_step(words, LIMITS_S[step])
        heard += lines
        if step == "read" and code == 0:
            checks = checks_of(json.loads(printed))
        faults |= {step: text} if (text := fault_of(code, lines, file, LIMITS_S[step])) else {}
        for found in filter(None, map(FINDING.match, lines)):
            findings.setdefault(found[1], found[2][:160])
    result = {"commit": on, "faults": faults, "findings": findings, "checks": checks}
    result["numbers"] = drive_numbers(heard, folder)
    result["seconds"] = round(time.monotonic() - start, 1)
    if with_fmpy and not {"drive", "FMU"} & set(faults):
        result["fmpy"] = True
        faults |= {"FMU": text} if (text := car_drives(folder)) else {}
    for made in ("scene.glb", "car.fmu"):
        (folder / made).unlink(missing_ok=True)
    return result


# ---- the page


LEFT = "\n`road_lane_border_overlap_with_inner_lanes` is a micrometre there: too little to say."

ABOUT = f"""# Measured: OpenDRIVE files of others

`tools/measure foreign-opendrive` writes this page. Files that other programs wrote, and that the tests of others use,
by where they come from; of ASAM's checker those whose name says so break a rule on purpose. Each is read
(`evaluate network`), driven (`drive`, `drive --all-roads`), exported and packed as an FMU with a car; the steps may
take {", ".join(f"{s} s ({name})" for name, s in LIMITS_S.items())} of processor time.
What is said of odd files: [opendrive_elements.md](../opendrive_elements.md). Some valid files are made for their
geometry alone (climbs of 50 to 150 %, banks of 45 degrees and more, steps of a metre): no car gets over them.

"""


def is_broken(name):
    return name.startswith("asam_qc/") and bool(BROKEN.search(name))


def cut(text):
    """As one cell of a table."""
    text = text.replace("|", "/")
    return text if len(text) <= 100 else text[:97] + "..."


def short(name):
    """Names of ASAM's files say everything twice."""
    return name.removesuffix(".xodr").replace("tests_data_", "").replace("EnvironmentSimulator_Unittest_xodr_", "")


def table(files):
    """Sources below each other, their sum last."""
    text = header(
        ["source", "files", "valid", *(f"{step}" for step in LIMITS_S), "broken", "read on", "one line", "seconds"]
    )
    sources = sorted({name.split("/")[0] for name in files})
    for source in [*sources, ""]:
        own = {name: f for name, f in files.items() if name.startswith(source)}
        valid = [f for name, f in own.items() if not is_broken(name)]
        broken = [f for name, f in own.items() if is_broken(name)]
        done = [sum(step not in f["faults"] for f in valid) for step in LIMITS_S]
        read_on = sum(not f["faults"] for f in broken)
        refused = sum(bool(f["faults"]) and not any(t.startswith("!") for t in f["faults"].values()) for f in broken)
        seconds = fixed(sum(f["seconds"] for f in own.values()), 0)
        text += row([source or "**all**", len(own), len(valid), *done, len(broken), read_on, refused, seconds])
    return text


def failing(files):
    """Valid files with a fault, broken ones without a clear line: a row for each text."""
    text = header(["file", "step", "what it says"])
    rows = []
    for name, f in files.items():
        by_text = {}
        for step, said in f["faults"].items():
            if not is_broken(name) or said.startswith("!"):
                by_text.setdefault(said, []).append(step)
        rows += [row([short(name), ", ".join(steps), cut(said)]) for said, steps in by_text.items()]
    return (text + "".join(rows[:SHOWN]) if rows else "None.\n") + more(rows)


def more(rows):
    return f"\nAnd {len(rows) - SHOWN} more.\n" if len(rows) > SHOWN else ""


def refused(files):
    """What broken files are refused with, how often."""
    said = {}
    for name, f in files.items():
        if is_broken(name) and f["faults"]:
            said.setdefault(next(iter(f["faults"].values())), []).append(name)
    rows = [row([short(names[0]), len(names), cut(text)]) for text, names in said.items()]
    return header(["broken file (first)", "files", "line"]) + "".join(rows[:SHOWN]) + more(rows)


def silent(files):
    """Broken files of which nothing is said, by the rule that they break, but for those of elements passed over."""
    rules, passed_over = {}, 0
    for name, f in files.items():
        if not is_broken(name) or f["faults"] or set(f["findings"]) - USUAL or f["checks"]:
            continue
        if IN_PASSED.search(name) and "opendrive.passed_over" in f["findings"]:
            passed_over += 1
            continue
        rule = re.sub(r"_?(close_match|invalid|multiple|issue|Ex_).*", "", short(name).removeprefix("asam_qc/"))
        rule = re.sub(r"^(.+)_\1", r"\1", rule).replace("not_implemented_yet_", "")
        rules[rule] = rules.get(rule, 0) + 1
    listed = ", ".join(f"{rule}{f' ({n})' if n > 1 else ''}" for rule, n in rules.items())
    text = f"{passed_over} broken files break a rule of signals or of objects that are not read: that these are passed "
    text += f"over is said.\nOf {sum(rules.values())} others that are read on nothing is said. "
    return text + f"Their rules: {listed or '-'}.{LEFT if rules else ''}\n"


def most_frequent(files):
    by_code = {}
    for name, f in files.items():
        for code, text in f["findings"].items():
            by_code.setdefault(code, []).append((name, text))
    ten = sorted(by_code.items(), key=lambda item: (-len(item[1]), item[0]))[:10]
    rows = [row([f"`{code}`", len(of), cut(of[0][1])]) for code, of in ten]
    return header(["finding", "files", "for example"]) + "".join(rows)


def is_faulty(numbers):
    ended = sum(numbers.get(key, 0) for key in ENDED)
    return numbers.get("off_percent") or numbers.get("off_road_places") or numbers.get("routes", 0) > ended


def driven(files):
    """Valid files with a route that does not end, or a tyre beside the road."""
    valid = {name: f for name, f in files.items() if not is_broken(name)}
    km = sum(f["numbers"].get("km", 0) for f in valid.values())
    bad = {name: f for name, f in valid.items() if is_faulty(f["numbers"])}
    text = f"`drive --all-roads` drives {fixed(km, 1)} km of the valid files. Of {len(bad)} of them a tyre leaves the "
    text += "road, or a route does not come to its end; the others are driven without either.\n\n"
    rows = []
    for name, f in bad.items():
        n = f["numbers"]
        codes = ("drive.not_finished", "drive.too_tight", "drive.off_road")
        said = next((f["findings"][code] for code in codes if code in f["findings"]), "-")
        ended = f"{n.get('routes_finished', 0)} of {n.get('routes', 0)}"
        rows.append(row([short(name), fixed(n.get("off_percent"), 1), ended, cut(said)]))
    return (
        text + header(["file", "tyres off the road, %", "routes ended", "finding"]) + "".join(rows[:SHOWN]) + more(rows)
    )


def page(results):
    files = results.get("files", {})
    valid = {name: f for name, f in files.items() if not is_broken(name)}
    good = sum(not f["faults"] for f in valid.values())
    broken = [f["faults"].values() for name, f in files.items() if is_broken(name)]
    clear = sum(not any(text.startswith("!") for text in texts) for texts in broken)
    in_fmpy = [f for f in files.values() if f.get("fmpy")]
    missing = results.get("of", len(files)) - len(files)
    text = ABOUT + (f"{missing} files, the largest, are not measured yet.\n\n" if missing else "")
    text += f"**All steps succeed for {good} of {len(valid)} valid files** (asked: for all). **{clear} of "
    text += f"{len(broken)} broken ones are read on or give one clear line** (asked: all). "
    text += f"{sum('FMU' not in f['faults'] for f in in_fmpy)} of {len(in_fmpy)} FMUs drive in FMPy.\n\n"
    text += f"{table(files)}\n{silent(files)}\n"
    text += f"## What fails\n\n{failing(files)}\n## How they are driven\n\n{driven(files)}\n"
    return text + f"## Broken ones that are refused\n\n{refused(files)}\n## Findings\n\n{most_frequent(files)}"


def run(args):
    results = {"files": {}, **read_results(STORE, {})}
    if not args.table:
        tool, on = args.tool.resolve(), commit()
        maps = sorted(MAPS.glob("*/*.xodr"), key=lambda file: (file.stat().st_size, file))
        for k, file in enumerate(maps):
            name = str(file.relative_to(MAPS))
            last = results["files"].get(name)
            if last and (last["commit"] == on or (args.keep and not last["faults"])):
                continue
            with_fmpy = k % FMU_SHARE == 0 and PYTHON.exists()
            found = measure(tool, file, args.out / name.removesuffix(".xodr"), on, with_fmpy)
            results = {"of": len(maps), "files": dict(sorted({**results["files"], name: found}.items()))}
            write_results(STORE, results)
            print(f"{k + 1}/{len(maps)} {name} {found['seconds']} s {found['faults'] or 'good'}", flush=True)
    write_page(PAGE, [STORE], page(results))

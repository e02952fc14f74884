# SPDX-License-Identifier: Apache-2.0
"""Every page of docs/measured, measured on one commit in one run. Long: --list says how long, and what each part needs.

    tools/measure all --list            the parts in their order, with what they took the last time
    tools/measure all                   what is not measured on this commit yet; stopped and called again it goes on
    tools/measure all --only site,lap   these parts

Builds the commit first, and begins with empty folders below out/ where those there are of another commit. A part that
fails is told at the end, and the others go on. Which part was measured on which commit, and how long it took, is in
bench/results/measured.json. Nothing else should run on the machine: times are measured, too.
"""

import dataclasses
import re
import shutil
import subprocess
import sys
import time

from measuring.common import PAGES, ROOT, STAMP, commit, read_results, write_results

STORE = "measured.json"
MAKES = [
    "numbers",
    "synth",
    "synth_measured",
    "refinement",
    "forests",
    "painted",
    "wide_roads",
    "second_eye_measured",
    "adapt_measured",
    "heights",
    "banking",
    "network",
    "lap",
    "every_road",
    "virtual_ring",
    "scaling",
    "cluster",
    "faults",
]  # folders below out/
BUILT = ROOT / "out/numbers"  # of the part `site`
REGION = ROOT / "out/scaling/100"  # of the part `scaling`
ROADS = {name: BUILT / name / "roads.xodr" for name in ("village", "kvarnbyn", "pardubice")}
SITES = {
    "village": BUILT / "village_site/site.toml",
    "Kvarnbyn": ROOT / "sites/kvarnbyn.toml",
    "Pardubice": ROOT / "sites/pardubice.toml",
}


@dataclasses.dataclass
class Part:
    name: str
    pages: str
    minutes: float  # on two cores, as of the last run or by the page before; --list has what was measured
    commands: list  # of tools/measure
    needs: str = ""


def pairs(named):
    return [f"{name}={file}" for name, file in named.items()]


def scenes(names):
    return [f"{name}={SITES[name]}={BUILT / name.lower()}" for name in names]


TOWNS = "../shared/data"
PARTS = [  # a part stands behind those whose files it takes
    Part("synth", "synth", 2, [["synth"]], TOWNS),
    Part("site", "site", 10, [["site"]], TOWNS),
    Part("segment", "segment", 15, [["segment"]], TOWNS),
    Part("dense-crf", "dense_crf", 1, [["dense-crf"]], TOWNS),
    Part("refine", "refine", 45, [["refine"]], TOWNS),
    Part("nlo", "nlo", 30, [["nlo"]], TOWNS + ", what `refine` made"),
    Part("wide-roads", "road_surface", 5, [["wide-roads"]], TOWNS),
    Part("second-eye", "second_eye", 20, [["second-eye"]], TOWNS),
    Part("adapt", "adapt", 40, [["adapt"]], TOWNS),
    Part("regions", "regions", 30, [["regions"]], TOWNS),
    Part("heights", "elevate", 10, [["heights"]], TOWNS + ", what `refine` made"),
    Part("banking", "banking", 1, [["banking"]], TOWNS + ", what `refine` made"),
    Part("drive-logs", "drive_logs", 1, [["drive-logs"]], TOWNS),
    Part(
        "network",
        "network",
        5,
        [["network"], ["opendrive", "--files", *pairs({n: ROADS[n] for n in ("kvarnbyn", "pardubice")})]],
        TOWNS + ", what `refine` and `site` made, SUMO, xmllint",
    ),
    Part(
        "junctions",
        "junctions",
        1,
        [["junctions", "--sites", *pairs({n: BUILT / n for n in ("village", "kvarnbyn")})]],
        "what `site` made",
    ),
    Part("verdict", "verdict", 1, [["verdict", "--files", *pairs(ROADS)]], "what `site` made"),
    Part("foreign-osm", "foreign_osm", 1, [["foreign-osm"]], "`../shared/foreign/osm`, python3-gdal, sumo"),
    Part(
        "foreign-opendrive",
        "foreign_opendrive",
        25,
        [["foreign-opendrive"]],
        "`../shared/foreign/opendrive`, FMPy",
    ),
    Part("strangers", "strangers", 2, [["strangers"]], "`../shared/cases`, what the two parts before measured"),
    Part(
        "every-road",
        "every_road",
        5,
        [["every-road", "--files", *pairs({n.capitalize(): ROADS[n] for n in ("kvarnbyn", "pardubice")})]],
        "what `site` made",
    ),
    Part(
        "traffic",
        "traffic",
        90,
        [
            [
                "traffic",
                *pairs({n.capitalize(): BUILT / n for n in ("village", "kvarnbyn", "pardubice")}),
                "--osm",
                f"Kvarnbyn={ROOT.parent / 'shared/data/kvarnbyn/roads.osm'}",
            ]
        ],
        TOWNS + ", what `site` made, SUMO",
    ),
    Part("vehicle", "vehicle", 1, [["vehicle"]]),
    Part("lap", "lap", 3, [["lap"]], TOWNS),
    Part(
        "roadquery",
        "roadquery c_interface opencrg",
        10,
        [
            [
                "roadquery",
                *(
                    word
                    for pair in pairs(
                        {
                            "village": ROADS["village"],
                            "ring": ROOT / "out/lap/ring.xodr",
                            "kvarnbyn": ROADS["kvarnbyn"],
                            "pardubice": ROADS["pardubice"],
                        }
                    )
                    for word in ("--site", pair)
                ),
            ]
        ],
        "what `site` and `lap` made",
    ),
    Part("virtual-ring", "virtual_ring", 15, [["virtual-ring"]], TOWNS + ", python3-gdal"),
    Part("scaling", "scaling", 110, [["scaling"]], TOWNS),
    Part(
        "scene",
        "scene",
        20,
        [
            ["scene", "--sites", *scenes(SITES), f"100 km2={REGION / 'site/site.toml'}={REGION / 'out'}"],
            ["scene-parts", "--sites", *scenes(["village", "Pardubice"])],
        ],
        "what `site` and `scaling` made, linux-perf",
    ),
    Part(
        "stream",
        "stream",
        10,
        [["stream", "--sites", f"100 km2={REGION / 'out'}", "--cameras", "driver"]],
        "what `scaling` made, Chromium",
    ),
    Part(
        "cluster",
        "cluster",
        35,
        [
            ["cluster", "--site", ROOT / "out/scaling/10/site/site.toml", "--name", "region of 10 km2"],
            [
                "cluster",
                "--site",
                SITES["Pardubice"],
                "--name",
                "Pardubice, 23 km2",
                "--without-alone",
                "--without-loss",
            ],
        ],
        "what `scaling` made, Slurm, root",
    ),
    Part("fetch", "fetch", 3, [["fetch"]]),
    Part("faults", "faults", 30, [["faults"]], "root, libfaketime"),
    Part("start", "start", 1, [["start"]]),
    Part("clone", "clone", 75, [["clone"]]),
    Part("packaging", "packaging", 15, [["packaging"]], "root, debootstrap, the net"),
    Part("fuzz", "fuzz", 375, [["fuzz", "--forget", "all"]], "clang"),
]


def add_arguments(parser):
    parser.add_argument(
        "--list", action="store_true", help="measure nothing: say what is measured, how long it takes and what it needs"
    )
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="NAME,...", help="these parts")
    parser.add_argument(
        "--dirty", action="store_true", help="measure although the tree has changes, which the pages then say"
    )


def said_minutes(part, done):
    of_last = done.get(part.name, {}).get("seconds")
    return part.minutes if of_last is None else of_last / 60


def listed(parts, done):
    text = "".join(
        f"{part.name:12} {said_minutes(part, done):6.1f} min  "
        f"{done.get(part.name, {}).get('commit', '-'):20} {part.pages}"
        + (f"; needs {part.needs}" if part.needs else "")
        + "\n"
        for part in parts
    )
    return text + f"{'all':12} {sum(said_minutes(part, done) for part in parts):6.1f} min\n"


def faults_of(part, on, pages):
    """What is wrong with the pages of a part that has just been measured on a commit."""
    found = []
    for name in part.pages.split():
        stamps = STAMP.findall((pages / f"{name}.md").read_text())
        if stamps != [on]:
            found.append(
                f"{part.name}: docs/measured/{name}.md was measured on {', '.join(stamps) or 'no commit'}, "
                f"not on {on} alone"
            )
    return found


def measure_all(parts, on, execute, read, write, pages=PAGES):
    """Runs what is not done on commit `on`; what failed as lines. `execute` runs words of tools/measure."""
    failed, done, start = [], read(), time.monotonic()
    for part in parts:
        if done.get(part.name, {}).get("commit") == on:
            print(f"{part.name}: done on {on} before, {done[part.name]['seconds'] / 60:.1f} min", flush=True)
            continue
        print(f"{part.name}: about {said_minutes(part, done):.0f} min", flush=True)
        begin = time.monotonic()
        codes = [execute(words) for words in part.commands]
        found = [
            f"{part.name}: `tools/measure {words[0]}` ended with {code}"
            for words, code in zip(part.commands, codes, strict=True)
            if code
        ] or faults_of(part, on, pages)
        failed += found
        if not found:
            done = read()
            done[part.name] = {"commit": on, "seconds": round(time.monotonic() - begin, 1)}
            write(done)
            print(f"{part.name}: {(time.monotonic() - begin) / 60:.1f} min", flush=True)
    total = sum(done[part.name]["seconds"] for part in parts if done.get(part.name, {}).get("commit") == on)
    print(
        f"all: {(time.monotonic() - start) / 60:.1f} min in this run, {total / 60:.1f} min for what is measured on {on}"
    )
    return failed


def begin_anew(on):
    """Empties the folders of another commit, and builds this one."""
    mark = ROOT / "out/measured_commit.txt"
    if not mark.exists() or mark.read_text() != on:
        for folder in MAKES:
            shutil.rmtree(ROOT / "out" / folder, ignore_errors=True)
        mark.parent.mkdir(exist_ok=True)
        mark.write_text(on)
    subprocess.run([str(ROOT / "tools/build")], check=True)


def run(args):
    parts = [part for part in PARTS if not args.only or part.name in args.only]
    unknown = set(args.only or ()) - {part.name for part in PARTS}
    if unknown:
        sys.exit(
            f"tools/measure all: no part {', '.join(sorted(unknown))}; "
            f"there are {', '.join(part.name for part in PARTS)}"
        )
    read, write = lambda: read_results(STORE, {}), lambda done: write_results(STORE, done)
    if args.list:
        print(listed(parts, read()), end="")
        return 0
    on = commit()
    if not re.fullmatch("[0-9a-f]+", on) and not args.dirty:
        sys.exit(f"tools/measure all: the commit is {on}; commit first, or give --dirty")
    if any(read().get(part.name, {}).get("commit") != on for part in parts):
        begin_anew(on)
    failed = measure_all(
        parts,
        on,
        lambda words: subprocess.run([str(ROOT / "tools/measure"), *map(str, words)], check=False).returncode,
        read,
        write,
    )
    print("\n".join(failed), end="\n" if failed else "")
    return 1 if failed else 0

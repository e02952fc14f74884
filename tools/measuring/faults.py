# SPDX-License-Identifier: Apache-2.0
"""Faults of `orthodrive build`: kills, stops, full and read-only disks, permissions, clocks, sources, a second host.
Writes docs/measured/faults.md.

By hand: some minutes. Builds two synthetic sites, disturbs builds of them, lets the same command finish and compares
all files that hold no times. Disks are file systems in memory in a mount namespace (unshare); what the machine cannot
do is said on the page.
"""

import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from measuring.common import (
    PAGES,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    machine,
    read_results,
    row,
    write_page,
    write_results,
)

STORE, PAGE = "faults.json", PAGES / "faults.md"
SITES = {
    "village": ["--preset", "village", "--seed", "7", "--size", "200", "--gsd", "0.5"],
    "circuit": ["--preset", "circuit", "--seed", "5", "--size", "500", "--gsd", "1"],
}
STAGES = ["segment", "refine", "elevate", "network", "drive", "scene", "report"]
DISKS = 14  # sizes of a disk that fills up, evenly from nothing to what a build needs


def add_arguments(parser):
    add_tool(parser, "out/faults")
    add_only(parser, SITES)
    add_table(parser)
    parser.add_argument(
        "--kills", type=int, default=50, help="random kills and as many random stops, of each site (%(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the times of kills (%(default)s)")


def hashes(folder):
    """Of all files whose content must not depend on the run."""
    return {
        str(f.relative_to(folder)): hashlib.sha256(f.read_bytes()).hexdigest()
        for f in sorted(folder.rglob("*"))
        if f.is_file()
        and f.name not in ("run.json", "report.html")
        and not (f.parent.name == ".orthodrive" and f.suffix == ".json")
    }


def command(tool, site, out):
    return list(map(str, [tool, "--threads", "2", "build", site / "site.toml", "-o", out]))


class Case:
    """Counts what was tried and what came out well, and keeps the first thing that did not."""

    def __init__(self):
        self.tried, self.good, self.first_bad, self.worst_s = 0, 0, "", 0.0

    def add(self, good, said):
        self.tried += 1
        self.good += bool(good)
        if not good and not self.first_bad:
            self.first_bad = str(said)[:300]

    def row(self):
        return {"tried": self.tried, "good": self.good, "first_bad": self.first_bad, "worst_s": round(self.worst_s, 2)}


def finish(tool, site, out, whole):
    """Builds to the end. Empty when the files are those of an undisturbed build, else what is wrong."""
    run = subprocess.run(command(tool, site, out), capture_output=True, text=True, check=False)
    if run.returncode != 0:
        return f"exit code {run.returncode}: {run.stderr}"
    ours = hashes(out)
    return ", ".join(sorted(f for f in ours | whole if ours.get(f) != whole.get(f)))


def interrupt(tool, site, out, after_s, number):
    """(exit code, seconds from the signal to the end, stderr); the code is 0 when the build was faster."""
    build = subprocess.Popen(command(tool, site, out), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(after_s)
    start = time.monotonic()
    build.send_signal(number)
    said = build.communicate()[1]
    return build.returncode, time.monotonic() - start, said


def interrupts(tool, site, out, whole, whole_s, count, rng, number):
    """Interrupts builds at random times, each from where the last one was, until each build is whole; `count` in
    all.
    """
    case, done = Case(), 0
    while done < count:
        shutil.rmtree(out, ignore_errors=True)
        of_this_build = []
        while done < count and len(of_this_build) < 5:
            code, seconds, said = interrupt(tool, site, out, rng.uniform(0, 0.7 * whole_s), number)
            if code == 0:
                break
            done += 1
            case.worst_s = max(case.worst_s, seconds)
            left = [str(f) for f in out.rglob("*.partial-*")] if number != signal.SIGKILL else []
            ended = code == 128 + number and said.endswith("stopped; run again to go on\n")
            not_begun = code == -number and not said  # it was still loading its libraries
            clean = number == signal.SIGKILL or ((ended or not_begun) and not left)
            of_this_build.append("" if clean else f"exit code {code}, {left}, {said}")
        wrong = finish(tool, site, out, whole)
        if wrong:
            shutil.copytree(out, out.parent / f"bad_{done}", dirs_exist_ok=True)
        for bad in of_this_build:
            case.add(not bad and not wrong, bad or wrong)
    return case


def one_line(run):
    return run.returncode == 1 and run.stderr.count("\n") == 1 and run.stderr.startswith("orthodrive: ")


def quietly(tool, site, out, before=()):
    words = command(tool, site, out)
    return subprocess.run([*before, words[0], "--quiet", *words[1:]], capture_output=True, text=True, check=False)


def next_stage(out):
    """The first stage without a record."""
    return next((s for s in STAGES if not (out / ".orthodrive" / f"{s}.json").exists()), "end")


def disks(tool, site, mount, whole, size):
    """In a mount namespace: a disk of each size fills up, then is read-only, then has room."""
    rows, full, read_only = {}, Case(), Case()
    for i in range(DISKS):
        subprocess.run(
            ["mount", "-t", "tmpfs", "-o", f"size={max(16384, size * i // DISKS)}", "tmpfs", mount], check=True
        )
        out = mount / "out"
        run = quietly(tool, site, out)
        stage = next_stage(out)
        rows[stage] = rows.get(stage, 0) + 1
        lost = [s for s in STAGES if (out / ".orthodrive" / f"{s}.json").exists()]
        said_full = one_line(run)
        subprocess.run(["mount", "-o", "remount,ro,size=1g", mount], check=True)
        before = hashes(out) if out.exists() else {}
        again = quietly(tool, site, out)
        read_only.add(one_line(again) and (hashes(out) if out.exists() else {}) == before, again.stderr)
        subprocess.run(["mount", "-o", "remount,rw,size=1g", mount], check=True)
        kept = [s for s in STAGES if (out / ".orthodrive" / f"{s}.json").exists()]
        wrong = finish(tool, site, out, whole)
        full.add(said_full and lost == kept and not wrong, run.stderr if not said_full else wrong)
        subprocess.run(["umount", mount], check=True)
    return {"disk full": {**full.row(), "stages": rows}, "read-only": read_only.row()}


def in_namespace(*words):
    """The JSON that this file prints when it runs in its own namespaces; None where that is not allowed."""
    run = subprocess.run(
        ["unshare", "-Urm", sys.executable, "-B", __file__, *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
    )
    if run.returncode != 0:
        print(run.stderr, file=sys.stderr)
        return None
    return json.loads(run.stdout)


def no_permission(tool, site, out, whole):
    permission = Case()
    for stage in STAGES[:-1]:
        shutil.rmtree(out, ignore_errors=True)
        shutil.copytree(out.parent / "whole", out)
        (out / f".orthodrive/{stage}.json").unlink()
        before = hashes(out)
        run = quietly(tool, site, out, ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"])
        permission.add(one_line(run) and hashes(out) == before and not finish(tool, site, out, whole), run.stderr)
    return permission.row()


def source_changes(tool, site, out, whole):
    source = Case()
    for stage, file in (
        ("segment", "ortho.tif"),
        ("refine", "roads.osm"),
        ("elevate", "dtm_1m.tif"),
        ("scene", "dtm_1m.tif"),
    ):
        shutil.rmtree(out, ignore_errors=True)
        build = subprocess.Popen(
            [*command(tool, site, out)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        # It takes the lock when it has read the sources: a change before that is one between two builds.
        while build.poll() is None and not ((out / ".orthodrive/lock").exists() and next_stage(out) == stage):
            time.sleep(0.002)
        content = (site / file).read_bytes()
        (site / file).write_bytes(content + b"\n")  # for a moment the file is empty
        said = build.communicate()[1].splitlines()
        (site / file).write_bytes(content)
        told = build.returncode == 1 and said and "changed while stage" in said[-1] and not (out / "run.json").exists()
        source.add(told and not finish(tool, site, out, whole), said[-1:] or build.returncode)
    return source.row()


def second_host(tool, site, out, whole):
    host = Case()
    shutil.rmtree(out, ignore_errors=True)
    first = subprocess.Popen(
        ["unshare", "-Uru", "sh", "-c", 'hostname elsewhere && exec "$@"', "sh", *command(tool, site, out)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while first.poll() is None and not ((out / ".orthodrive/lock").exists() and (out / ".orthodrive/lock").read_text()):
        time.sleep(0.002)
    second = quietly(tool, site, out)
    host.add(
        one_line(second)
        and "on elsewhere" in second.stderr
        and first.wait() == 0
        and not finish(tool, site, out, whole),
        second.stderr,
    )
    return host.row()


def clock_jumps(tool, site, out, whole):
    clock = Case()
    shutil.rmtree(out, ignore_errors=True)
    for when in ("+30 days", "-30 days", "+1 hour"):
        run = quietly(tool, site, out, ["faketime", "-f", when.replace(" days", "d").replace(" hour", "h")])
        clock.add(run.returncode == 0 and not finish(tool, site, out, whole), run.stderr)
    return clock.row()


def other_faults(tool, site, out, whole):
    rows = {}
    if os.getuid() == 0:
        rows["no permission"] = no_permission(tool, site, out, whole)
    rows["a source changes"] = source_changes(tool, site, out, whole)
    rows["a second host"] = second_host(tool, site, out, whole)
    if shutil.which("faketime"):
        rows["the clock jumps"] = clock_jumps(tool, site, out, whole)
    return rows


def measure(tool, folder, name, args):
    site, out, reference = folder / name / "site", folder / name / "disturbed", folder / name / "whole"
    shutil.rmtree(folder / name, ignore_errors=True)
    Tool(tool)("synth", *SITES[name], "-o", site)
    start = time.monotonic()
    subprocess.run(command(tool, site, reference), check=True, capture_output=True)
    whole_s, whole = time.monotonic() - start, hashes(reference)
    rng = random.Random(f"{name} {args.seed}")
    print(f"{name}: {whole_s:.1f} s, {len(whole)} files", flush=True)
    rows = {
        "kill -9": interrupts(tool, site, out, whole, whole_s, args.kills, rng, signal.SIGKILL).row(),
        "Ctrl-C": interrupts(tool, site, out, whole, whole_s, args.kills, rng, signal.SIGINT).row(),
    }
    print(rows, flush=True)
    size = sum(f.stat().st_size for f in reference.rglob("*") if f.is_file())
    (folder / name / "mount").mkdir()
    (folder / name / "whole.json").write_text(json.dumps(whole))
    rows |= in_namespace(tool, site, folder / name / "mount", folder / name / "whole.json", size) or {}
    rows |= other_faults(tool, site, out, whole)
    return {
        "commit": commit(),
        **machine(),
        "load": round(os.getloadavg()[0], 1),
        "seconds": round(whole_s, 1),
        "files": len(whole),
        "rows": rows,
    }


def table(numbers):
    names = [n for n in SITES if n in numbers]
    kinds = list(dict.fromkeys(k for n in names for k in numbers[n]["rows"]))
    text = header(["same bytes in the end, or one line and nothing lost", *names])
    for kind in kinds:
        cells = []
        for n in names:
            r = numbers[n]["rows"].get(kind)
            cells.append(
                "not tried"
                if r is None
                else f"{r['good']} of {r['tried']}"
                + (f" (slowest end {fixed(r['worst_s'], 1)} s)" if kind == "Ctrl-C" else "")
            )
        text += row([kind, *cells])
    for n in names:
        stages = numbers[n]["rows"].get("disk full", {}).get("stages", {})
        text += row(
            [
                f"disk full in {n}: stages where it struck",
                *[", ".join(f"{s} {c}" for s, c in stages.items()) if m == n else "" for m in names],
            ]
        )
    for key, title in (
        ("files", "files compared"),
        ("seconds", "seconds of a whole build"),
        ("load", "others' load of the machine"),
    ):
        text += row([title, *[numbers[n][key] for n in names]])
    for n in names:
        for kind, r in numbers[n]["rows"].items():
            if r["first_bad"]:
                text += f"\nFirst failure of {kind} in {n}: `{r['first_bad'].strip()}`\n"
    n = numbers[names[0]]
    return text + f"\nMeasured on {n['cores']} cores ({n['cpu']}), {n['memory_gb']} GB.\n"


def run(args):
    numbers = read_results(STORE, {})
    if not args.table:
        signal.signal(
            signal.SIGINT, signal.default_int_handler
        )  # a script's background job has it ignored, and so would its builds
        for name in args.only:
            numbers[name] = measure(Tool(args.tool).file, args.out, name, args)
            write_results(STORE, numbers)
    write_page(PAGE, [STORE], {"faults": table(numbers)})


if __name__ == "__main__":
    tool, site, mount, whole, size = sys.argv[1:]
    print(
        json.dumps(
            disks(tool, pathlib.Path(site), pathlib.Path(mount), json.loads(pathlib.Path(whole).read_text()), int(size))
        )
    )

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every command that the tool's --help and the pages show, as a reader would type it, in a folder where small
files stand for those that they name.

    run_examples.py TOOL SITES [TEXT]     only those with TEXT; SITES: what tests/faults/build_small leaves

Commands of pages are the indented and fenced lines of README.md, CONTRIBUTING.md, docs/*.md, models/ and viewer/ that
begin with the tool; those of one page run one after the other in a copy of the folder, pages whose commands all ran
elsewhere do not run again. Of lines that begin with tools/ the tool, its sub-command and its options must exist.
Words are changed by CHANGED alone, and MORE adds options that make a long one short. NOT_RUN names those that need what
no folder has, with the reason. Any other one that fails, or a rule that nothing needs, is an error.
"""

import functools
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

from small_folder import ENVIRONMENT, ROOT, cpu_seconds, helps, make_folder, run

NOT_RUN = {  # part of the example: why
    "new --relation": "a relation of a country's extract",
    "fetch site.toml": "asks servers; tests/fetch runs it against one",
    "fetch sites/ring.toml": "likewise; tests/fetch/ring_test.py does",
    "--log comma2k19": "a segment of that data set",
    "build region/site.toml": "takes a minute on the smallest region; tests/built_sites builds other sites",
    "town.osm.pbf": "an extract in that format; tests/io does",
}
CHANGED = {  # places lie elsewhere on the small site
    "529900,5542300": "460040,5270070",
    "530400,5542800": "460150,5270140",
    "322000 6394000 322500 6394500": "460020 5270020 460120 5270120",
    "way/26182390": "way/FIRST_WAY",
    "1000,2000": "460040,5270070",
    "1500,2600": "460150,5270140",
    "../shared/data/spielberg/spielberg_utm33.csv": "track.csv",
    "../shared/data/spielberg/osm_way_red_bull_ring.osm": "track.osm",
    "../shared/data/spielberg/elevation_zaggyai.csv": "heights.csv",
}
MORE = {  # part of the example: what is added to it
    "--preset region": ["--size", "2000", "--gsd", "2"],
    "--preset conurbation": ["--size", "2000", "--gsd", "2"],
    "--preset village": ["--size", "200", "--gsd", "1"],
    "--from-track": ["--gsd", "1"],
    "--preset lanes": ["--size", "400", "--gsd", "1"],
    "--preset circuit": ["--size", "500", "--gsd", "1"],
    "synth --seed 7": ["--size", "200", "--gsd", "1"],
    "synth --preset junction": ["--gsd", "1"],
    "tune sites.toml -o tuned --trials 200": ["--trials", "2"],
    "tune sites.toml -o tuned": ["--trials", "2"],
}


def examples_of_helps(tool):
    """Of one folder after the other, by its name, the commands to run in it."""
    found = {}
    for _, text in helps(tool):
        for line in text.splitlines():
            if line.startswith("  orthodrive "):
                found.setdefault(without_comment(line), None)
    return {"--help": list(found)}


def without_comment(line):
    return re.split(r"\s+#\s|\s{2,}", line.strip())[0]


def pages():
    yield from (ROOT / name for name in ("README.md", "CONTRIBUTING.md", "viewer/README.md"))
    yield from sorted((ROOT / "docs").glob("*.md"))
    yield from sorted((ROOT / "models").rglob("*.md"))


def commands_of(page):
    """What a reader would type: its indented and fenced lines, variables put in, what is optional in it, too."""
    text, fenced, variables = re.sub(r"\\\n\s*", "", page.read_text()), False, {}
    for line in text.splitlines():
        fenced = fenced != line.startswith("```")
        if line.startswith("```") or not (fenced or line.startswith("    ")):
            continue
        command = re.sub(r"[\[\]]", "", without_comment(line))
        if assigned := re.fullmatch(r"([A-Z]+)=(\S+)", command):
            variables[assigned[1]] = assigned[2]
            continue
        for name, value in variables.items():
            command = command.replace(f"${name}/", f"{value}/")
        yield from (re.sub(r"^build/release/", "", part.strip()) for part in command.split(" && "))


def examples_of_pages():
    found = {}
    for page in pages():
        run_here = [command for command in commands_of(page) if command.startswith(("orthodrive ", "ogr2ogr "))]
        if run_here:
            found[str(page.relative_to(ROOT))] = run_here
    return found


def fault_of_tool(command):
    """Of a line that begins with tools/: what of it does not exist, or nothing."""
    name, *words = shlex.split(re.sub(r"[<>|].*", "", command))
    if not os.access(ROOT / name, os.X_OK):
        return f"{name} is no program"
    known = (ROOT / name).read_text()
    if "python" in known.splitlines()[0]:  # the others would begin to work
        below = [word for word in words[:1] if re.fullmatch(r"[a-z][a-z-]*", word)]
        done = run(ROOT / name, *below, "--help", cwd=ROOT)
        if done.returncode != 0:
            return f"{name} {' '.join(below)} --help: {done.stderr.strip()}"
        known = done.stdout
    elif "ctest" in known:
        known += run("ctest", "--help").stdout
    lacking = [word for word in words if word.startswith("-") and word not in known]
    return f"{name} has no {' '.join(lacking)}" if lacking else None


def first_way(folder):
    """The id of a way that is a road of the small site."""
    text = (folder / "site/truth/centrelines.geojson").read_text()
    return json.loads(text)["features"][0]["properties"]["osm_id"]


def words_of(example, folder):
    for old, new in CHANGED.items():
        example = example.replace(old, new.replace("FIRST_WAY", str(first_way(folder))))
    words = shlex.split(example)[1:]
    for part, more in MORE.items():
        if part not in example:
            continue
        for name, value in zip(more[::2], more[1::2], strict=True):
            if name in words:
                words[words.index(name) + 1] = value
            else:
                words += [name, value]
        break
    return words


def run_example(tool, example, folder):
    """An error, or nothing."""
    command, _, otherwise = example.partition(" || ")
    if not command.startswith("orthodrive "):
        tool = command.split()[0]
    words = words_of(command, folder)
    if words[0] == "view":  # serves until it is stopped
        server = subprocess.Popen(
            [str(tool), *words, "--no-open"] if "--no-open" not in words else [str(tool), *words],
            cwd=folder,
            env=ENVIRONMENT,
            stdout=subprocess.PIPE,
            text=True,
        )
        first = server.stdout.readline()
        server.send_signal(signal.SIGINT)
        return None if server.wait() == 0 and first else f"said '{first}', then {server.returncode}"
    if "merge_38_to_32" in example:  # of maps with the classes that it merges
        folder = folder / "classes"
    done = run(tool, *words, cwd=folder, env=ENVIRONMENT)
    if done.returncode == 0 or (otherwise and done.returncode == 3):
        return None
    return f"exit code {done.returncode}: {done.stderr.strip()[-300:]}"


class Report:
    """What was run, what failed, which rules were needed."""

    def __init__(self, tool, text):
        self.tool, self.text, self.failures, self.ran, self.needed = tool, text, [], 0, set()

    def add(self, where, example, check):
        begun = cpu_seconds()
        error = check()
        self.ran += 1
        print(f"{'FAILED' if error else 'ok':6} {cpu_seconds() - begun:4.1f} s: {where}: {example}", flush=True)
        if error:
            self.failures.append(f"{where}: {example}\n    {error}")

    def run(self, where, examples, folder):
        for example in examples:
            rules = [part for rules in (NOT_RUN, CHANGED, MORE) for part in rules if part in example]
            self.needed.update(rules)
            if self.text in f"{where}: {example}" and not any(part in NOT_RUN for part in rules):
                self.add(where, example, functools.partial(run_example, self.tool, example, folder))


def main(tool, sites, text=""):
    tool, sites = pathlib.Path(tool).resolve(), pathlib.Path(sites).resolve()
    report = Report(tool, text)
    with tempfile.TemporaryDirectory(prefix="orthodrive-examples-") as name:
        small = pathlib.Path(name, "small")
        small.mkdir()
        make_folder(small, tool, sites)
        known = set()
        for where, examples in {**examples_of_helps(tool), **examples_of_pages()}.items():
            if known.issuperset(examples):
                continue
            known.update(examples)
            folder = pathlib.Path(name, "reader")
            shutil.copytree(small, folder, symlinks=True)
            report.run(where, examples, folder)
            shutil.rmtree(folder)
    for page in pages():
        for command in commands_of(page):
            if command.startswith("tools/") and text in (where := str(page.relative_to(ROOT))):
                report.add(where, command, functools.partial(fault_of_tool, command))
    rules = {part for rules in (NOT_RUN, CHANGED, MORE) for part in rules}
    report.failures += [f"a rule names '{part}', which no example has" for part in sorted(rules - report.needed)]
    print(f"{report.ran} examples, {len(report.failures)} failures", *report.failures, sep="\n")
    return 1 if report.failures or report.ran == 0 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))

# SPDX-License-Identifier: Apache-2.0
"""Each header of src and of lab/orthodrive compiles alone: `c++ -fsyntax-only` on it, with the folders of headers that
the build uses.

A header that another one includes first, before anything else, is proved by that one: it is read there as if alone.
One that passed is not read again before it or a header of ours that it includes changes: stamps lie in
build/release/headers.
"""

import concurrent.futures
import hashlib
import json
import re
import subprocess
import sys

from .common import ROOT, SkippedError

BUILD = ROOT / "build/release"
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)


def includes_of(text):
    return [(kind == '"', name) for kind, name in INCLUDE.findall(text)]


def to_compile(texts):
    """The headers that no other one proves; texts by name. Of those that include each other first in a ring, all."""
    first = {}
    for name, text in texts.items():
        found = includes_of(text)[:1]
        first[name] = found[0][1] if found and found[0][0] else None
    alone = sorted(set(texts) - set(first.values()))
    proved = set()
    for start in alone:
        name = start
        while name in texts and name not in proved:
            proved.add(name)
            name = first[name]
    return alone + sorted(set(texts) - proved)


def reaches(name, texts, seen):
    """All of ours that a header includes, itself too."""
    if name not in texts or name in seen:
        return seen
    seen.add(name)
    for _, other in includes_of(texts[name]):
        reaches(other, texts, seen)
    return seen


def flags_of(build):
    """The compiler and the union of its folders of headers and definitions, from the compile commands."""
    compiler, flags = "c++", []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = [w for w in entry["command"].split() if not w.endswith("ccache")]
        compiler = words[0]
        for i, word in enumerate(words):
            found = [word, words[i + 1]] if word == "-isystem" else [word] if word.startswith("-I") else []
            if found and found not in flags:
                flags.append(found)
    return [compiler, "-std=c++20", "-DFMT_SHARED", *(word for found in flags for word in found)]


def those_that_reach(changed, names, texts):
    """The headers that include one of `changed`, or are it; what includes the first of them comes first."""
    place = {name: i for i, name in reversed(list(enumerate(changed)))}
    first = {name: min((place[n] for n in reaches(name, texts, set()) if n in place), default=None) for name in names}
    return sorted((n for n in names if first[n] is not None), key=first.get)


def check(root, build, work):
    """What the compiler says of each header that does not compile alone."""
    bases, stamps = [root / "src", root / "lab"], build / "headers"
    stamps.mkdir(parents=True, exist_ok=True)
    texts = {
        str(p.relative_to(base)): p.read_text()
        for base in bases
        for p in base.rglob("*.h*")
        if p.suffix in (".hpp", ".h") and base / "app" not in p.parents
    }
    command = [*flags_of(build), *(f"-I{base}" for base in bases), "-fsyntax-only", "-x", "c++", "-"]

    def one(name):
        parts = sorted(reaches(name, texts, set()))
        key = hashlib.sha256(json.dumps([command, [(p, texts[p]) for p in parts]]).encode()).hexdigest()
        if (stamps / key).exists():
            return []
        run = subprocess.run(command, input=f'#include "{name}"\n', capture_output=True, text=True, check=False)
        if run.returncode == 0:
            (stamps / key).touch()
            return []
        return [f"{name} does not compile alone:", *run.stderr.splitlines()]

    names = those_that_reach(
        [n.removeprefix("src/").removeprefix("lab/") for n in work.headers], to_compile(texts), texts
    )
    left = len(names) - (work.most or len(names))
    if left > 0:
        print(f"lint: SKIPPED {left} headers that include changed ones (tools/lint --all)", file=sys.stderr)
    with concurrent.futures.ThreadPoolExecutor(work.jobs) as pool:
        return [line for said in pool.map(one, names[: work.most]) for line in said]


def check_headers(work):
    if not (BUILD / "compile_commands.json").exists():
        raise SkippedError("no build/release/compile_commands.json: tools/build writes it")
    return check(ROOT, BUILD, work)

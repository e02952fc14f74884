# SPDX-License-Identifier: Apache-2.0
"""Each header of src compiles alone: `c++ -fsyntax-only` on it, with the folders of headers that the build uses.

    check_headers.py ROOT BUILD

A header that another one includes first, before anything else, is proved by that one: it is read there as if alone.
One that passed is not read again before it or a header of ours that it includes changes: stamps lie in BUILD/headers.
"""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

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


def check(root, build):
    """What the compiler says of each header that does not compile alone."""
    src, stamps = root / "src", build / "headers"
    stamps.mkdir(parents=True, exist_ok=True)
    texts = {str(p.relative_to(src)): p.read_text() for p in src.rglob("*.h*") if p.suffix in (".hpp", ".h")}
    command = [*flags_of(build), "-I", str(src), "-fsyntax-only", "-x", "c++", "-"]

    def one(name):
        parts = sorted(reaches(name, texts, set()))
        key = hashlib.sha256(json.dumps([command, [(p, texts[p]) for p in parts]]).encode()).hexdigest()
        if (stamps / key).exists():
            return ""
        run = subprocess.run(command, input=f'#include "{name}"\n', capture_output=True, text=True, check=False)
        if run.returncode == 0:
            (stamps / key).touch()
            return ""
        return f"{name} does not compile alone:\n{run.stderr}"

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        names = to_compile(texts)
        faults = [said for said in pool.map(one, names) if said]
    print(f"headers: {len(texts)}, of which {len(names)} were asked alone; {len(faults)} faults")
    return faults


if __name__ == "__main__":
    found = check(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
    print("\n".join(found))
    sys.exit(1 if found else 0)

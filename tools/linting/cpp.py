# SPDX-License-Identifier: Apache-2.0
"""C and C++: clang-format 14 decides the layout; clang-tidy finds faults and counts lines of functions (.clang-tidy).

clang-tidy takes two to five seconds of a core for a file alone and a tenth more for each that the build compiles with
it, so it looks at those of one unity source in one go. What passed is not looked at again before a file of it, a header
of ours that it includes, its compile command or .clang-tidy changes: stamps lie in build/lint/passed.
"""

import concurrent.futures
import functools
import hashlib
import json
import os
import pathlib
import re
import subprocess

from .common import PEERS, ROOT, SkippedError, cpp_files, program

LINT = ROOT / "build/lint"
COMMANDS = ROOT / "build/release/compile_commands.json"
FOR_CLANG = ROOT / "tools/linting/for_clang.hpp"
INCLUDE_ROOTS = ["src", "lab", "tests", "app", "lab/app"]
# Of files that another build compiles (fuzzing, WebAssembly) or none.
LIBRARIES = "-isystem /usr/include/gdal -isystem /usr/include/eigen3"
INCLUDES = " ".join(f"-I{{root}}/{folder}" for folder in ["src", "lab", "app", "tests"])
PLAIN = f"c++ -std=c++20 -O3 -Wall -Wextra {INCLUDES} {LIBRARIES} -c {{file}}"
# CGAL's headers hold templates that clang refuses and nobody instantiates: it reads only what is instantiated.
FOR_CGAL = " -fdelayed-template-parsing"
# clang-tidy looks for this file beside what it is given, which may be a unity source.
NOT_OF_TESTS = re.findall(r"^  (-[a-z-]+)", (ROOT / "tests/.clang-tidy").read_text(), re.MULTILINE)
PLAIN_C = "cc -std=c11 -O3 -Wall -Wextra -I{root}/src -c {file}"


def check_cpp_layout(work):
    def one(part):
        command = [program("clang-format", "tools/setup installs it"), "--dry-run", "-Werror", *part]
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
        odd = re.findall(r"^([^:\s]+):\d+:\d+: error: code should be clang-formatted", run.stderr, re.MULTILINE)
        return [f"{name}: not as clang-format lays it out" for name in sorted(set(odd))]

    files = cpp_files(work.files)
    with concurrent.futures.ThreadPoolExecutor(work.jobs) as pool:
        return [
            line for found in pool.map(one, [files[i : i + 20] for i in range(0, len(files), 20)]) for line in found
        ]


def lay_out_cpp(work):
    files = cpp_files(work.files)
    if files:
        subprocess.run([program("clang-format", "tools/setup installs it"), "-i", *files], cwd=ROOT, check=True)


@functools.cache
def includes_of(name):
    """The files of ours that one includes, directly."""
    found = set()
    for quoted in re.findall(
        r'^\s*#\s*include\s*[<"]([^">]+)[">]', (ROOT / name).read_text(errors="replace"), re.MULTILINE
    ):
        for folder in [os.path.dirname(name), *INCLUDE_ROOTS]:
            path = os.path.normpath(os.path.join(folder, quoted))
            if (ROOT / path).is_file():
                found.add(path)
                break
    return found


@functools.cache
def all_includes_of(name):
    """The file and all of ours that it includes, however far off."""
    reached, open_ends = {name}, [name]
    while open_ends:
        for other in includes_of(open_ends.pop()) - reached:
            reached.add(other)
            open_ends.append(other)
    return reached


def sources_for(names, sources):
    """Where changed files are seen: a header in the source of its name, or in the first that includes it."""
    wanted = {}  # in the order of the changes
    for name in cpp_files(names):
        if name in sources:
            wanted[name] = True
        elif (own := str(pathlib.PurePath(name).with_suffix(".cpp"))) in sources:
            wanted[own] = True
        elif others := [s for s in sources if name in all_includes_of(s)]:
            wanted[others[0]] = True
    return list(wanted)


def for_clang(command):
    """g++'s command as clang takes it: without the compiler cache and precompiled headers."""
    command = re.sub(r"^\S*ccache ", "", command)
    command = re.sub(r" -include \S*cmake_pch\.hxx", "", command).replace(" -Winvalid-pch", "")
    return f"{command} -include {FOR_CLANG} -Wno-unknown-warning-option -Wno-unused-command-line-argument"


def known_commands():
    """Of every source that the build knows, its compile command and the unity source that includes it, or itself."""
    commands = {}
    for entry in json.loads(COMMANDS.read_text()):
        sources = [entry["file"]]
        if re.search(r"unity_\d+_c\w+\.c\w+$", entry["file"]) and os.path.exists(entry["file"]):
            sources = re.findall(r'^#include "([^"]+)"', pathlib.Path(entry["file"]).read_text(), re.MULTILINE)
        for source in sources:
            commands.setdefault(os.path.relpath(source, ROOT), (entry["command"], entry["file"]))
    return commands


def units_of(sources):
    """The sources that are looked at in one go, by the file that stands for them, with its compile command."""
    if not COMMANDS.exists():
        raise SkippedError("no build/release/compile_commands.json: tools/build writes it")
    known, together = known_commands(), {}
    for name in sources:
        plain = (PLAIN_C if name.endswith(".c") else PLAIN).format(root=ROOT, file=ROOT / name)
        command, unity = known.get(name, (plain, str(ROOT / name)))
        cgal = b"#include <CGAL/" in (ROOT / name).read_bytes()
        together.setdefault((command, unity, cgal), []).append(name)
    units = {}
    for (command, unity, cgal), names in together.items():
        file = ROOT / names[0]
        if len(names) > 1:
            file = LINT / "units" / f"{hashlib.sha256(unity.encode()).hexdigest()[:12]}_{int(cgal)}.cpp"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("".join(f'#include "{ROOT / name}"\n' for name in names))
        text = command.replace(unity, str(file))
        if not names[0].endswith(".c"):
            text = for_clang(text) + (FOR_CGAL if cgal else "")
        units[file] = (names, text)
    entries = [
        {"directory": str(COMMANDS.parent), "file": str(file), "command": text} for file, (_, text) in units.items()
    ]
    LINT.mkdir(parents=True, exist_ok=True)
    (LINT / "compile_commands.json").write_text(json.dumps(entries, indent=0))
    return units


def tidy(tool, file, names, before):
    """What clang-tidy says about sources; nothing when they passed, now or the last time."""
    reached = sorted(set().union(*map(all_includes_of, names)))
    contents = b"".join(n.encode() + (ROOT / n).read_bytes() for n in reached)
    stamp = LINT / "passed" / hashlib.sha256(before + contents).hexdigest()
    if stamp.exists():
        return []
    off = ["-bugprone-suspicious-include", *(NOT_OF_TESTS if names[0].startswith("tests/") else [])]
    command = [tool, "-p", LINT, "--quiet", f"--checks={','.join(off)}", file]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if run.returncode == 0:
        stamp.parent.mkdir(exist_ok=True)
        stamp.touch()
        return []
    return (run.stdout or run.stderr).splitlines()


def check_cpp(work):
    """clang-tidy 23: it leaves out what others' headers hold, and is four times as quick as Debian's 14 and 19."""
    sources = [n for n in cpp_files(work.tidy) if n.endswith((".cpp", ".c"))]
    if not sources:
        return []
    tool = program(PEERS / "clang-tidy", "tools/setup --peers installs it where pip finds a package index")
    units = units_of(sources)
    config = (ROOT / ".clang-tidy").read_bytes() + FOR_CLANG.read_bytes() + ",".join(NOT_OF_TESTS).encode()
    config += subprocess.run([tool, "--version"], capture_output=True, check=True).stdout
    with concurrent.futures.ThreadPoolExecutor(work.jobs) as pool:
        said = pool.map(lambda unit: tidy(tool, unit[0], unit[1][0], config + unit[1][1].encode()), units.items())
        return list(dict.fromkeys(line for lines in said for line in lines))

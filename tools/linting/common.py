# SPDX-License-Identifier: Apache-2.0
"""What the checks share: what is looked at, which files are of which language, how a program is run."""

import dataclasses
import functools
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PEERS = ROOT / "build/peers/lint/bin"  # the programs of tools/peers/lint.pip
LONGEST_FUNCTION = 60  # lines, in every language; biome.jsonc and .clang-tidy have it, too


class SkippedError(Exception):
    """A check that cannot run here; says what is missing."""


@dataclasses.dataclass
class Work:
    """What a run looks at."""

    files: list[str]  # the names of all files, relative to ROOT: quick checks look at them
    # What takes seconds a file: sources that clang-tidy is asked for; headers, and with them those that include them.
    tidy: list[str]
    headers: list[str]
    most: int | None  # headers; None is all
    jobs: int


def tracked():
    out = subprocess.run(["git", "-C", ROOT, "ls-files"], check=True, capture_output=True, text=True).stdout
    return [name for name in out.splitlines() if (ROOT / name).is_file()]


@functools.cache
def interpreter(name):
    """Of a script without an extension, what its first line names."""
    if "." in os.path.basename(name):
        return ""
    with open(ROOT / name, "rb") as file:
        first = file.readline(100)
    return first.decode(errors="replace").strip() if first.startswith(b"#!") else ""


def cpp_files(names):
    return [n for n in names if n.endswith((".cpp", ".hpp", ".h", ".inl", ".c"))]


def python_files(names):
    return [n for n in names if n.endswith(".py") or "python" in interpreter(n)]


def shell_files(names):
    return [n for n in names if n.endswith(".sh") or interpreter(n).endswith("sh")]


def web_files(names):
    return [n for n in names if n.endswith((".ts", ".mjs", ".js", ".css", ".jsonc"))]


def program(path, remedy):
    """The program, or SkippedError: a name is looked for in PATH."""
    found = subprocess.run(["which", path], capture_output=True, text=True, check=False).stdout.strip()
    if not found:
        raise SkippedError(f"no {path} here: {remedy}")
    return found


def lines_of(*command):
    """What a program that finds faults says, as lines; none when it ends with 0."""
    run = subprocess.run([str(word) for word in command], cwd=ROOT, capture_output=True, text=True, check=False)
    said = [line for line in (run.stdout + run.stderr).splitlines() if line.strip()]
    return (said or [f"{command[0]} ended with {run.returncode}"]) if run.returncode else []

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/versions.md says what the code says, and nothing else repeats the version of the project.

- Every row names a file and a text in it, and the text holds the row's versions.
- Every stage and every format with a number of its own has a row.
- The version stands in CMakeLists.txt, and besides only where a page is about releases.

Usage: check_versions.py ROOT. Prints one line a fault; exit code 1 if there is any.
"""

import re
import subprocess
import sys
from pathlib import Path

PAGE = "docs/versions.md"
MAY_SAY = {"CMakeLists.txt", PAGE, "CHANGELOG.md", "CITATION.cff"}  # the last two are checked below


def rows_of(text):
    """(what, [versions], file, text in it) of each row."""
    for line in text.split("\n"):
        found = re.fullmatch(r"\| (.+?) \| ([\d., ]+) \| `([^`]+)`: `([^`]+)` \|", line)
        if found:
            yield found[1], [v.strip() for v in found[2].split(",")], found[3], found[4]
        elif line.startswith("|") and not re.match(r"\| what \||\|[-|]+$", line):
            yield line, [], "", ""


def check_rows(root, rows, faults):
    for what, versions, file, said in rows:
        if not versions:
            faults.append(f"{PAGE}: no version, file and text in it: {what}")
        elif not (root / file).is_file() or said not in (root / file).read_text():
            faults.append(f"{PAGE}: {what}: {file} does not say {said}")
        for version in versions:
            if not re.search(rf"(?<![\d.]){re.escape(version)}(?![\d]|\.\d)", said):
                faults.append(f"{PAGE}: {what}: {said} is not {version}")


def check_complete(root, rows, faults):
    by_name = {what: versions for what, versions, _, _ in rows}
    files = {file for _, _, file, _ in rows}
    default = re.search(r"int version = (\d+);", (root / "src/orthodrive/pipeline/stages/build_stage.hpp").read_text())[
        1
    ]
    for file in sorted((root / "src/orthodrive/pipeline/stages").glob("run_*.cpp")):
        text = file.read_text()
        for name in re.findall(r'return \{\.name = "(\w+)",', text):
            version = re.search(r"\.version = (\d+)", text)
            if by_name.get(f"stage {name}") != [version[1] if version else default]:
                faults.append(f"{PAGE}: stage {name} has version {version[1] if version else default}")
    for file in sorted((root / "src").rglob("*.cpp")):
        name = file.relative_to(root).as_posix()
        if re.search(r"\bformat_version = ", file.read_text()) and name not in files:
            faults.append(f"{PAGE}: does not name the format of {name}")


def check_release(root, tracked, faults):
    def text_of(name):
        return (root / name).read_text()

    version = re.search(r"^project\(\w+ VERSION (\d+\.\d+\.\d+)", text_of("CMakeLists.txt"), re.MULTILINE)[1]
    changes = re.search(r"^## \[(\d+\.\d+\.\d+)\] - \d{4}-\d\d-\d\d$", text_of("CHANGELOG.md"), re.MULTILINE)
    if not changes or changes[1] != version:
        faults.append(f"CHANGELOG.md: its newest release is not {version}")
    if not re.search(rf"^version: {re.escape(version)}$", (root / "CITATION.cff").read_text(), re.MULTILINE):
        faults.append(f"CITATION.cff: its version is not {version}")
    for name in tracked:
        if (
            name in MAY_SAY
            or name.startswith(("docs/notes/", "docs/measured/", "bench/results/"))
            or name.endswith((".svg", ".jpg", ".png", "package-lock.json"))
        ):
            continue
        try:
            text = (root / name).read_text()
        except (UnicodeDecodeError, FileNotFoundError):
            continue
        if re.search(rf"(?<![\d.]){re.escape(version)}(?![\d.])", text):
            faults.append(f"{name}: repeats the version {version} of CMakeLists.txt")
    package = (root / "viewer/package.json").read_text()
    if re.search(r'^  "version"', package, re.MULTILINE):
        faults.append("viewer/package.json: has a version of its own")


def check(root, tracked):
    faults = []
    rows = list(rows_of((root / PAGE).read_text()))
    check_rows(root, rows, faults)
    check_complete(root, rows, faults)
    check_release(root, tracked, faults)
    return faults


if __name__ == "__main__":
    source = Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    listed = subprocess.run(["git", "-C", source, "ls-files"], capture_output=True, text=True, check=False)
    files = listed.stdout.split() or [
        p.relative_to(source).as_posix()
        for top in ("app", "cmake", "docs", "lab", "src", "tests", "tools", "viewer/src")
        for p in (source / top).rglob("*")
    ]
    found = check(source, files)
    print("\n".join(found))
    sys.exit(1 if found else 0)

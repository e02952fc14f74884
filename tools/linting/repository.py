# SPDX-License-Identifier: Apache-2.0
"""The repository: every source names its licence; subjects of commits are as CONTRIBUTING.md says; plain words."""

import re

from .common import ROOT, cpp_files, interpreter, lines_of, python_files, shell_files, web_files

ENDINGS = (".cmake", ".yml", "CMakeLists.txt", "Doxyfile")


def check_licence(work):
    """An SPDX line within the first five lines."""
    names = [*cpp_files(work.files), *python_files(work.files), *shell_files(work.files), *web_files(work.files)]
    names += [name for name in work.files if name.endswith(ENDINGS) or interpreter(name)]
    return [
        f"{name}: no SPDX-License-Identifier in its first five lines"
        for name in dict.fromkeys(names)
        if not names_licence(name)
    ]


def names_licence(name):
    return b"SPDX-License-Identifier: " in b"\n".join((ROOT / name).read_bytes().split(b"\n")[:5])


# docs/conventions.md, "Plain words": "one a node" is "one per node", and nobody is "of who".
THINGS = (
    "vertex|place|chain|node|path|road|point|pixel|class|stage|file|line|tile|cell|layer|way|level|row|side|channel"
    "|direction|segment|lane|edge|key|tag|value|photo|band"
)
PLAIN = re.compile(rf"\b(?:one|two|three|[0-9.]+) an? (?:{THINGS})\b|\b[Oo]f who\b")


def check_words(work):
    """Turns that readers stumble over, in comments, texts and pages."""
    own = {"docs/conventions.md", "tools/linting/repository.py"}
    names = [*cpp_files(work.files), *python_files(work.files), *(n for n in work.files if n.endswith(".md"))]
    return [
        f"{name}:{number}: '{found[0]}': docs/conventions.md, Plain words"
        for name in dict.fromkeys(names)
        if name not in own
        for number, line in enumerate((ROOT / name).read_text(errors="replace").split("\n"), 1)
        if (found := PLAIN.search(line))
    ]


def check_commit_subjects(work):
    return lines_of(ROOT / "tools/commit_subjects")

# SPDX-License-Identifier: Apache-2.0
"""The repository: every source names its licence; subjects of commits are as CONTRIBUTING.md says."""

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


def check_commit_subjects(work):
    return lines_of(ROOT / "tools/commit_subjects")

# SPDX-License-Identifier: Apache-2.0
"""What holds in the whole repository: the licence in every source, subjects of commits."""

from linting.common import ROOT, cpp_files, interpreter, lines_of, python_files, web_files

LICENCE = "SPDX-License-Identifier: Apache-2.0"


def check_licence(work):
    """Sources whose first lines do not name the licence."""
    builds = [n for n in work.files if n.endswith((".cmake", "CMakeLists.txt"))]
    scripts = [n for n in work.files if interpreter(n)]
    sources = {*cpp_files(work.files), *python_files(work.files), *web_files(work.files), *builds, *scripts}
    wanting = []
    for name in sorted(sources):
        with open(ROOT / name, encoding="utf-8") as file:
            if LICENCE not in file.read(200):
                wanting.append(f"{name}: its first lines lack '{LICENCE}'")
    return wanting


def check_commit_subjects(_work):
    return lines_of("tools/commit_subjects")

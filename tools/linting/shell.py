# SPDX-License-Identifier: Apache-2.0
"""Shell: shellcheck finds faults (.shellcheckrc), shfmt decides the layout; lines of functions are counted."""

import re

from .common import LONGEST_FUNCTION, ROOT, lines_of, program, shell_files

REMEDY = "tools/setup --peers installs it from Debian"
LAYOUT = ["-i", "2", "-ci"]


def check_shell(work):
    files = shell_files(work.files)
    return lines_of(program("shellcheck", REMEDY), "--format=gcc", *files) if files else []


def check_shell_layout(work):
    tool = program("shfmt", REMEDY)
    return [
        f"{name}: not as shfmt lays it out" for name in shell_files(work.files) if lines_of(tool, *LAYOUT, "-d", name)
    ]


def lay_out_shell(work):
    files = shell_files(work.files)
    if files:
        lines_of(program("shfmt", REMEDY), *LAYOUT, "-w", *files)


def check_shell_function_size(work):
    """Functions as shfmt lays them out, from `name() {` to a brace of the same depth; `# long: reason` excuses one."""
    found = []
    for name in shell_files(work.files):
        text = (ROOT / name).read_text()
        for function in re.finditer(r"^( *)(\w+)\(\) [{(](.*)\n(?:.*\n)*?\1[})]", text, re.MULTILINE):
            size = function[0].count("\n") + 1
            if size > LONGEST_FUNCTION and "# long: " not in function[3]:
                line = text.count("\n", 0, function.start()) + 1
                found.append(f"{name}:{line}: {function[2]} has {size} lines (most: {LONGEST_FUNCTION})")
    return found

# SPDX-License-Identifier: Apache-2.0
"""Python: ruff finds faults (ruff.toml) and decides the layout; no function is longer than the rule says."""

import ast

from .common import LONGEST_FUNCTION, PEERS, ROOT, lines_of, program, python_files


def ruff():
    return program(PEERS / "ruff", "tools/setup --peers installs it where pip finds a package index")


def check_python(work):
    files = python_files(work.files)
    return lines_of(ruff(), "check", "--quiet", "--output-format=concise", *files) if files else []


def check_python_layout(work):
    files = python_files(work.files)
    return lines_of(ruff(), "format", "--check", "--output-format=concise", *files) if files else []


def lay_out_python(work):
    """The imports in order, then all else."""
    files = python_files(work.files)
    if files:
        lines_of(ruff(), "check", "--quiet", "--select=I", "--fix", *files)
        lines_of(ruff(), "format", "--quiet", *files)


def check_python_function_size(work):
    """A longer function says why on its first line: `def f():  # long: reason`."""
    found = []
    for name in python_files(work.files):
        text = (ROOT / name).read_text()
        lines = text.splitlines()
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            size = node.end_lineno - node.lineno + 1
            if size > LONGEST_FUNCTION and "# long: " not in lines[node.lineno - 1]:
                found.append(f"{name}:{node.lineno}: {node.name}() has {size} lines (most: {LONGEST_FUNCTION})")
    return found

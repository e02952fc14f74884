# SPDX-License-Identifier: Apache-2.0
"""TypeScript, JavaScript, style sheets: biome finds faults, decides the layout, counts lines (biome.jsonc)."""

from .common import ROOT, lines_of, program, web_files

BIOME = ROOT / "viewer/node_modules/.bin/biome"


def biome():
    return program(BIOME, "tools/setup installs it with the packages of the viewer")


def check_web(work):
    files = web_files(work.files)
    words = ["check", "--error-on-warnings", "--reporter=github", "--max-diagnostics=200", "--no-errors-on-unmatched"]
    return lines_of(biome(), *words, *files) if files else []


def lay_out_web(work):
    files = web_files(work.files)
    if files:
        lines_of(biome(), "check", "--write", "--linter-enabled=false", "--no-errors-on-unmatched", *files)

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""run_examples.py finds the commands of a page, and what a line of tools/ names that does not exist."""

import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import run_examples  # noqa: E402

PAGE = """# A page with `orthodrive view`

    D=../data
    orthodrive synth -o site && build/release/orthodrive build site/site.toml -o out   # both
    orthodrive network --roads $D/roads.gpkg \\
        -o roads.xodr [--check]
    name = "a site file"

```
orthodrive version
```
"""


class RunExamplesTest(unittest.TestCase):
    def test_commands_are_read_as_a_reader_types_them(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder, "page.md")
            page.write_text(PAGE)
            self.assertEqual(
                list(run_examples.commands_of(page)),
                [
                    "orthodrive synth -o site",
                    "orthodrive build site/site.toml -o out",
                    "orthodrive network --roads ../data/roads.gpkg -o roads.xodr --check",
                    'name = "a site file"',
                    "orthodrive version",
                ],
            )

    def test_tools_sub_commands_and_options_must_exist(self):
        for command in ("tools/measure pictures --sites a=out", "tools/test --all", "tools/test -R scene.Kerbs"):
            self.assertIsNone(run_examples.fault_of_tool(command), command)
        for command, said in {
            "tools/nothing": "no program",
            "tools/measure nothing": "--help",
            "tools/measure pictures --nothing": "has no --nothing",
            "tools/sanitize --nothing": "has no --nothing",
        }.items():
            self.assertIn(said, run_examples.fault_of_tool(command) or "", command)


if __name__ == "__main__":
    unittest.main()

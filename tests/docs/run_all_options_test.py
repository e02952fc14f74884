#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""run_all_options.py finds an option that does nothing, one without a line and a line without an option."""

import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import run_all_options  # noqa: E402

TOOL = r"""#!/usr/bin/python3
import os, sys
words = dict(zip(sys.argv[2::2], sys.argv[3::2]))
if "--never" in words and "--size" not in words:
    sys.exit(print("tool: --never changes nothing without --size", file=sys.stderr) or 2)
text = words.get("--size", "") + (str(os.getpid()) if "--random" in words else "")
open(words["--output"], "w").write(text)
print("idle" if "--idle" in words else "", file=sys.stderr)
"""
HELP = """Options:
  -h,--help                   Print this help message and exit
  -o,--output TEXT REQUIRED   file
  --size INT=0                of it
  --idle INT                  does nothing
  --never INT                 of --size
"""
GOOD = """make: --output OUT/a
  --output OUT/b
  --size 4
  by-design --idle: it is so
  by-design --never: it is so
  refused --never 4
"""


class AllOptionsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.tool = pathlib.Path(self.folder.name, "tool")
        self.tool.write_text(TOOL)
        self.tool.chmod(0o755)

    def failures(self, table):
        runner = run_all_options.Runner(self.tool, pathlib.Path(self.folder.name))
        return run_all_options.failures_of(runner, "make", HELP, run_all_options.parse_table(table).get("make"))

    def assert_one(self, table, said):
        failures = self.failures(table)
        self.assertEqual(len(failures), 1, failures)
        self.assertIn(said, failures[0])

    def test_a_table_of_all_options_is_fine(self):
        self.assertEqual(self.failures(GOOD), [])

    def test_an_option_that_changes_nothing_is_found(self):
        self.assert_one(GOOD.replace("by-design --idle: it is so", "--idle 3"), "--idle 3: changes neither")

    def test_an_option_that_says_so_is_none(self):
        self.assertEqual(self.failures(GOOD.replace("by-design --idle: it is so", "tells idle: --idle 3")), [])
        self.assert_one(GOOD.replace("by-design --idle: it is so", "tells other: --idle 3"), "does not say 'other'")

    def test_an_option_without_a_line_is_found(self):
        self.assert_one(GOOD.replace("  --size 4\n", ""), "make --size: has no line")

    def test_a_line_without_an_option_is_found(self):
        self.assert_one(GOOD + "  by-design --gone: it is so\n", "make --gone: all_options.txt names it")

    def test_an_option_that_is_not_refused_is_found(self):
        self.assert_one(GOOD + "  refused --size 4\n", "--size 4: is not refused")

    def test_a_command_without_lines_is_found(self):
        self.assert_one("other:\n", "make: the table has no such command")

    def test_a_run_that_fails_is_no_change(self):
        self.assert_one(GOOD.replace("--size 4", "--size 4 (--output /nowhere/a)"), "exit code 1")

    def test_outputs_that_always_differ_prove_nothing(self):
        self.assert_one(GOOD.replace("OUT/a", "OUT/a --random 1"), "two runs differ")


if __name__ == "__main__":
    unittest.main()

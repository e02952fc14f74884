#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""tools/measure in a copy of what it reads and writes. Usage: measure_test.py SOURCE_TREE TOOL TEST_ELEVATE"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SOURCE, TOOL, TEST_ELEVATE = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]
COPIED = ["tools", "docs/measured", "docs/images", "bench/results", "models/truth"]


class Measure(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for part in COPIED:
            shutil.copytree(SOURCE / part, self.root / part)

    def measure(self, *words):
        run = subprocess.run([self.root / "tools/measure", *words], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return run.stdout

    def page(self, name):
        return (self.root / f"docs/measured/{name}.md").read_text()

    def test_every_sub_command_has_help(self):
        names = re.search(r"SUB-COMMAND\n(.*)\n\n?options|options:.*", self.measure("--help"), re.S)
        commands = re.findall(r"^    ([a-z-]+)  ", self.measure("--help"), re.M)
        self.assertGreaterEqual(len(commands), 12, names)
        for command in commands:
            self.assertIn("usage: tools/measure " + command, self.measure(command, "--help"))

    def test_pages_are_what_the_last_results_say(self):
        for words, page in ((["site", "--table"], "site"), (["refine", "--table"], "refine"), (["heights", "--table"], "elevate"), (["banking", "--table"], "banking"),
                            (["network", "--table"], "network"), (["fetch", "--table"], "fetch"), (["opendrive", "--table"], "network"), (["vehicle", "--table"], "vehicle"),
                            (["every-road", "--table"], "every_road"), (["scene", "--table"], "scene"), (["regions", "--table"], "regions"), (["second-eye", "--table"], "second_eye"), (["wide-roads", "--table"], "road_surface"), (["adapt", "--table"], "adapt"),
                            (["segment", "--table"], "segment"), (["networks", "write"], "segment"), (["scaling", "--table"], "scaling"), (["cluster", "--table"], "cluster"), (["faults", "--table"], "faults")):
            before = self.page(page)
            self.measure(*words)
            self.assertEqual(self.page(page), before, words)

    def test_a_page_without_marks_is_refused(self):
        (self.root / "docs/measured/network.md").write_text("no marks\n")
        run = subprocess.run([self.root / "tools/measure", "network", "--table"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertIn("the marks <!-- measured: network -->", run.stderr)

    def test_heights_of_the_village_end_to_end(self):
        site = self.root / "out/synth/village-99"
        subprocess.run([TOOL, "-q", "synth", "--seed", "99", "--size", "300", "--gsd", "0.5", "-o", site], check=True)
        said = self.measure("heights", "--tool", TOOL, "--only", "village")
        self.assertIn("village 10 m cubic default: E_RG", said)
        row = json.loads((self.root / "bench/results/heights.json").read_text())["rows"]["village 10 m cubic default"]
        self.assertEqual(row["commit"], "unknown")
        self.assertLess(row["truth"]["z_m"]["mean_abs"], 1.0)
        self.assertIn("(measured on ", self.page("elevate"))
        self.assertIn("unknown", self.page("elevate"))

    def test_drive_logs_end_to_end(self):
        self.measure("drive-logs", "--tests", TEST_ELEVATE)
        numbers = json.loads((self.root / "bench/results/drive_logs.json").read_text())
        self.assertGreater(len(numbers["lines"]["FuseDriveLogs"]), 5)
        self.assertIn(numbers["lines"]["FuseDriveLogs"][0], self.page("drive_logs"))


unittest.main(argv=sys.argv[:1])

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""tools/measure in a copy of what it reads and writes. Usage: measure_test.py SOURCE_TREE TOOL TEST_ELEVATE"""

import argparse
import contextlib
import importlib
import io
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

SOURCE, TOOL, TEST_ELEVATE = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3]
COPIED = ["tools", "docs", "bench/results", "models/truth", "models/classes", "src/orthodrive", "lab/orthodrive"]
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE / "tools"))
from measuring import all_pages, common  # noqa: E402 (its folder is named in the line above)


class Measure(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        for part in COPIED:
            shutil.copytree(SOURCE / part, self.root / part)

    def measure(self, *words):
        run = subprocess.run([self.root / "tools/measure", *words], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return run.stdout

    def page(self, name):
        return (self.root / f"docs/measured/{name}.md").read_text()

    def test_every_sub_command_has_help(self):
        names = re.search(r"SUB-COMMAND\n(.*)\n\n?options|options:.*", self.measure("--help"), re.DOTALL)
        commands = re.findall(r"^    ([a-z-]+)  ", self.measure("--help"), re.MULTILINE)
        self.assertGreaterEqual(len(commands), 12, names)
        for command in commands:
            self.assertIn("usage: tools/measure " + command, self.measure(command, "--help"))

    def test_pages_are_what_the_last_results_say(self):
        """Every page of docs/measured, by its sub-command."""
        tables = [
            (name, page)
            for part in all_pages.PARTS
            for name in {words[0] for words in part.commands}
            for page in part.pages.split()
        ]
        self.assertEqual(
            {page for _, page in tables}, {file.stem for file in (self.root / "docs/measured").glob("*.md")}
        )
        for name, page in tables:
            before = self.page(page)
            self.measure(name, "--table")
            self.assertEqual(self.page(page), before, name)
        for page, words in {"notes/networks.md": ["networks", "write"], "reference.md": ["reference"]}.items():
            before = (self.root / "docs" / page).read_text()
            self.measure(*words)
            self.assertEqual((self.root / "docs" / page).read_text(), before, f"run tools/measure {' '.join(words)}")

    def test_numbers_of_the_reference_follow_results_and_code(self):
        file = self.root / "bench/results/nlo.json"
        runs = json.loads(file.read_text())
        runs["runs"]["village, set 1, 1 x 20"]["surface_iou"] = 0.12345
        for name in list(runs["runs"]):
            if name.endswith(", set 2, 2 x 20"):
                del runs["runs"][name]
        file.write_text(json.dumps(runs))
        found = {"accuracy": 0.81, "mean_iou": 0.56, "merged": [0.9, 0.7], "seconds_a_tile": 0.05, "commit": "x"}
        found["iou"] = {"road": 0.8, "pool": 0.2, "snow": None}
        trained = {
            f"{n}, {crf}, circuit-99": found for n in ("googlenet-32s", "vgg16-8s") for crf in ("none", "thesis")
        }
        (self.root / "bench/results/reference_38.json").write_text(json.dumps(trained))
        self.measure("reference")
        page = (self.root / "docs/reference.md").read_text()
        for line in (
            "| googlenet-32s | 83.02; 0.169; 0.476; 100000 | 81.00 / -; 0.050; not measured |",
            "| googlenet-16s | 86.04; 0.157; 0.335; 50000 | not measured |",
            "| VGG16-8s: mean IoU % | 64.66 | 56.00 / - |",
            "38 classes merged to 32: accuracy %; mean IoU % | 92.16; 73.60 | 90.00; 70.00 / - |",
            "| VGG16-8s: classes with an IoU of 75 % and more | about half of 38 | 1 of 2 / - |",
            "| 5.20, 13.50, 11.00, 1.50, 1.75; 90.51 | 5.2, 13.5, 11.0, 1.5, 1.75; 81.00 / - |",
        ):
            self.assertIn(line, page)
        self.assertRegex(page, r"\| set 1, 1 x 20: IoU % \| 80.09 \| 12.3[45] / ")
        self.assertIn("| set 2, 2 x 20: IoU % | 66.38 | not measured |", page)
        (self.root / "src/orthodrive/scene/plan/tile_address.hpp").write_text("constexpr double tile_m = 480.0;\n")
        run = subprocess.run([self.root / "tools/measure", "reference"], capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 1)
        self.assertIn("tile_address.hpp: 0 places of scene_tile_m", run.stderr)

    def test_a_page_without_marks_is_refused(self):
        (self.root / "docs/measured/network.md").write_text("no marks\n")
        run = subprocess.run(
            [self.root / "tools/measure", "network", "--table"], capture_output=True, text=True, check=False
        )
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
        self.assertIn("\nMeasured on commit unknown.\n", self.page("elevate"))

    def test_drive_logs_end_to_end(self):
        self.measure("drive-logs", "--tests", TEST_ELEVATE)
        numbers = json.loads((self.root / "bench/results/drive_logs.json").read_text())
        self.assertGreater(len(numbers["lines"]["FuseDriveLogs"]), 5)
        self.assertIn(numbers["lines"]["FuseDriveLogs"][0], self.page("drive_logs"))


PAGE_OF_TWO = "c.md"
FAKE_TEST = """#!/usr/bin/python3
import json, sys
report = next(word.split(":", 1)[1] for word in sys.argv if word.startswith("--gtest_output"))
suite = {"name": "FuseDriveLogs", "testsuite": [{"measured_1": "a drive of this test"}]}
json.dump({"testsuites": [suite]}, open(report, "w"))
"""


class All(unittest.TestCase):
    """`tools/measure all` with parts that measure nothing."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.pages, self.state, self.ran, self.codes = pathlib.Path(folder.name), {}, [], {}
        self.parts = [
            all_pages.Part("one", "a b", 1, [["one"]]),
            all_pages.Part("two", "c", 2, [["two", "--x"], ["more"]]),
        ]
        self.stamps = {"one": "aaaaaaa", "two": "aaaaaaa"}

    def execute(self, words):
        self.ran.append(words[0])
        for part in self.parts:
            if words in part.commands:
                for page in part.pages.split():
                    (self.pages / f"{page}.md").write_text(
                        "# Page\n\n" + "".join(f"Measured on commit {c}.\n" for c in self.stamps[part.name].split(","))
                    )
        return self.codes.get(words[0], 0)

    def run_all(self, on="aaaaaaa"):
        self.ran.clear()
        with contextlib.redirect_stdout(io.StringIO()) as said:
            failed = all_pages.measure_all(
                self.parts, on, self.execute, lambda: dict(self.state), self.state.update, self.pages
            )
        self.said = said.getvalue()
        return failed

    def test_all_parts_run_once_a_commit(self):
        self.assertEqual(self.run_all(), [])
        self.assertEqual(self.ran, ["one", "two", "more"])
        self.assertRegex(self.said, r"(?m)^one: \d+\.\d min$")
        self.assertRegex(self.said, r"(?m)^all: .* min for what is measured on aaaaaaa$")
        self.assertEqual(self.run_all(), [])
        self.assertEqual(self.ran, [])
        self.assertIn("one: done on aaaaaaa before", self.said)

    def test_another_commit_is_measured_anew(self):
        self.run_all()
        self.stamps = dict.fromkeys(self.stamps, "bbbbbbb")
        self.assertEqual(self.run_all("bbbbbbb"), [])
        self.assertEqual(self.ran, ["one", "two", "more"])

    def test_it_goes_on_where_it_failed(self):
        self.codes = {"one": 3}
        self.assertEqual(self.run_all(), ["one: `tools/measure one` ended with 3"])
        self.assertEqual(self.ran, ["one", "two", "more"])
        self.codes = {}
        self.assertEqual(self.run_all(), [])
        self.assertEqual(self.ran, ["one"])

    def test_a_page_of_two_commits_is_not_done(self):
        self.stamps["two"] = "aaaaaaa,bbbbbbb"
        self.assertEqual(
            self.run_all(), [f"two: docs/measured/{PAGE_OF_TWO} was measured on aaaaaaa, bbbbbbb, not on aaaaaaa alone"]
        )
        self.assertNotIn("two", self.state)

    def test_a_part_in_a_checkout(self):
        """The command itself, with programs that do nothing: stamps, what is kept for the next call, refusals."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for part in ("tools", "docs/measured", "bench/results"):
                shutil.copytree(SOURCE / part, root / part)
            (root / ".gitignore").write_text("/build/\n/out/\n__pycache__/\n")
            (root / "tools/build").write_text("#!/bin/sh\nmkdir -p build && echo built >>build/log\n")
            program = root / "build/release/tests/elevate/test_elevate"
            program.parent.mkdir(parents=True)
            program.write_text(FAKE_TEST)
            program.chmod(0o755)
            (root / "out/lap").mkdir(parents=True)

            def run(*words, **options):
                return subprocess.run(
                    list(map(str, words)),
                    cwd=root,
                    capture_output=True,
                    text=True,
                    check=options.pop("check", False),
                    **options,
                )

            def git(*words):
                return run("git", "-c", "user.name=a", "-c", "user.email=a@b", *words, check=True).stdout.strip()

            git("init"), git("add", "."), git("commit", "-m", "Begin")
            commit = git("rev-parse", "--short", "HEAD")
            first = run(root / "tools/measure", "all", "--only", "drive-logs")
            self.assertEqual(first.returncode, 0, first.stdout + first.stderr)
            page = (root / "docs/measured/drive_logs.md").read_text()
            self.assertEqual(common.STAMP.findall(page), [commit])
            self.assertIn("    a drive of this test", page)
            self.assertEqual(
                json.loads((root / "bench/results/measured.json").read_text())["drive-logs"]["commit"], commit
            )
            self.assertFalse((root / "out/lap").exists(), "what another commit made")
            again = run(root / "tools/measure", "all", "--only", "drive-logs")
            self.assertIn(f"drive-logs: done on {commit} before", again.stdout)
            self.assertEqual((root / "build/log").read_text(), "built\n")
            self.assertIn(commit, run(root / "tools/measure", "all", "--list").stdout)

            unknown = run(root / "tools/measure", "all", "--only", "gone")
            self.assertEqual(unknown.returncode, 1)
            self.assertIn("no part gone; there are synth,", unknown.stderr)
            (root / "tools/build").write_text("#!/bin/sh\n")
            dirty = run(root / "tools/measure", "all", "--only", "drive-logs")
            self.assertEqual(dirty.returncode, 1)
            self.assertIn(f"the commit is {commit} + changes; commit first, or give --dirty", dirty.stderr)

    def test_the_commands_of_all_parts_are_understood(self):
        modules = dict(re.findall(r'"([\w-]+)": "([\w.]+)"', (SOURCE / "tools/measure").read_text()))
        for words in [words for part in all_pages.PARTS for words in part.commands]:
            parser = argparse.ArgumentParser(exit_on_error=False)
            importlib.import_module(f"measuring.{modules[words[0]]}").add_arguments(parser)
            parser.parse_args(list(map(str, words[1:])))

    def test_commits_of_results(self):
        self.assertEqual(
            common.commits_of({"a": {"commit": "x"}, "b": [{"commit": "y"}, {"commits": {"p": "x", "q": "z"}}]}),
            ["x", "y", "z"],
        )

    def test_a_stamp_is_replaced(self):
        with mock.patch.object(common, "read_results", lambda store, otherwise: {"commit": store}):
            once = common.stamped("# Title\n\nText\n", ["x"])
            self.assertEqual(once, "# Title\n\nMeasured on commit x.\n\nText\n")
            self.assertEqual(
                common.stamped(once, ["y", "z"]), "# Title\n\nMeasured on commit y.\nMeasured on commit z.\n\nText\n"
            )


unittest.main(argv=sys.argv[:1])

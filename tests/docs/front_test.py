#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_versions.py, tools/commit_subjects and tools/rooms find the fault that each is for, and none without it."""

import importlib.machinery
import importlib.util
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import check_versions

TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.dont_write_bytecode = True


def script(name):
    loader = importlib.machinery.SourceFileLoader(name, str(TOOLS / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


class Versions(unittest.TestCase):
    FILES = {
        "CMakeLists.txt": "project(orthodrive VERSION 1.2.3 LANGUAGES CXX)\n",
        "CHANGELOG.md": "## [Unreleased]\n\n## [1.2.3] - 2026-01-02\n\n## [1.2.2] - 2026-01-01\n",
        "CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.3\n",
        "viewer/package.json": '{\n  "private": true\n}\n',
        "src/orthodrive/pipeline/stages/build_stage.hpp": "int version = 1;\n",
        "src/orthodrive/pipeline/stages/run_scene.cpp": 'return {.name = "scene",\n .version = 7,\n',
        "src/orthodrive/pipeline/stages/run_drive.cpp": 'return {.name = "drive",\n .sources = {}\n',
        "src/orthodrive/pipeline/packed.cpp": 'format_version = "4";\n',
        "README.md": "",
        check_versions.PAGE: "| what | version | where |\n|---|---|---|\n"
        "| Orthodrive | 1.2.3 | `CMakeLists.txt`: `project(orthodrive VERSION 1.2.3` |\n"
        "| stage scene | 7 | `src/orthodrive/pipeline/stages/run_scene.cpp`: `.version = 7,` |\n"
        "| stage drive | 1 | `src/orthodrive/pipeline/stages/build_stage.hpp`: `int version = 1;` |\n"
        '| packed | 4 | `src/orthodrive/pipeline/packed.cpp`: `format_version = "4";` |\n',
    }

    def faults(self, **changes):
        with tempfile.TemporaryDirectory() as folder:
            files = {**self.FILES, **changes}
            for name, text in files.items():
                (Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
                (Path(folder) / name).write_text(text)
            return check_versions.check(Path(folder), list(files))

    def finds(self, what, name, old, new):
        found = self.faults(**{name: self.FILES[name].replace(old, new)})
        self.assertTrue(any(what in fault for fault in found), found)

    def test_nothing_wrong(self):
        self.assertEqual(self.faults(), [])

    def test_the_release_stands_in_one_place(self):
        self.finds("CHANGELOG.md: its newest release is not 1.2.3", "CHANGELOG.md", "1.2.3", "1.2.4")
        self.finds("CITATION.cff: its version is not 1.2.3", "CITATION.cff", "version: 1.2.3", "version: 1.2")
        self.finds("README.md: repeats the version", "README.md", "", "This is 1.2.3 and")
        self.finds(
            "has a version of its own", "viewer/package.json", '  "private"', '  "version": "9.9.9",\n  "private"'
        )

    def test_rows_say_what_the_code_says(self):
        page = check_versions.PAGE
        self.finds(
            "does not say .version = 7,",
            "src/orthodrive/pipeline/stages/run_scene.cpp",
            ".version = 7,",
            ".version = 8,",
        )
        self.finds(
            "stage scene has version 8",
            "src/orthodrive/pipeline/stages/run_scene.cpp",
            ".version = 7,",
            ".version = 8,",
        )
        self.finds(".version = 7, is not 6", page, "| stage scene | 7 ", "| stage scene | 6 ")
        self.finds("no version, file and text", page, "| packed | 4 | `", "| packed | four | `")
        self.finds("stage drive has version 1", page, "stage drive", "stage derive")
        self.finds("does not name the format of src/orthodrive/pipeline/packed.cpp", page, "packed.cpp", "gone.cpp")


class CommitSubjects(unittest.TestCase):
    def test_subjects(self):
        faults = script("commit_subjects").faults_of
        for good in (
            "Keep a metre between carriageways",
            "Pass words on",
            "Bring the map",
            "Feed it",
            "Focus on roads",
            "Access it",
            "x" * 0 + "A" * 72,
        ):
            self.assertEqual(faults(good), [], good)
        for bad, why in (
            ("A" * 73, "73 characters"),
            ("keep it", "capital"),
            ("Keep it.", "full stop"),
            ("Keeps it", "no imperative"),
            ("Added it", "no imperative"),
            ("Adding it", "no imperative"),
        ):
            self.assertIn(why, " ".join(faults(bad)), bad)

    def test_only_commits_behind_the_script_are_asked(self):
        with tempfile.TemporaryDirectory() as folder:

            def git(*words):
                return subprocess.run(
                    ["git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@b", *words],
                    check=True,
                    capture_output=True,
                )

            git("init")
            git("commit", "--allow-empty", "-m", "added long ago.")
            (Path(folder) / "tools").mkdir()
            (Path(folder) / "tools/commit_subjects").write_text("")
            git("add", "."), git("commit", "-m", "bring the script.")
            git("commit", "--allow-empty", "-m", "Keep it")
            self.assertEqual([subject for _, subject in script("commit_subjects").commits(Path(folder))], ["Keep it"])


class Rooms(unittest.TestCase):
    def test_arrows_that_follow_are_left_out_and_changes_are_seen(self):
        rooms = script("rooms")
        arrows = {"core": set(), "geo": {"core"}, "model": {"geo", "core"}}
        self.assertEqual(rooms.without_shortcuts(arrows), {"core": [], "geo": ["core"], "model": ["geo"]})
        self.assertIn("model -> geo;", rooms.graph(arrows))
        self.assertNotEqual(rooms.mark(rooms.graph(arrows)), rooms.mark(rooms.graph({**arrows, "model": {"core"}})))


if __name__ == "__main__":
    unittest.main()

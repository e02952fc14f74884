# SPDX-License-Identifier: Apache-2.0
"""tools/lint finds a header that needs another one before it, and asks each that no other one proves."""

import json
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "tools"))
from linting import headers
from linting.common import Work


class CheckHeaders(unittest.TestCase):
    def check(self, files, changed=None, most=None):
        """The headers that have faults."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                (root / "src/room").mkdir(parents=True, exist_ok=True)
                (root / "src/room" / name).write_text("#pragma once\n" + text)
            (root / "compile_commands.json").write_text(json.dumps([{"command": "/usr/bin/ccache c++ -c a.cpp"}]))
            work = Work([], [], [f"src/room/{name}" for name in changed or files], most, 2)
            said = headers.check(root, root, work)
            return [line.split(" ")[0] for line in said if line.endswith(" does not compile alone:")]

    def test_a_header_alone(self):
        self.assertEqual(self.check({"a.hpp": "#include <vector>\nstd::vector<int> a();\n"}), [])

    def test_a_header_that_lacks_an_include(self):
        self.assertEqual(
            self.check({"a.hpp": "std::vector<int> a();\n", "b.hpp": '#include <vector>\n#include "room/a.hpp"\n'}),
            ["room/a.hpp"],
        )

    def test_a_fault_in_a_header_that_another_one_includes_first(self):
        self.assertEqual(
            self.check({"a.hpp": "std::vector<int> a();\n", "b.hpp": '#include "room/a.hpp"\n#include <vector>\n'}),
            ["room/b.hpp"],
        )

    def test_what_includes_a_changed_header_is_asked_too(self):
        files = {
            "a.hpp": "",
            "b.hpp": '#include <vector>\n#include "room/a.hpp"\nstd::string b();\n',
            "c.hpp": "std::string c();\n",
        }
        self.assertEqual(self.check(files, ["a.hpp"]), ["room/b.hpp"])
        self.assertEqual(self.check(files, ["c.hpp"]), ["room/c.hpp"])
        self.assertEqual(self.check(files, ["c.hpp", "a.hpp"], most=1), ["room/c.hpp"])

    def test_what_proves_what(self):
        texts = {"a": "", "b": '#include "a"\n', "c": '#include <x>\n#include "b"\n', "d": '#include "b"\n'}
        self.assertEqual(headers.to_compile(texts), ["c", "d"])
        ring = {"a": '#include "b"\n', "b": '#include "a"\n'}
        self.assertEqual(headers.to_compile(ring), ["a", "b"])


if __name__ == "__main__":
    unittest.main()

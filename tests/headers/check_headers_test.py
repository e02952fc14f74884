# SPDX-License-Identifier: Apache-2.0
"""check_headers.py finds a header that needs another one before it, and asks each that no other one proves."""

import json
import pathlib
import tempfile
import unittest

import check_headers


class CheckHeaders(unittest.TestCase):
    def check(self, files):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in files.items():
                (root / "src/room").mkdir(parents=True, exist_ok=True)
                (root / "src/room" / name).write_text("#pragma once\n" + text)
            (root / "compile_commands.json").write_text(json.dumps([{"command": "/usr/bin/ccache c++ -c a.cpp"}]))
            return [said.split(" ")[0] for said in check_headers.check(root, root)]

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

    def test_what_proves_what(self):
        texts = {"a": "", "b": '#include "a"\n', "c": '#include <x>\n#include "b"\n', "d": '#include "b"\n'}
        self.assertEqual(check_headers.to_compile(texts), ["c", "d"])
        ring = {"a": '#include "b"\n', "b": '#include "a"\n'}
        self.assertEqual(check_headers.to_compile(ring), ["a", "b"])


if __name__ == "__main__":
    unittest.main()

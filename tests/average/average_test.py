# SPDX-License-Identifier: Apache-2.0
"""tools/average on small model files made in place."""

import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

try:
    import numpy
except ImportError:
    sys.exit(77)

ROOT = pathlib.Path(sys.argv.pop(1))
TYPES = {"F16": "<f2", "F32": "<f4"}


def model(values, network="small"):
    header, data = {"__metadata__": {"architecture": network, "step": "7"}}, b""
    for name, (kind, numbers) in values.items():
        part = numpy.array(numbers, TYPES[kind]).tobytes()
        header[name] = {"dtype": kind, "shape": [len(numbers)], "data_offsets": [len(data), len(data) + len(part)]}
        data += part
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data


def values_of(file):
    data = file.read_bytes()
    size = struct.unpack_from("<Q", data)[0]
    header = json.loads(data[8 : 8 + size])
    return header.pop("__metadata__"), {
        name: (
            e["dtype"],
            numpy.frombuffer(data[8 + size :][e["data_offsets"][0] : e["data_offsets"][1]], TYPES[e["dtype"]]).tolist(),
        )
        for name, e in header.items()
    }


class Average(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = pathlib.Path(self.folder.name)
        (self.path / "a").write_bytes(model({"k": ("F16", [1.0, 2.0]), "b": ("F32", [0.5]), "crf/w": ("F32", [3.0])}))
        (self.path / "b").write_bytes(model({"k": ("F16", [5.0, -2.0]), "b": ("F32", [1.5])}))
        (self.path / "other").write_bytes(model({"k": ("F16", [5.0, -2.0])}, "large"))
        (self.path / "long").write_bytes(model({"k": ("F16", [5.0, -2.0, 1.0])}))
        (self.path / "broken").write_bytes(b"no model")

    def average(self, *models):
        return subprocess.run(
            [ROOT / "tools/average", *models, "-o", "out"], cwd=self.path, capture_output=True, text=True, check=False
        )

    def test_weighted_mean_keeps_types_metadata_and_what_only_the_first_has(self):
        self.assertEqual(self.average("a=1", "b=3").returncode, 0)
        metadata, tensors = values_of(self.path / "out")
        self.assertEqual(metadata["step"], "7")
        self.assertEqual(tensors, {"k": ("F16", [4.0, -1.0]), "b": ("F32", [1.25]), "crf/w": ("F32", [3.0])})

    def test_all_of_one_is_that_one(self):
        self.average("a=1", "b=0")
        self.assertEqual(values_of(self.path / "out"), values_of(self.path / "a"))

    def test_bad_input_ends_with_one_line(self):
        for models, says in [
            (["a=1", "other=1"], "other: is of another network"),
            (["a=1", "long=1"], "'k' is missing or of another shape"),
            (["a=1", "broken=1"], "broken: is no safetensors"),
            (["b=1", "a=1"], "'crf/w' is missing"),
        ]:
            result = self.average(*models)
            self.assertEqual((result.returncode, len(result.stderr.splitlines())), (1, 1), result.stderr)
            self.assertIn(says, result.stderr)
            self.assertFalse((self.path / "out").exists())
        for models in (["a"], ["a=-1"], ["a=0", "b=0"], ["a=x"]):
            self.assertEqual(self.average(*models).returncode, 2)


unittest.main()

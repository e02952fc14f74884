#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""sites/ring.toml: what `orthodrive new` says of the place today; and one command builds it, with servers on loopback
in place of the real ones. Usage: ring_test.py TOOL SOURCE_TREE
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest

import served_site

TOOL, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
TRACK = SOURCE.parent / "shared/data/spielberg"


def run(*words):
    return subprocess.run([TOOL, *map(str, words)], capture_output=True, text=True, check=False)


class Ring(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.file = SOURCE / "sites/ring.toml"
        self.site = tomllib.loads(self.file.read_text())

    def test_it_is_what_new_writes_for_its_area(self):
        bbox = self.site["area"]["bbox_wgs84"]
        made = run("new", "--bbox", ",".join(map(str, bbox)), "-o", self.root / "ring.toml")
        self.assertEqual(made.returncode, 0, made.stderr)
        written = tomllib.loads((self.root / "ring.toml").read_text().replace('"sources/', '"ring/'))
        self.assertEqual({**self.site, "name": "ring"}, written)
        self.assertIn("CRS: EPSG:32633, 20.19 km2", (self.root / "ring.toml").read_text())

    def test_one_command_fetches_and_builds_it(self):
        """In the middle of the area, from servers that give the synthetic ring."""
        if not TRACK.exists():
            self.skipTest(f"{TRACK} is not there")
        made = run(
            "synth",
            *("--from-track", TRACK / "spielberg_utm33.csv", "--track-osm", TRACK / "osm_way_red_bull_ring.osm"),
            *("--track-heights", TRACK / "elevation_zaggyai.csv", "--gsd", "0.8", "-o", self.root / "synthetic"),
        )
        self.assertEqual(made.returncode, 0, made.stderr)
        running, text = served_site.serve(self.file, self.root / "synthetic", finest_zoom=17)
        for server in running:
            self.addCleanup(server.close)
        self.assertNotIn("https://", "".join(line for line in text.splitlines() if line.startswith("url")))
        whole, middle = "[14.732, 47.203, 14.792, 47.243]", "[14.752, 47.2165, 14.773, 47.2285]"
        self.assertIn(whole, text)
        (self.root / "ring.toml").write_text(text.replace(whole, middle))
        built = run("-q", "build", self.root / "ring.toml", "-o", self.root / "out")
        self.assertEqual(built.returncode, 0, built.stderr)
        record = json.loads((self.root / "ring/photo.mbtiles.source.json").read_text())
        self.assertEqual((record["zoom"], record["licence"], record["missing_tiles"]), ("17", "CC BY 4.0", 0))
        stages = json.loads((self.root / "out/run.json").read_text())["stages"]
        numbers = {name: value for stage in stages for name, value in stage.get("numbers", {}).items()}
        self.assertEqual((numbers["route"], numbers["closed"], numbers["off_road_share"]), ("Red Bull Ring", True, 0.0))
        self.assertTrue(numbers["verdict"]["pass"])
        self.assertAlmostEqual(numbers["surface_km"]["asphalt"], 4.318, delta=0.02)
        self.assertTrue(90 < numbers["lap_time_s"] < 115, numbers["lap_time_s"])
        self.assertTrue((self.root / "out/scene/tileset.json").exists())
        self.assertIn("Orthophoto: basemap.at, CC BY 4.0", (self.root / "out/report.html").read_text())
        again = run("build", self.root / "ring.toml", "-o", self.root / "out")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertNotIn("fetch", again.stderr)


unittest.main(argv=sys.argv[:1])

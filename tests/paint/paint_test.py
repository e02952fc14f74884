#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""tools/paint on a photo made in place. Usage: paint_test.py SOURCE_TREE. Exit code 77: Pillow or SciPy is missing."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv[1])
try:
    import numpy
    import scipy  # noqa: F401
    from PIL import Image
except ImportError as missing:
    print(f"skipped: {missing}")
    sys.exit(77)
sys.path.insert(0, str(SOURCE / "tools"))
sys.dont_write_bytecode = True
from painting import pieces, quilt, sheet, snap  # noqa: E402

GSD = 0.5
# A roof from 20.0 to 60.0 m in x and 30.0 to 50.0 m in y, green to the left of x = 80 m and grey to the right, in the
# piece whose corner is at 10, 20 m.
SHEET = """piece a photo 10 20
grow grass 10,10 10,90 70,50 40,70 | ground 95,10 90,90 92,50
building 20.6,30.6 60.7,30.6 60.7,49.5 20.6,49.5
piece b photo 10 20 held_out
unknown~ 0,0 100,0 100,100 0,100
road~ 0,40 100,40 100,45 0,45
box building~ 20,30 60,30 60,50
"""


class Paint(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        y, x = numpy.mgrid[0:300, 0:260] * GSD + GSD / 2
        photo = numpy.where((x - 10 < 80)[:, :, None], (70, 120, 60), (150, 150, 150))
        photo = numpy.where(((x >= 30) & (x < 70) & (y >= 50) & (y < 70))[:, :, None], (200, 60, 50), photo)
        noise = numpy.random.default_rng(1).normal(0, 3, photo.shape)
        Image.fromarray(numpy.clip(photo + noise, 0, 255).astype(numpy.uint8)).save(self.root / "photo.png")
        (self.root / "sheet.txt").write_text(SHEET)

    def paint(self, *words, code=0):
        run = subprocess.run(
            [sys.executable, SOURCE / "tools/paint", *words], capture_output=True, text=True, cwd=self.root, check=False
        )
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        return run.stdout + run.stderr

    def painted(self, name="painted.geojson", text=SHEET):
        (self.root / "sheet.txt").write_text(text)
        self.paint("write", "sheet.txt", ".", "--gsd", str(GSD), "-o", name)
        return pieces.read_geojson(self.root / name, None)[0]

    def test_textures_are_as_bright_as_their_surroundings_and_go_on_at_their_edges(self):
        self.painted()
        self.paint("render", "painted.geojson", ".", "-o", "rendered")
        self.paint("quilt", "rendered", "--gsd", str(GSD), "--patches", "60", "-o", "textures")
        self.assertEqual((self.root / "textures/textures.toml").read_text(), f"gsd_m = {GSD}\n")
        self.assertFalse((self.root / "textures/water.png").exists(), "nothing is water")
        tile = numpy.asarray(Image.open(self.root / "textures/grass.png")).astype(float)
        self.assertEqual(tile.shape[0], tile.shape[1])
        self.assertAlmostEqual(tile.mean(), 128.0, delta=1.0)
        self.assertGreater(tile.std(), 2.0)
        inside = numpy.abs(numpy.diff(tile, axis=1)).mean()
        self.assertLess(numpy.abs(tile[:, 0] - tile[:, -1]).mean(), 1.5 * inside)
        self.assertLess(numpy.abs(tile[0] - tile[-1]).mean(), 1.5 * inside)
        self.assertIn("tools/paint render first", self.paint("quilt", "nowhere", "-o", "textures", code=1))

    def test_a_cut_takes_the_cheapest_way(self):
        error = numpy.ones((6, 5))
        for row, col in enumerate([1, 2, 3, 2, 1, 0]):
            error[row, col] = 0.0
        self.assertEqual(quilt.cut(error).tolist(), [1, 2, 3, 2, 1, 0])

    def test_a_drawn_roof_moves_to_its_edges(self):
        label, ring = self.painted()["a"].coats[-1]
        self.assertEqual(label, "building")
        for (x, y), truth in zip(ring, [(30, 50), (70, 50), (70, 70), (30, 70)], strict=True):
            self.assertLess(numpy.hypot(x * GSD - truth[0], y * GSD - truth[1]), 0.3)

    def test_a_tilde_leaves_a_shape_where_it_was_drawn(self):
        self.assertEqual(
            self.painted()["b"].coats[-1][1], [(60.0, 100.0), (140.0, 100.0), (140.0, 140.0), (60.0, 140.0)]
        )

    def test_seeds_grow_to_the_border_of_what_they_look_like(self):
        labels = self.painted()["a"].labels()
        grass, ground = sheet.CLASSES.index("grass"), sheet.CLASSES.index("ground")
        self.assertGreater((labels[:, :156] == grass).mean(), 0.89)  # the rest is the roof
        self.assertGreater((labels[:, 164:] == ground).mean(), 0.99)

    def test_later_coats_cover_earlier_ones_and_nothing_is_left(self):
        labels = self.painted()["b"].labels()
        self.assertEqual(labels.shape, (200, 200))
        for x, y, name in ((5, 5, "unknown"), (5, 42, "road"), (40, 42, "building"), (95, 44, "road")):
            self.assertEqual(sheet.CLASSES[labels[round(y / GSD), round(x / GSD)]], name)

    def test_same_sheet_same_bytes(self):
        self.painted("one.geojson"), self.painted("two.geojson")
        self.assertEqual((self.root / "one.geojson").read_bytes(), (self.root / "two.geojson").read_bytes())

    def test_a_sheet_that_says_nonsense_is_refused_with_its_line(self):
        for line, said in (
            ("wood 1,1 2,2 3,1", "class 'wood' is unknown"),
            ("road 1,1 2,2", "at least three points"),
            ("road 1,1 x", "not enough values"),
        ):
            (self.root / "sheet.txt").write_text("piece a photo 0 0\n" + line + "\n")
            self.assertIn("sheet.txt:2", message := self.paint("write", "sheet.txt", ".", "-o", "x.geojson", code=1))
            self.assertIn(said, message)

    def test_gaps_and_crossings_are_reported(self):
        (self.root / "sheet.txt").write_text("piece a photo 0 0\nroad~ 0,0 100,100 100,0 0,100\n")
        said = self.paint("write", "sheet.txt", ".", "--gsd", str(GSD), "-o", "x.geojson", code=1)
        self.assertIn("road at 0.0,0.0 crosses itself", said)
        self.assertRegex(said, r"(49|50)\.\d % is not painted")

    def test_check_draws_every_piece(self):
        self.painted()
        said = self.paint("check", "painted.geojson", ".", "-o", "pictures", "--side-by-side")
        self.assertIn("not painted 0.0 %", said)
        self.assertEqual(sorted(p.name for p in (self.root / "pictures").iterdir()), ["a.png", "b.png"])

    def test_painters_agree_with_themselves_and_not_with_others(self):
        self.painted()
        same = json.loads(self.paint("agree", "painted.geojson", "painted.geojson", "."))
        self.assertEqual(same["accuracy"], 1.0)
        self.assertEqual(set(same["iou"].values()), {1.0})
        self.painted("second.geojson", SHEET.replace("road~ 0,40 100,40 100,45 0,45", "road~ 0,40 100,40 100,50 0,50"))
        other = json.loads(self.paint("agree", "painted.geojson", "second.geojson", "."))
        self.assertEqual(
            other["pieces"]["b"]["road"], 1.0
        )  # where the second road is wider the first painter knows nothing
        self.painted(
            "third.geojson", SHEET.replace("box building~ 20,30 60,30 60,50", "box building~ 20,30 60,30 60,42")
        )
        other = json.loads(self.paint("agree", "painted.geojson", "third.geojson", "."))
        self.assertLess(other["pieces"]["b"]["road"], 0.85)  # the road below the roof's lower part

    def test_rendered_labels_lie_where_the_piece_is(self):
        self.painted()
        self.paint("render", "painted.geojson", ".", "-o", "out")
        image, labels = (
            numpy.asarray(Image.open(self.root / "out" / kind / "test_b.png")) for kind in ("images", "labels")
        )
        self.assertEqual(image.shape, labels.shape)
        self.assertEqual(tuple(labels[0, 0]), (0, 0, 0))
        # 10 m to the left of the piece lie in the photo, 20 m above it: the roof's middle is at 50, 60 m there
        self.assertEqual(tuple(labels[120, 100]), (230, 23, 23))
        self.assertLess(numpy.abs(image[120, 100].astype(int) - (200, 60, 50)).max(), 20)

    def test_shapes_are_cut_at_the_piece(self):
        self.assertEqual(
            sorted(pieces.clip_to_square([(-10, 50), (50, 50), (50, 150), (-10, 150)])),
            [(0, 50), (0, 100), (50, 50), (50, 100)],
        )

    def test_without_an_edge_nothing_moves(self):
        edges = snap.Edges(numpy.full((260, 260, 3), 90.0), GSD, 30)
        ring = [(20.0, 20.0), (40.0, 20.0), (40.0, 40.0), (20.0, 40.0)]
        self.assertEqual(snap.snap_ring(ring, edges, 100.0, 1.0), ring)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

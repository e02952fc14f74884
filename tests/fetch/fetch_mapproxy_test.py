#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""`orthodrive fetch` of Kvarnbyn's photo from MapProxy: WMTS by REST and by query, TMS, WMS, a grid in UTM; and a whole
build of it. Where MapProxy or the photo is missing: says so and ends with 77. Usage: fetch_mapproxy_test.py TOOL
SOURCE_TREE
"""

import json
import math
import os
import pathlib
import socketserver
import sqlite3
import subprocess
import sys
import tempfile
import threading
import unittest
import wsgiref.simple_server

import numpy
import servers

TOOL, DATA = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]) / "../shared/data/kvarnbyn"
PHOTO = DATA / "ortho.jpg"
try:
    import mapproxy.wsgiapp
    from osgeo import gdal
except ImportError as missing:
    print(f"SKIPPED: {missing}; `tools/setup --peers` installs MapProxy")
    sys.exit(77)
if not PHOTO.exists():
    print(f"SKIPPED: {PHOTO} is not there")
    sys.exit(77)
gdal.UseExceptions()

AREA, ZOOM = (12.022, 57.654, 12.030, 57.658), 17  # 480 x 450 m, 0.64 m a pixel
CONFIG = """
services:
  wmts: {restful: true, kvp: true}
  tms: {use_grid_names: true}
  wms: {srs: ['EPSG:3857', 'EPSG:32633', 'EPSG:4326'], image_formats: ['image/jpeg', 'image/png']}
layers:
  - {name: ortho, title: Photo, tile_sources: [photo, photo_utm], sources: [photo]}
caches:
  photo:
    grids: [quad]
    sources: []
    format: image/jpeg
    cache: {type: mbtiles, filename: FOLDER/origin.mbtiles}
  photo_utm:
    grids: [utm]
    sources: [photo]
    format: image/jpeg
    meta_size: [1, 1]
    meta_buffer: 0
    cache: {type: file, directory: FOLDER/utm}
    image: {resampling_method: bicubic}
grids:
  quad: {base: GLOBAL_MERCATOR, srs: 'EPSG:3857', num_levels: 18}
  utm: {srs: 'EPSG:32633', bbox: [300000, 6380000, 340000, 6420000], origin: nw, res: [4, 2, 1, 0.5]}
globals:
  image: {resampling_method: bicubic, jpeg_quality: 95}
  cache: {base_dir: FOLDER/cache, lock_dir: FOLDER/locks, tile_lock_dir: FOLDER/tile_locks}
"""


class Threads(socketserver.ThreadingMixIn, wsgiref.simple_server.WSGIServer):
    daemon_threads = True


class Quiet(wsgiref.simple_server.WSGIRequestHandler):
    def log_message(self, *_):
        pass


def grey(pixels):
    return pixels.astype(float).mean(axis=-1)


def shift_px(shown, truth):
    """Columns and rows by which `shown` lies off, by least squares on the slopes of both (Lucas and Kanade 1981)."""

    def blurred(a):
        for axis in (0, 1):
            for _ in range(4):
                a = (numpy.roll(a, 1, axis) + 2 * a + numpy.roll(a, -1, axis)) / 4
        return a

    a, b = blurred(grey(shown)), blurred(grey(truth))
    rows, columns = numpy.gradient((a + b) / 2)
    inner = (slice(8, -8), slice(8, -8))
    slopes = numpy.stack([columns[inner].ravel(), rows[inner].ravel()], axis=1)
    return numpy.linalg.lstsq(slopes, (b - a)[inner].ravel(), rcond=None)[0]


class MapProxy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.root = pathlib.Path(cls.folder.name)
        west, south = servers.mercator(*AREA[:2])
        east, north = servers.mercator(*AREA[2:])
        size = 2 * servers.HALF / 2**ZOOM
        x0, x1 = math.floor((west + servers.HALF) / size) - 2, math.floor((east + servers.HALF) / size) + 3
        y0, y1 = math.floor((servers.HALF - north) / size) - 2, math.floor((servers.HALF - south) / size) + 3
        cls.box = (
            x0 * size - servers.HALF,
            servers.HALF - y1 * size,
            x1 * size - servers.HALF,
            servers.HALF - y0 * size,
        )
        warped = gdal.Warp(
            "",
            str(PHOTO),
            format="MEM",
            dstSRS="EPSG:3857",
            outputBounds=cls.box,
            width=(x1 - x0) * 256,
            height=(y1 - y0) * 256,
            resampleAlg="cubic",
        )
        cls.truth = warped.ReadAsArray().transpose(1, 2, 0)
        with sqlite3.connect(cls.root / "origin.mbtiles") as db:
            db.execute("CREATE TABLE metadata (name TEXT, value TEXT)")
            db.execute("CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, tile_data BLOB)")
            db.execute("CREATE UNIQUE INDEX i ON tiles (zoom_level, tile_column, tile_row)")
            for x in range(x0, x1):
                for y in range(y0, y1):
                    tile = cls.truth[(y - y0) * 256 : (y - y0 + 1) * 256, (x - x0) * 256 : (x - x0 + 1) * 256]
                    db.execute(
                        "INSERT INTO tiles VALUES (?, ?, ?, ?)", (ZOOM, x, 2**ZOOM - 1 - y, servers.encoded(tile))
                    )
        (cls.root / "mapproxy.yaml").write_text(CONFIG.replace("FOLDER", str(cls.root)))
        app = mapproxy.wsgiapp.make_wsgi_app(str(cls.root / "mapproxy.yaml"))
        cls.server = wsgiref.simple_server.make_server("127.0.0.1", 0, app, Threads, Quiet)
        cls.url = f"http://127.0.0.1:{cls.server.server_address[1]}"
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.server.server_close()
        cls.folder.cleanup()

    def fetch(self, to, code=0, **table):
        site = self.root / "site.toml"
        text = (
            f'[area]\nbbox_wgs84 = {list(AREA)}\ncrs = "EPSG:32633"\n[sources]\nphoto = "{to}"\nosm = ["a.osm"]\n'
            'dtm = ["a.tif"]\n[[fetch]]\n'
        )
        site.write_text(
            text + "".join(f"{k} = {json.dumps(v)}\n" for k, v in {"to": to, "resolution_m": 0.7, **table}.items())
        )
        run = subprocess.run(
            [TOOL, "fetch", site, "--pause", "0.05"],
            capture_output=True,
            text=True,
            timeout=120,
            env=os.environ,
            check=False,
        )
        self.assertEqual(run.returncode, code, run.stderr)
        return run.stderr

    def check_place(self, name, largest_difference):
        """Inside the area the fetched photo is the served one, at the right place."""
        shown = (
            gdal.Warp(
                "",
                str(self.root / name),
                format="MEM",
                dstSRS="EPSG:3857",
                outputBounds=self.box,
                width=self.truth.shape[1],
                height=self.truth.shape[0],
                resampleAlg="cubic",
                dstAlpha=True,
            )
            .ReadAsArray()
            .transpose(1, 2, 0)
        )
        west, south = servers.mercator(*AREA[:2])
        east, north = servers.mercator(*AREA[2:])
        pixel = (self.box[2] - self.box[0]) / self.truth.shape[1]
        rows = slice(math.ceil((self.box[3] - north) / pixel), math.floor((self.box[3] - south) / pixel))
        columns = slice(math.ceil((west - self.box[0]) / pixel), math.floor((east - self.box[0]) / pixel))
        shown, truth = shown[rows, columns], self.truth[rows, columns]
        self.assertEqual(shown[..., 3].min(), 255)
        dx, dy = shift_px(shown[..., :3], truth)
        self.assertLess(math.hypot(dx, dy), 0.25, (name, dx, dy))
        difference = numpy.abs(shown[..., :3].astype(int) - truth).mean()
        self.assertLess(difference, largest_difference, name)
        print(f"{name}: shift {math.hypot(dx, dy):.3f} px, mean difference {difference:.2f} of 255")

    def test_the_measure_of_shift_sees_a_shift(self):
        big = self.truth[:400, :400]
        moved = numpy.roll(big, 1, axis=1)
        dx, dy = shift_px(moved, big)
        self.assertGreater(dx, 0.6)
        self.assertLess(abs(dy), 0.1)

    def test_wmts_by_rest(self):
        self.fetch("rest.mbtiles", kind="wmts", url=self.url + "/wmts/1.0.0/WMTSCapabilities.xml", layer="ortho")
        self.check_place("rest.mbtiles", 2.5)

    def test_wmts_by_query(self):
        text = self.url + "/service?REQUEST=GetCapabilities&SERVICE=WMTS"
        self.fetch("kvp.mbtiles", kind="wmts", url=text, layer="ortho", tile_matrix_set="quad")
        self.check_place("kvp.mbtiles", 2.5)

    def test_wmts_in_utm_becomes_a_geotiff(self):
        url = self.url + "/wmts/1.0.0/WMTSCapabilities.xml"
        self.fetch("utm.tif", kind="wmts", url=url, layer="ortho", tile_matrix_set="utm")
        photo = gdal.Open(str(self.root / "utm.tif"))
        self.assertEqual(photo.GetSpatialRef().GetAuthorityCode(None), "32633")
        self.assertAlmostEqual(photo.GetGeoTransform()[1], 0.5)
        self.check_place("utm.tif", 8.0)  # resampled twice
        said = self.fetch("utm.mbtiles", code=2, kind="wmts", url=url, layer="ortho", tile_matrix_set="utm")
        self.assertIn("MBTiles holds web mercator only; name it .tif", said)

    def test_tms(self):
        self.fetch("tms.mbtiles", kind="tms", url=self.url + "/tiles/1.0.0/ortho/quad/{z}/{x}/{y}.jpeg")
        self.check_place("tms.mbtiles", 2.5)

    def test_xyz(self):
        self.fetch("xyz.mbtiles", kind="xyz", url=self.url + "/tiles/1.0.0/ortho/quad/{z}/{x}/{y}.jpeg?origin=nw")
        self.check_place("xyz.mbtiles", 2.5)

    def test_wms(self):
        self.fetch("wms.mbtiles", kind="wms", url=self.url + "/service", layer="ortho")
        self.check_place("wms.mbtiles", 3.0)

    def test_wms_on_the_sites_grid(self):
        self.fetch("wms.tif", kind="wms", url=self.url + "/service?", layer="ortho", format="image/png")
        self.assertEqual(gdal.Open(str(self.root / "wms.tif")).GetSpatialRef().GetAuthorityCode(None), "32633")
        self.check_place("wms.tif", 8.0)

    def test_one_command_builds_a_site_from_tiles(self):
        """Its roads lie where those of the same site built from the photo itself lie."""

        def build(name, photo, more=""):
            folder = self.root / name
            folder.mkdir()
            osm, dtm = (json.dumps(str((DATA / f).resolve())) for f in ("roads.osm", "dtm_10m_utm33.tif"))
            text = (
                f'[area]\nbbox_wgs84 = {list(AREA)}\ncrs = "EPSG:32633"\n[sources]\nphoto = {json.dumps(photo)}\n'
                f"osm = [{osm}]\ndtm = [{dtm}]\n"
            )
            (folder / "site.toml").write_text(text + more)
            run = subprocess.run(
                [TOOL, "build", folder / "site.toml", "-o", folder / "out"],
                capture_output=True,
                text=True,
                timeout=280,
                env=os.environ,
                check=False,
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            return folder / "out"

        tiles = (
            '[[fetch]]\nto = "photo.mbtiles"\nkind = "xyz"\nresolution_m = 0.7\nurl = '
            f'"{self.url}/tiles/1.0.0/ortho/quad/{{z}}/{{x}}/{{y}}.jpeg?origin=nw"\n'
            'attribution = "Orthophoto: Lantmäteriet"\nlicence = "CC BY 4.0"\n'
        )
        fetched, local = build("fetched", "photo.mbtiles", tiles), build("local", str(PHOTO.resolve()))
        run = subprocess.run(
            [TOOL, "evaluate", "roads", fetched / "roads.gpkg", local / "roads.gpkg", "--json"],
            capture_output=True,
            text=True,
            check=False,
        )
        scores = json.loads(run.stdout)
        print(
            f"roads from tiles and from the photo: {scores['offset_m']['mean_abs']:.2f} m apart, widths "
            f"{scores['width_m']['mean_abs']:.2f} m"
        )
        self.assertLess(scores["offset_m"]["mean_abs"], 0.3)
        self.assertLess(scores["width_m"]["mean_abs"], 0.5)
        self.assertGreater(scores["surface_iou"], 0.8)
        for name in ("roads.xodr", "scene/tileset.json", "drive/lap.csv", "report.html"):
            self.assertTrue((fetched / name).exists(), name)
        self.assertIn("Orthophoto: Lantmäteriet", (fetched / "report.html").read_text())

    def test_a_layer_that_is_not_there(self):
        said = self.fetch(
            "none.mbtiles", code=1, kind="wmts", url=self.url + "/wmts/1.0.0/WMTSCapabilities.xml", layer="orto"
        )
        self.assertIn("no layer 'orto'; there are: ortho", said)
        self.assertFalse((self.root / "none.mbtiles").exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], warnings="ignore")  # MapProxy leaves files open

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""`orthodrive fetch` against servers on loopback, with and without faults. Usage: fetch_test.py TOOL [unittest's
words]
"""

import json
import os
import pathlib
import random
import re
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

import numpy
import servers
from osgeo import gdal, osr

gdal.UseExceptions()
osr.UseExceptions()
TOOL = str(pathlib.Path(sys.argv.pop(1)).resolve())
AREA = (15.70, 50.03, 15.712, 50.036)  # 860 x 670 m


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def serve(self, server):
        self.addCleanup(server.close)
        return server

    def site(self, *tables, area=AREA, extra=""):
        text = (
            f'name = "Test"\n[area]\nbbox_wgs84 = {list(area)}\n{extra}\n[sources]\nphoto = "photo.mbtiles"\nosm = '
            '["roads.osm"]\ndtm = ["dtm.tif"]\n'
        )
        for table in tables:
            text += "[[fetch]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items())
        (self.root / "site.toml").write_text(text)
        return self.root / "site.toml"

    def fetch(self, *words, code=0, env=None, quick=True):
        pace = ["--pause", "0.02"] if quick else []
        run = subprocess.run(
            [TOOL, "fetch", self.root / "site.toml", *pace, *words],
            capture_output=True,
            text=True,
            timeout=300,
            env={**os.environ, "ORTHODRIVE_STORE": str(self.root / "store"), **(env or {})},
            check=False,
        )
        self.assertEqual(run.returncode, code, run.stdout + run.stderr)
        self.assertEqual(run.stdout, "")
        return run.stderr

    def fails(self, *words, code=1, env=None):
        before = sorted(p.name for p in self.root.iterdir())
        said = self.fetch(*words, code=code, env=env)
        self.assertEqual(len(re.findall("^orthodrive: ", said, re.MULTILINE)), 1, said)
        self.assertFalse(
            [
                p
                for p in sorted(p.name for p in self.root.iterdir())
                if p not in before and not p.endswith(("-wal", "-shm", ".fetching", "store"))
            ]
        )
        return said.strip().split("\n")[-1]

    def record(self, name="photo.mbtiles"):
        return json.loads((self.root / (name + ".source.json")).read_text())


def wait_until(true, seconds=30):
    end = time.time() + seconds
    while not true():
        if time.time() > end:
            raise AssertionError("waited in vain")
        time.sleep(0.02)


def xyz(server, **more):
    return {
        "to": "photo.mbtiles",
        "kind": "xyz",
        "url": server.url + "/tiles/{z}/{x}/{y}.jpg",
        "resolution_m": 0.8,
        "licence": "CC0",
        "attribution": "Nobody",
        **more,
    }


def tiles_of(file):
    with sqlite3.connect(f"file:{file}?mode=ro", uri=True) as db:
        return {(z, x, 2**z - 1 - y): data for z, x, y, data in db.execute("SELECT * FROM tiles")}


def expected_tiles(area, zoom):
    (west, south), (east, north) = servers.mercator(*area[:2]), servers.mercator(*area[2:])
    size = 2 * servers.HALF / 2**zoom
    return {
        (zoom, x, y)
        for x in range(int((west + servers.HALF) / size), int((east + servers.HALF) / size) + 1)
        for y in range(int((servers.HALF - north) / size), int((servers.HALF - south) / size) + 1)
    }


class Xyz(Case):
    def test_tiles_become_mbtiles_that_gdal_reads_at_the_right_place(self):
        origin = self.serve(servers.tile_origin())
        self.site(xyz(origin))
        said = self.fetch()
        tiles = tiles_of(self.root / "photo.mbtiles")
        self.assertLessEqual(expected_tiles(AREA, 17), tiles.keys())  # 0.77 m; a margin may add a row
        self.assertLess(len(tiles), 1.5 * len(expected_tiles(AREA, 17)))
        self.assertEqual(sorted(origin.paths()), sorted({f"/tiles/{z}/{x}/{y}.jpg" for z, x, y in tiles}))
        for key, data in tiles.items():
            self.assertEqual(data, servers.tile(*key))
        photo = gdal.Open(str(self.root / "photo.mbtiles"))
        west, pixel, _, north, _, _ = photo.GetGeoTransform()
        shown = photo.ReadAsArray(0, 0, photo.RasterXSize, photo.RasterYSize)
        east = west + (numpy.arange(photo.RasterXSize) + 0.5) * pixel
        truth = servers.picture(*numpy.meshgrid(east, north - (numpy.arange(photo.RasterYSize) + 0.5) * pixel))
        inside = shown[3] == 255
        self.assertGreater(inside.mean(), 0.8)
        self.assertLess(numpy.abs(shown[:3].transpose(1, 2, 0).astype(int) - truth)[inside].mean(), 3.0)
        record = self.record()
        self.assertEqual(
            (record["zoom"], record["licence"], record["attribution"], record["tiles"]),
            ("17", "CC0", "Nobody", len(tiles)),
        )
        self.assertAlmostEqual(record["resolution_m"], 0.767, delta=0.01)
        self.assertIn("tiles at zoom 17 (0.77 m)", said)

    def test_nothing_is_asked_twice(self):
        origin = self.serve(servers.tile_origin())
        self.site(xyz(origin))
        self.fetch()
        asked, before = len(origin.log), (self.root / "photo.mbtiles").read_bytes()
        self.assertIn("is there already", self.fetch())
        self.assertEqual(len(origin.log), asked)
        self.site(xyz(origin), area=(15.70, 50.03, 15.716, 50.036))  # what both areas have is taken over
        self.fetch()
        self.assertEqual(len(origin.log), len(tiles_of(self.root / "photo.mbtiles")))
        self.assertGreater(len(origin.log), asked)
        self.site(xyz(origin))
        self.fetch()
        self.assertEqual((self.root / "photo.mbtiles").read_bytes(), before)

    def test_tms_counts_rows_from_the_south_and_subdomains_take_turns(self):
        origin = self.serve(
            servers.Server(
                lambda method, path, headers, body: (
                    200,
                    {},
                    servers.encoded(numpy.full((256, 256, 3), 90, numpy.uint8)),
                )
            )
        )
        self.site(xyz(origin, kind="tms", url=origin.url + "/{s}/{z}/{x}/{y}.jpg", subdomains="abc"))
        self.fetch()
        found = {tuple(map(int, re.findall(r"\d+", p))) for p in origin.paths()}
        self.assertEqual({(z, x, 2**z - 1 - y) for z, x, y in found}, tiles_of(self.root / "photo.mbtiles").keys())
        self.assertEqual({p[1] for p in origin.paths()}, set("abc"))

    def test_refresh_asks_for_news_and_takes_what_changed(self):
        changed = set()
        origin = self.serve(servers.tile_origin(changed=changed))
        self.site(xyz(origin))
        self.fetch()
        before = tiles_of(self.root / "photo.mbtiles")
        bytes_before = (self.root / "photo.mbtiles").read_bytes()
        self.assertIn(f"{len(before)} unchanged", self.fetch("--refresh"))
        self.assertEqual((self.root / "photo.mbtiles").read_bytes(), bytes_before)
        changed.add(sorted(before)[3])
        self.fetch("--refresh")
        after = tiles_of(self.root / "photo.mbtiles")
        self.assertEqual({key for key in before if before[key] != after[key]}, changed)

    def test_tiles_that_are_not_there_are_counted_and_become_invalid(self):
        origin = self.serve(servers.tile_origin(absent=lambda z, x, y: x % 2 == 0))
        self.site(xyz(origin))
        self.assertIn("are not on the server", self.fetch())
        record = self.record()
        self.assertEqual(record["tiles"] - record["missing_tiles"], len(tiles_of(self.root / "photo.mbtiles")))
        photo = gdal.Open(str(self.root / "photo.mbtiles"))
        alpha = photo.GetRasterBand(4).ReadAsArray()
        self.assertEqual(set(numpy.unique(alpha)), {0, 255})

    def test_a_users_own_file_is_left(self):
        (self.root / "photo.mbtiles").write_text("mine")
        self.site(xyz(self.serve(servers.tile_origin())))
        self.assertIn("left as it is", self.fetch())
        self.assertEqual((self.root / "photo.mbtiles").read_text(), "mine")

    def test_a_dry_run_says_how_much_and_asks_nothing(self):
        origin = self.serve(servers.tile_origin())
        self.site(xyz(origin))
        self.assertRegex(self.fetch("--dry-run"), r"photo.mbtiles: \d+ tiles at zoom 17 \(0.77 m\), about [\d.]+ [kM]B")
        self.assertEqual(origin.log, [])
        self.assertEqual([p.name for p in self.root.iterdir()], ["site.toml"])


class Faults(Case):
    def test_with_a_tenth_of_faults_every_tile_arrives_once(self):
        origin = self.serve(servers.tile_origin())
        proxy = self.serve(servers.FaultProxy(origin, share=0.1, seed=7))
        self.site(xyz(proxy, resolution_m=0.2))  # zoom 19
        self.fetch("--connections", "8")
        tiles = tiles_of(self.root / "photo.mbtiles")
        self.assertGreater(len(tiles), 250)
        self.assertEqual(self.record()["missing_tiles"], 0)
        for key, data in tiles.items():
            self.assertEqual(data, servers.tile(*key), key)
        self.assertGreaterEqual(sum(proxy.done.values()), 20)
        self.assertGreaterEqual(len(proxy.done), 10, proxy.done)
        self.assertEqual({path for path, times in proxy.delivered.items() if times > 1}, set())
        with sqlite3.connect(self.root / "photo.mbtiles") as db:
            self.assertEqual(db.execute("SELECT count(*) FROM tiles").fetchone()[0], len(tiles))

    def test_a_stalled_connection_is_given_up_and_asked_again(self):
        self.serve(servers.tile_origin())
        stalled = []

        def answer(method, path, headers, body):
            if len(stalled) < 3 and path not in stalled:
                stalled.append(path)
                return lambda handler: time.sleep(100)
            return servers.conditional(servers.tile(*map(int, re.findall(r"\d+", path))), "image/jpeg", headers)

        slow = self.serve(servers.Server(answer))
        self.site(xyz(slow))
        begun = time.time()
        self.fetch("--stall", "1")
        self.assertLess(time.time() - begun, 90)  # machines may be slow
        self.assertEqual(self.record()["missing_tiles"], 0)

    def test_retry_after_is_obeyed_by_all_connections(self):
        self.serve(servers.tile_origin())
        times, until = [], [0.0]

        def answer(method, path, headers, body):
            times.append(time.time())
            if len(times) == 5:
                until[0] = time.time() + 2
                return 429, {"Retry-After": "2"}, b""
            return servers.conditional(servers.tile(*map(int, re.findall(r"\d+", path))), "image/jpeg", headers)

        strict = self.serve(servers.Server(answer))
        self.site(xyz(strict))
        self.fetch()
        early = [t for t in times[5:] if t < until[0] - 0.1]
        self.assertLessEqual(len(early), 6)  # those under way
        self.assertGreater(max(times), until[0])

    def test_killed_at_any_time_it_goes_on_to_the_same_bytes(self):
        origin = self.serve(servers.tile_origin(delay_s=0.02))
        self.site(xyz(origin, resolution_m=0.2))
        self.fetch()
        whole = (self.root / "photo.mbtiles").read_bytes()
        count = len(tiles_of(self.root / "photo.mbtiles"))
        for tiles_a_life in (40, 110):  # from one kill to the next
            for file in self.root.glob("photo*"):
                file.unlink()
            origin.log.clear()
            kills, asked = 0, 0
            while True:
                run = subprocess.Popen([TOOL, "-q", "fetch", self.root / "site.toml", "--connections", "1"])
                most = asked + tiles_a_life
                wait_until(lambda run=run, most=most: run.poll() is not None or len(origin.log) >= most)
                if run.poll() is not None:
                    self.assertEqual(run.returncode, 0)
                    break
                time.sleep(1.1)  # a batch is kept each second
                run.kill()
                run.wait()
                asked, kills = len(origin.log), kills + 1
                self.assertLess(kills, 20)
            self.assertGreaterEqual(kills, 1)
            self.assertEqual((self.root / "photo.mbtiles").read_bytes(), whole)
            self.assertLess(len(origin.log), count * (1 + kills))
            self.assertEqual(
                sorted(p.name for p in self.root.glob("*photo*")), ["photo.mbtiles", "photo.mbtiles.source.json"]
            )

    def test_killed_before_the_record_was_written_it_is_finished(self):
        origin = self.serve(servers.tile_origin())
        self.site(xyz(origin))
        self.fetch()
        whole, asked = (self.root / "photo.mbtiles").read_bytes(), len(origin.log)
        (self.root / "photo.mbtiles.source.json").unlink()
        (self.root / "photo.mbtiles.placing").write_text("")
        self.fetch()
        self.assertEqual(((self.root / "photo.mbtiles").read_bytes(), len(origin.log)), (whole, asked))
        self.assertEqual(
            sorted(p.name for p in self.root.glob("*photo*")), ["photo.mbtiles", "photo.mbtiles.source.json"]
        )

    def test_a_second_process_on_the_same_file_is_refused(self):
        origin = self.serve(servers.tile_origin(delay_s=0.05))
        self.site(xyz(origin, resolution_m=0.2))
        first = subprocess.Popen([TOOL, "-q", "fetch", self.root / "site.toml", "--connections", "1"])
        wait_until(lambda: len(origin.log) > 3)
        self.assertIn("another process fetches into it", self.fetch(code=1))
        first.kill()
        first.wait()


class Keys(Case):
    def test_keys_are_read_from_the_environment_and_shown_nowhere(self):
        key = "s3cr3t/+Key 42"
        asked = []

        def answer(method, path, headers, body):
            asked.append(path)
            if len(asked) % 3 == 0:
                return 302, {"Location": path}, b""
            return (
                (200, {}, servers.encoded(numpy.full((256, 256, 3), 90, numpy.uint8)))
                if len(asked) < 40 or good[0]
                else (403, {}, key.encode())
            )

        good = [True]
        origin = self.serve(servers.Server(answer))
        table = xyz(origin, url=origin.url + "/{z}/{x}/{y}.jpg?key={env:TEST_TILE_KEY}")
        self.site(table)
        self.assertIn("TEST_TILE_KEY is not set", self.fails(code=2))
        said = self.fetch(env={"TEST_TILE_KEY": key})
        self.assertTrue(all("key=s3cr3t%2F%2BKey%2042" in path for path in asked))
        self.assertEqual(self.record()["url"], table["url"])
        good[0] = False
        for file in self.root.glob("photo*"):
            file.unlink()
        said += self.fetch(env={"TEST_TILE_KEY": key}, code=1)
        self.assertIn("403", said)
        for text in [said, *(p.read_bytes().decode("latin-1") for p in self.root.iterdir())]:
            self.assertNotIn("s3cr3t", text)


def make_cog(path, array, gsd=2.0, west=549800.0, north=5543600.0, driver="COG", options=()):
    """Of EPSG:32633, rows from the north."""
    bands = array if array.ndim == 3 else array[None]
    kind = gdal.GDT_Byte if array.dtype == numpy.uint8 else gdal.GDT_Float32
    memory = gdal.GetDriverByName("MEM").Create("", bands.shape[2], bands.shape[1], bands.shape[0], kind)
    memory.SetGeoTransform((west, gsd, 0, north, 0, -gsd))
    reference = osr.SpatialReference()
    reference.ImportFromEPSG(32633)
    memory.SetSpatialRef(reference)
    for i, band in enumerate(bands):
        memory.GetRasterBand(i + 1).WriteArray(band)
    gdal.GetDriverByName(driver).CreateCopy(str(path), memory, options=list(options))
    return path.read_bytes()


def heights(columns, rows, gsd=2.0):
    x, y = numpy.meshgrid(numpy.arange(columns) * gsd, numpy.arange(rows) * gsd)
    noise = numpy.random.default_rng(1).normal(0, 0.1, x.shape)
    return (200 + 0.05 * x - 0.02 * y + noise).astype(numpy.float32)


class Rasters(Case):
    def table(self, server, **more):
        return {"to": "dtm.tif", "kind": "cog", "url": server.url + "/big.tif", "vertical_datum": "EVRF2007", **more}

    def test_of_a_large_cog_only_the_part_is_read(self):
        whole = heights(3000, 2500)
        big = make_cog(self.root / "big.tif", whole, west=547000.0, north=5545000.0)
        origin = self.serve(servers.file_origin({"/big.tif": big}))
        (self.root / "big.tif").unlink()
        self.site(self.table(origin))
        self.fetch()
        self.assertTrue(all("Range" in headers or headers["method"] == "HEAD" for _, _, headers in origin.log))
        part = gdal.Open(str(self.root / "dtm.tif"))
        west, _, _, north, _, _ = part.GetGeoTransform()
        column, row = round((west - 547000) / 2), round((5545000 - north) / 2)
        numpy.testing.assert_array_equal(
            part.ReadAsArray(), whole[row : row + part.RasterYSize, column : column + part.RasterXSize]
        )
        self.assertLess((self.root / "dtm.tif").stat().st_size, len(big) / 4)
        self.assertEqual(self.record("dtm.tif")["vertical_datum"], "EVRF2007")

    def test_faults_of_the_server_are_asked_again(self):
        big = make_cog(self.root / "big.tif", heights(1500, 1200))
        (self.root / "big.tif").unlink()
        behind = self.serve(servers.file_origin({"/big.tif": big}))
        proxy = self.serve(servers.FaultProxy(behind, share=0.0))
        good, asked = proxy.forward, []

        def answer(method, path, headers, body):
            asked.append(method)
            return (503, {}, b"") if method == "GET" and asked.count("GET") % 2 else good(path, headers)

        flaky = self.serve(servers.Server(answer))
        self.site(self.table(flaky))
        self.fetch()
        self.assertGreaterEqual(asked.count("GET"), 2)
        self.assertGreater(gdal.Open(str(self.root / "dtm.tif")).ReadAsArray().min(), 100)

    def test_several_rasters_become_one_in_the_unit_that_is_said(self):
        left = make_cog(self.root / "l.tif", heights(500, 800), west=549800.0)
        right = make_cog(self.root / "r.tif", heights(500, 800) + 1000, west=550800.0)
        origin = self.serve(servers.file_origin({"/l.tif": left, "/r.tif": right}))
        table = {
            "to": "dtm.tif",
            "kind": "raster",
            "urls": [origin.url + "/l.tif", origin.url + "/r.tif"],
            "vertical_unit": "us-ft",
        }
        self.site(table)
        self.assertIn("vertical datum is not named", self.fetch())
        (self.root / "dtm.tif").unlink()
        self.site({**table, "vertical_datum": "NAVD88"})
        self.assertNotIn("vertical datum is not named", self.fetch())
        part = gdal.Open(str(self.root / "dtm.tif"))
        self.assertEqual(part.GetMetadataItem("VERTICAL_DATUM"), "NAVD88")
        self.assertEqual(part.GetRasterBand(1).GetUnitType(), "us-ft")
        found = part.ReadAsArray()
        self.assertLess(found[:, 5].max(), 400)
        self.assertGreater(found[:, -5].min(), 1000)

    def test_a_photo_with_infrared_at_a_coarser_resolution(self):
        random = numpy.random.default_rng(2).integers(0, 255, (4, 100, 100)).astype(numpy.uint8)
        picture = numpy.kron(random, numpy.ones((1, 20, 20), numpy.uint8))
        make_cog(self.root / "photo_4.tif", picture, gsd=0.5, west=549900.0, north=5543300.0, driver="GTiff")
        self.site(
            {"to": "photo.tif", "kind": "raster", "url": "photo_4.tif", "resolution_m": 1.0},
            area=(15.7, 50.031, 15.705, 50.034),
        )
        self.fetch()
        photo = gdal.Open(str(self.root / "photo.tif"))
        self.assertEqual(photo.RasterCount, 3)
        self.assertAlmostEqual(photo.GetGeoTransform()[1], 1.0, delta=0.01)

    def test_what_cannot_be_used(self):
        far = make_cog(self.root / "far.tif", heights(100, 100), west=700000.0)
        vrt = (
            b'<VRTDataset rasterXSize="9" rasterYSize="9"><VRTRasterBand dataType="Byte" band="1"><SimpleSource>'
            b"<SourceFilename>/etc/passwd</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>"
        )
        origin = self.serve(
            servers.file_origin({"/far.tif": far, "/list.vrt": vrt, "/page.tif": b"<html>no</html>" * 100})
        )
        for name, said in (
            ("far.tif", "shows nothing of the area: it covers longitude"),
            ("none.tif", "cannot be read as a raster"),
            ("list.vrt", "cannot be read as a raster"),
            ("page.tif", "cannot be read as a raster"),
        ):
            self.site(self.table(origin, url=f"{origin.url}/{name}"))
            self.assertIn(said, self.fails())


def osm_text(columns=40, rows=40, west=15.68, south=50.02, step=0.001):
    """A grid of nodes with a way along every row, a house, and a wood of two ways of which one lies far off."""
    text, draw = ['<?xml version="1.0"?><osm version="0.6">'], random.Random(1)

    def near(degrees):
        return f"{degrees + draw.uniform(-3e-5, 3e-5):.7f}"  # without chance a PBF file would be a bomb of zeros

    for row in range(rows):
        for column in range(columns):
            text.append(
                f'<node id="{row * columns + column + 1}" version="1" lat="{near(south + row * step)}" '
                f'lon="{near(west + column * step)}" user="someone" uid="7"/>'
            )
    for row in range(rows):
        refs = "".join(f'<nd ref="{row * columns + c + 1}"/>' for c in range(columns))
        text.append(
            f'<way id="{row + 1}" version="1" user="someone" uid="7">{refs}<tag k="highway" v="residential"/></way>'
        )
    a, b = 12 * columns + 25, 1
    text.append(
        f'<way id="900" version="1"><nd ref="{a}"/><nd ref="{a + 1}"/></way><way id="901" version="1"><nd ref="{b}"/>'
        f'<nd ref="{b + 1}"/></way>'
    )
    text.append(
        '<relation id="5" version="1"><member type="way" ref="900" role="outer"/><member type="way" ref="901" '
        'role="outer"/><tag k="type" v="multipolygon"/><tag k="natural" v="wood"/></relation>'
    )
    text.append(
        '<relation id="6" version="1"><member type="way" ref="901" role=""/><tag k="type" v="route"/></relation>'
    )
    return "\n".join([*text, "</osm>"])


def osm_ids(file):
    text = file.read_text()
    return {kind: set(map(int, re.findall(rf'<{kind} id="(\d+)"', text))) for kind in ("node", "way", "relation")}


class Osm(Case):
    def test_an_extract_is_cut_with_complete_ways(self):
        (self.root / "region.osm").write_text(osm_text())
        self.site({"to": "roads.osm", "kind": "osm_extract", "url": "region.osm"})
        self.fetch()
        ids = osm_ids(self.root / "roads.osm")
        rows = {row + 1 for row in range(40) if 50.03 - 0.0027 <= 50.02 + row * 0.001 <= 50.036 + 0.0027}
        self.assertEqual(ids["way"], rows | {900, 901})  # whole wood
        self.assertEqual(ids["node"], {(row - 1) * 40 + c for row in rows for c in range(1, 41)} | {1, 2})
        self.assertEqual(ids["relation"], {5})  # the route has nothing in the area
        self.assertNotIn("someone", (self.root / "roads.osm").read_text())

    def extract(self, columns=300, rows=100):
        """Bytes of a .osm.pbf, made from XML by the tool itself; another reader looks at it."""
        (self.root / "region.osm").write_text(osm_text(columns, rows, 15.5, 50.0))
        self.site({"to": "all.osm.pbf", "kind": "osm_extract", "url": "region.osm"}, area=(15.4, 49.9, 15.9, 50.2))
        self.fetch()
        reader = gdal.OpenEx(str(self.root / "all.osm.pbf"), gdal.OF_VECTOR)
        lines = reader.ExecuteSQL("SELECT osm_id FROM lines WHERE highway = 'residential'")
        self.assertEqual(sum(1 for _ in lines), rows)
        reader.ReleaseResultSet(lines)
        content = (self.root / "all.osm.pbf").read_bytes()
        for file in self.root.glob("*"):
            file.unlink()
        return content

    def test_a_download_that_breaks_goes_on_where_it_stopped(self):
        content = self.extract()
        origin = self.serve(servers.file_origin({"/x/region-latest.osm.pbf": content}, cut_after=len(content) // 5 + 1))
        self.site({"to": "roads.osm.pbf", "kind": "osm_extract", "url": origin.url + "/x/region-latest.osm.pbf"})
        self.fetch()
        ranges = [headers.get("Range") for _, _, headers in origin.log]
        self.assertEqual(ranges[0], None)
        self.assertEqual(len(ranges), 5, ranges)
        self.assertEqual([p.read_bytes() == content for p in (self.root / "store").glob("*.pbf")], [True])
        again = len(origin.log)
        first = (self.root / "roads.osm.pbf").read_bytes()
        (self.root / "roads.osm.pbf").unlink()  # the store has the extract
        self.fetch()
        self.assertEqual((len(origin.log), (self.root / "roads.osm.pbf").read_bytes()), (again, first))
        self.fetch("--refresh")
        self.assertEqual(origin.log[-1][1], 304)

    def test_a_killed_download_goes_on_and_another_version_begins_anew(self):
        content = self.extract()
        files, slow = {"/r.osm.pbf": content}, [True]

        def answer(method, path, headers, body):
            tag, found = servers.etag(files[path]), re.fullmatch(r"bytes=(\d+)-", headers.get("Range") or "")
            first = int(found[1]) if found and headers.get("If-Range") == tag else 0
            if not slow[0]:
                fields = {
                    "ETag": tag,
                    **({"Content-Range": f"bytes {first}-{len(files[path]) - 1}/{len(files[path])}"} if first else {}),
                }
                return 206 if first else 200, fields, files[path][first:]

            def drip(handler):
                handler.send_response(200)
                handler.send_header("ETag", tag)
                handler.send_header("Content-Length", str(len(files[path])))
                handler.end_headers()
                handler.wfile.write(files[path][: len(content) // 2])
                handler.wfile.flush()
                time.sleep(30)

            return drip

        origin = self.serve(servers.Server(answer))
        self.site({"to": "roads.osm.pbf", "kind": "osm_extract", "url": origin.url + "/r.osm.pbf"})
        env = {**os.environ, "ORTHODRIVE_STORE": str(self.root / "store")}

        def begin_and_kill():
            run = subprocess.Popen([TOOL, "-q", "fetch", self.root / "site.toml"], env=env)
            wait_until(lambda: any(p.stat().st_size > 10000 for p in (self.root / "store").glob("*.part")))
            run.kill()
            run.wait()

        begin_and_kill()
        slow[0] = False
        self.fetch()
        self.assertGreater(int(re.search(r"\d+", origin.log[-1][2]["Range"])[0]), 1000)
        (stored,) = (self.root / "store").glob("*.pbf")
        self.assertEqual(stored.read_bytes(), content)
        for file in [*self.root.glob("roads*"), *(self.root / "store").glob("*")]:
            file.unlink()
        slow[0] = True
        begin_and_kill()
        files["/r.osm.pbf"], slow[0] = content[: -self.last_block(content)], False  # another version
        self.fetch()
        (stored,) = (self.root / "store").glob("*.pbf")
        self.assertEqual(stored.read_bytes(), files["/r.osm.pbf"])

    def last_block(self, content):
        """Length of the last block of a PBF file: 4 bytes of the header's length, the header, which ends with the
        data's length.
        """
        at, last = 0, 0
        while at < len(content):
            header = int.from_bytes(content[at : at + 4], "big")
            fields = content[at + 4 : at + 4 + header]
            size, shift = 0, 0
            for byte in fields[fields.rindex(b"\x18") + 1 :]:
                size |= (byte & 127) << shift
                shift += 7
            last = 4 + header + size
            at += last
        return last

    def test_overpass_is_asked_again_until_the_answer_is_whole(self):
        good = osm_text().encode()
        answers = [
            (429, {"Retry-After": "1"}, b""),
            (200, {}, b"<osm><remark> runtime error: Query timed out </remark></osm>"),
            (200, {}, good[:-20]),
            (200, {}, good),
        ]
        queries = []

        def answer(method, path, headers, body):
            queries.append((method, urllib.parse.parse_qs(body.decode())["data"][0]))
            return answers[min(len(queries), len(answers)) - 1]

        origin = self.serve(servers.Server(answer))
        self.site(
            {
                "to": "roads.osm",
                "kind": "overpass",
                "url": origin.url + "/api/interpreter",
                "attribution": "© OpenStreetMap contributors",
                "licence": "ODbL",
            }
        )
        self.fetch()
        self.assertEqual(len(queries), 4)
        self.assertEqual(queries[0][0], "POST")
        self.assertRegex(queries[0][1], r'nwr\["highway"\]\(50\.02\d+,15\.69\d+,50\.03\d+,15\.71\d+\);')
        self.assertIn(12, osm_ids(self.root / "roads.osm")["way"])
        self.assertEqual(self.record("roads.osm")["licence"], "ODbL")

    def test_an_extract_of_elsewhere(self):
        (self.root / "region.osm").write_text(osm_text(west=3.0))
        self.site({"to": "roads.osm", "kind": "osm_extract", "url": "region.osm"})
        self.assertIn("holds nothing of the area: it covers longitude 2.99997..3.03", self.fails())
        (self.root / "region.osm").write_text(osm_text()[:-3000])
        self.assertIn("region.osm: not an OSM file", self.fails())


def wmts_capabilities(left, top, pixel):
    """One layer in UTM with two levels; SERVER stands for the address."""

    def matrix(name, gsd, count):
        return (
            f"<TileMatrix><ows:Identifier>{name}</ows:Identifier><ScaleDenominator>"
            f"{gsd / 0.00028}</ScaleDenominator><TopLeftCorner>{left} {top}</TopLeftCorner>"
            f"<TileWidth>200</TileWidth><TileHeight>200</TileHeight><MatrixWidth>{count}</MatrixWidth>"
            f"<MatrixHeight>{count}</MatrixHeight></TileMatrix>"
        )

    template = "SERVER/t/{TileMatrixSet}/{TileMatrix}/{TileRow}/{TileCol}.png"
    return (
        '<Capabilities xmlns="http://www.opengis.net/wmts/1.0" xmlns:ows="http://www.opengis.net/ows/1.1">'
        "<Contents><Layer><ows:Identifier>photo</ows:Identifier><Format>image/png</Format>"
        '<TileMatrixSetLink><TileMatrixSet>u</TileMatrixSet></TileMatrixSetLink><ResourceURL format="image/png" '
        f'resourceType="tile" template="{template}"/></Layer>'
        "<TileMatrixSet><ows:Identifier>u</ows:Identifier><ows:SupportedCRS>"
        "urn:ogc:def:crs:EPSG::32633</ows:SupportedCRS>"
        f"{matrix('a', 3.2, 100)}{matrix('b', pixel, 400)}</TileMatrixSet></Contents></Capabilities>"
    )


class Wmts(Case):
    """A grid in UTM with holes, as MapProxy would not have them."""

    def test_tiles_that_are_not_there_are_invalid_in_a_geotiff(self):
        left, top, pixel = 540000.0, 5550000.0, 0.8

        text = wmts_capabilities(left, top, pixel)

        def answer(method, path, headers, body):
            if "xml" in path:
                return 200, {"Content-Type": "text/xml"}, text.replace("SERVER", origin.url).encode()
            row, column = map(int, re.search(r"/b/(\d+)/(\d+)\.png", path).groups())
            if (row + column) % 3 == 0:
                return 404, {}, b""
            east = left + (column * 200 + numpy.arange(200) + 0.5) * pixel
            north = top - (row * 200 + numpy.arange(200) + 0.5) * pixel
            return (
                200,
                {"Content-Type": "image/png"},
                servers.encoded(servers.picture(*numpy.meshgrid(east, north)), "PNG"),
            )

        origin = self.serve(servers.Server(answer))
        self.site(
            {
                "to": "photo.tif",
                "kind": "wmts",
                "url": origin.url + "/WMTSCapabilities.xml",
                "layer": "photo",
                "resolution_m": 1.0,
            }
        )
        self.fetch()
        photo = gdal.Open(str(self.root / "photo.tif"))
        west, gsd, _, north, _, _ = photo.GetGeoTransform()
        self.assertAlmostEqual(gsd, pixel)
        shown, valid = photo.ReadAsArray()[:3].transpose(1, 2, 0), photo.GetRasterBand(1).GetMaskBand().ReadAsArray()
        east, norths = (
            west + (numpy.arange(photo.RasterXSize) + 0.5) * gsd,
            north - (numpy.arange(photo.RasterYSize) + 0.5) * gsd,
        )
        columns, rows = numpy.meshgrid((east - left) // (200 * pixel), (top - norths) // (200 * pixel))
        self.assertEqual(valid[(rows + columns) % 3 == 0].max(), 0)
        self.assertGreater((valid == 255).mean(), 0.5)
        truth = servers.picture(*numpy.meshgrid(east, norths))
        self.assertLess(numpy.abs(shown.astype(int) - truth)[valid == 255].mean(), 3.0)
        self.assertGreater(self.record("photo.tif")["missing_tiles"], 3)


class Build(Case):
    def test_build_fetches_what_is_not_there_first(self):
        origin = self.serve(servers.tile_origin())
        self.site(xyz(origin))
        run = subprocess.run(
            [TOOL, "build", self.root / "site.toml", "-o", self.root / "out"],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(run.returncode, 1)
        self.assertIn("there is no", run.stderr.strip().split("\n")[-1])  # what is not fetched is missed after it
        self.assertTrue((self.root / "photo.mbtiles").exists())


class BadInput(Case):
    def test_a_server_that_answers_html(self):
        origin = self.serve(servers.Server(lambda *_: (200, {"Content-Type": "text/html"}, b"<html>Log in</html>")))
        self.site(xyz(origin))
        self.assertIn("the server answers text/html that is no JPEG, PNG or WebP", self.fails())

    def test_a_server_that_has_no_tile_there(self):
        self.site(xyz(self.serve(servers.tile_origin(absent=lambda *_: True))))
        self.assertIn("the server has none of the", self.fails())

    def test_a_server_that_is_away(self):
        origin = servers.tile_origin()
        origin.close()
        self.site(xyz(origin))
        self.assertRegex(self.fails(), "[Cc]onnect")

    def test_areas_that_have_no_tiles(self):
        origin = self.serve(servers.tile_origin())
        for area, said in (
            ((179.99, 50.0, 180.01, 50.01), "no such place on earth"),
            ((15.0, 85.0, 15.1, 85.2), "UTM ends at 84"),
        ):
            self.site(xyz(origin), area=area)
            self.assertIn(said, self.fails())
        self.assertEqual(origin.log, [])

    def test_absurd_amounts(self):
        self.site(xyz(self.serve(servers.tile_origin()), resolution_m=0.1), area=(12.0, 48.0, 18.0, 51.0))
        said = self.fails(code=2)
        self.assertRegex(said, r"about \d+ million tiles .* say resolution_m = \d+\.\d or take a smaller area")

    def test_tables_that_cannot_be_used(self):
        good = {"to": "photo.mbtiles", "kind": "xyz", "url": "http://127.0.0.1:9/{z}/{x}/{y}"}
        for change, said in (
            ({"kind": "wtms"}, "unknown kind 'wtms', expected one of: wmts, xyz"),
            ({"kind": "wmts"}, "'layer' is missing here"),
            ({"hello": 1}, "'hello' is not known here"),
            ({"url": ""}, "'url' is missing"),
            ({"resolution_m": -1}, "'resolution_m' must be"),
            ({"min_zoom": 9, "max_zoom": 3}, "'max_zoom' must be"),
        ):
            self.site({**good, **change})
            said_line = self.fails()
            self.assertIn(said, said_line)
            self.assertRegex(said_line, r"site.toml:\d+: ")
        for url, said in (
            ("http://127.0.0.1:9/{z}/{x}", "needs {z}, {x} and one of"),
            ("http://127.0.0.1:9/{z}/{x}/{y}/{q}", "has {q}"),
            ("http://127.0.0.1:9/{s}/{z}/{x}/{y}", "subdomains"),
        ):
            self.site({**good, "url": url})
            self.assertIn(said, self.fails(code=2))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""`orthodrive fetch` of sheets: STAC searches, Atom feeds and indices on loopback, with ZIP and JPEG 2000. Usage:
sheets_test.py TOOL [unittest's words]
"""

import functools
import io
import json
import re
import unittest
import urllib.parse
import zipfile

import numpy
import servers
from fetch_test import AREA, Case, heights, make_cog
from osgeo import gdal, osr

SIDE, WEST, NORTH = 400, 549600.0, 5543200.0  # pixels and metres of a sheet; the corner of sheet 0, 0
COLUMNS, ROWS = 5, 5
FAR = (25, 25)


@functools.cache
def to_degrees():
    utm, degrees = osr.SpatialReference(), osr.SpatialReference()
    utm.ImportFromEPSG(32633)
    degrees.ImportFromEPSG(4326)
    for reference in (utm, degrees):
        reference.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return osr.CoordinateTransformation(utm, degrees)


@functools.cache  # servers tell the same places again and again
def lonlat(east, north):
    return to_degrees().TransformPoint(east, north)[:2]


def corners(column, row):
    """Of a sheet, in degrees, closed."""
    west, north = WEST + column * SIDE, NORTH - row * SIDE
    ring = [(west, north), (west, north - SIDE), (west + SIDE, north - SIDE), (west + SIDE, north), (west, north)]
    return [lonlat(*p) for p in ring]


def box(ring):
    return [min(p[0] for p in ring), min(p[1] for p in ring), max(p[0] for p in ring), max(p[1] for p in ring)]


def photo(column, row, shade=0):
    east = WEST + column * SIDE + numpy.arange(SIDE) + 0.5
    north = NORTH - row * SIDE - numpy.arange(SIDE) - 0.5
    return servers.picture(*numpy.meshgrid(east, north)).transpose(2, 0, 1) // (1 + shade)


def zipped(**files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return out.getvalue()


class SheetCase(Case):
    """A photo of 5 x 5 sheets of 400 m, and one far away; GeoTIFF or JPEG 2000."""

    made = {}  # sheets and what becomes of them: the same in all cases

    def sheet(self, column, row, form="tif", array=None, plain=False):
        if array is not None:
            return self.fresh_sheet(column, row, form, array, plain)
        key = (column, row, form, plain)
        if key not in self.made:
            self.made[key] = self.fresh_sheet(column, row, form, photo(column, row), plain)
        return self.made[key]

    def fresh_sheet(self, column, row, form, array, plain):
        file = self.root / f"made.{form}"
        options = ["QUALITY=100", "REVERSIBLE=YES"] if form == "jp2" else ["PROFILE=BASELINE"] if plain else []
        driver = "JP2OpenJPEG" if form == "jp2" else "GTiff"
        content = make_cog(file, array, 1.0, WEST + column * SIDE, NORTH - row * SIDE, driver, options)
        for left in self.root.glob("made.*"):
            left.unlink()
        return content

    def names(self):
        return {(c, r): f"s_{c}_{r}" for c in range(COLUMNS) for r in range(ROWS)} | {FAR: "s_far"}

    def direct(self, form="tif", name="photo.tif", arrays=None):
        """What kind `raster` makes of all the sheets as local files."""
        file = self.root / "direct.tif"
        if arrays is not None:
            return self.fresh_direct(form, arrays)
        if form not in self.made:
            self.made[form] = self.fresh_direct(form, None).read_bytes()
        file.write_bytes(self.made[form])
        return file

    def fresh_direct(self, form, arrays):
        files = []
        for (column, row), sheet in self.names().items():
            if (column, row) != FAR:
                content = self.sheet(column, row, form, arrays and arrays[column, row])
                (self.root / f"{sheet}.{form}").write_bytes(content)
                files.append(f"{sheet}.{form}")
        self.site({"to": "direct.tif", "kind": "raster", "urls": files})
        self.fetch()
        for file in files:
            (self.root / file).unlink()
        return self.root / "direct.tif"

    def assert_same(self, found, direct):
        a, b = gdal.Open(str(found)), gdal.Open(str(direct))
        self.assertEqual(a.GetGeoTransform(), b.GetGeoTransform())
        self.assertEqual(a.GetSpatialRef().IsSame(b.GetSpatialRef()), 1)
        numpy.testing.assert_array_equal(a.ReadAsArray(), b.ReadAsArray())

    def sheets_asked(self, server):
        return sorted({n for path in server.paths() for n in re.findall(r"s_\d_\d", path)})

    def check_result(self, direct, server):
        self.assert_same(self.root / "photo.tif", direct)
        self.assertNotIn("s_far", "".join(server.paths()))
        self.assertFalse((self.root / "photo.tif.fetching").exists())
        record = self.record("photo.tif")
        self.assertEqual((record["licence"], record["attribution"]), ("CC0", "Nobody"))
        truth = gdal.Open(str(self.root / "photo.tif"))
        west, _, _, north, _, _ = truth.GetGeoTransform()
        shown = truth.ReadAsArray()
        east = west + numpy.arange(truth.RasterXSize) + 0.5
        norths = north - numpy.arange(truth.RasterYSize) - 0.5
        picture = servers.picture(*numpy.meshgrid(east, norths)).transpose(2, 0, 1)
        self.assertLess(numpy.abs(shown.astype(int) - picture).mean(), 3.0)
        return record

    def table(self, kind, url, **more):
        return {"to": "photo.tif", "kind": kind, "url": url, "licence": "CC0", "attribution": "Nobody", **more}


def stac_item(server, place, name, **asset):
    ring = corners(*place)
    return {
        "type": "Feature",
        "stac_version": "1.0.0",
        "id": name,
        "geometry": {"type": "Polygon", "coordinates": [ring]},
        "bbox": box(ring),
        "properties": {"datetime": "2022-06-01T00:00:00Z", "proj:epsg": 32633},
        "links": [],
        "assets": {
            "thumbnail": {"href": "./thumb.png", "type": "image/png", "roles": ["thumbnail"]},
            "image": {
                "href": f"{server.url}/files/{name}.tif",
                "type": "image/tiff; application=geotiff",
                "roles": ["data"],
                **asset,
            },
        },
    }


class Stac(SheetCase):
    def server(self, items, only_post=False, page=8, files=None, endless=None):
        """A search in pages by a token, as stac-server and others have it. It does not look at the bbox."""
        files = files or {}

        def answer(method, path, headers, body):
            parts = urllib.parse.urlparse(path)
            if parts.path.startswith("/files/"):
                content = files.get(parts.path)
                return (200, {"Content-Type": "image/tiff"}, content) if content else (404, {}, b"none")
            if not parts.path.endswith(("/search", "/items")):
                return 404, {"Content-Type": "application/json"}, b"{}"
            if only_post and method != "POST":
                return 405, {}, b"{}"
            query = dict(urllib.parse.parse_qsl(parts.query))
            if method == "POST":
                self.assertEqual(headers["Content-Type"], "application/json")
                query = json.loads(body)
            self.queries.append(query)
            first = int(query.get("token", 0))
            all_items = items(origin)
            links = [{"rel": "self", "href": path}]
            if endless or first + page < len(all_items):
                if method == "POST":
                    following = {"method": "POST", "body": {"token": str(first + page)}, "merge": True}
                    links.append({"rel": "next", "href": origin.url + parts.path, **following})
                else:
                    there = urllib.parse.urlencode({**query, "token": first + page})
                    links.append({"rel": "next", "href": "?" + there, "type": "application/geo+json"})
            found = all_items[:page] if endless else all_items[first : first + page]
            reply = {"type": "FeatureCollection", "features": found, "links": links}
            return 200, {"Content-Type": "application/geo+json"}, json.dumps(reply).encode()

        self.queries = []
        origin = self.serve(servers.Server(answer))
        return origin

    def files(self):
        return {f"/files/{n}.tif": self.sheet(*place) for place, n in self.names().items() if place != FAR}

    def items(self, server):
        return [stac_item(server, place, name) for place, name in self.names().items()]

    def test_pages_of_items_become_one_raster(self):
        direct = self.direct()
        origin = self.server(self.items, files=self.files())
        self.site(self.table("stac", origin.url + "/v1?collections=dop", time="2022-01-01T00:00:00Z/.."))
        said = self.fetch()
        record = self.check_result(direct, origin)
        self.assertEqual(len(self.queries), 4)
        for query in self.queries:
            self.assertEqual((query["collections"], query["datetime"]), ("dop", "2022-01-01T00:00:00Z/.."))
            west, south, east, north = map(float, query["bbox"].split(","))
            self.assertTrue(west < AREA[0] < AREA[2] < east and south < AREA[1] < AREA[3] < north)
        self.assertEqual(record["sheets"], len(self.sheets_asked(origin)))
        self.assertLess(record["sheets"], COLUMNS * ROWS)
        self.assertIn(f"photo.tif: {record['sheets']} sheets", said)
        asked = len(origin.log)
        self.assertIn("is there already", self.fetch())
        self.assertEqual(len(origin.log), asked)

    def test_a_server_that_takes_posts_alone(self):
        direct = self.direct()
        origin = self.server(self.items, only_post=True, files=self.files())
        self.site(self.table("stac", origin.url + "/search?collections=a,b"))
        self.fetch()
        self.check_result(direct, origin)
        self.assertEqual([q["collections"] for q in self.queries], [["a", "b"]] * 4)
        self.assertEqual([q.get("token") for q in self.queries], [None, "8", "16", "24"])

    def test_the_newest_of_one_place_and_the_asset_that_is_named(self):
        direct = self.direct()

        def items(server):
            found = self.items(server)
            old = [dict(item, id=item["id"] + "_old") for item in self.items(server)]
            for item in old:
                item["properties"] = {"datetime": "2010-06-01T00:00:00Z", "proj:epsg": 32633}
                item["assets"] = {"rgb": {"href": server.url + "/files/old.tif", "type": "image/tiff"}}
            for item in found:
                item["assets"] = {"rgb": item["assets"]["image"], "cir": item["assets"]["image"]}
            return old + found

        origin = self.server(items, page=100, files=self.files())
        self.site(self.table("stac", origin.url + "/collections/dop"))
        self.assertRegex(self.fails(), r"item s_\d_\d has 2 pictures \(cir, rgb\); say which with layer")
        self.site(self.table("stac", origin.url + "/collections/dop", layer="rbg"))
        self.assertIn("no item of the area has an asset 'rbg'; did you mean 'rgb'", self.fails())
        self.site(self.table("stac", origin.url + "/collections/dop", layer="rgb"))
        self.assertIn("of the same places are left out", self.fetch())
        self.check_result(direct, origin)
        self.assertTrue(all("/collections/dop/items?" in p or "/files/s_" in p for p in origin.paths()))

    def test_a_dry_run_says_how_much_and_leaves_nothing(self):
        def items(server):
            return [stac_item(server, place, name, **{"file:size": 2000000}) for place, name in self.names().items()]

        origin = self.server(items)
        self.site(self.table("stac", origin.url + "/search"))
        self.assertRegex(self.fetch("--dry-run"), r"photo.tif: \d+ sheets, about \d+\.0 MB")
        self.assertEqual([p.name for p in self.root.iterdir()], ["site.toml"])

    def test_what_came_is_kept_when_a_sheet_is_not_there(self):
        direct = self.direct()
        files = self.files()
        hidden = files.pop("/files/s_2_1.tif")
        origin = self.server(self.items, files=files)
        self.site(self.table("stac", origin.url + "/search"))
        said = self.fails()
        self.assertRegex(said, r"photo.tif: sheet \d+ of \d+: http://\S+/s_2_1.tif: HTTP 404 \(not there\)")
        self.assertFalse((self.root / "photo.tif").exists())
        files["/files/s_2_1.tif"] = hidden
        self.fetch()
        self.check_result(direct, origin)
        whole = [path for path, status, _ in origin.log if path.startswith("/files/") and status == 200]
        self.assertEqual(len(whole), len(set(whole)))  # none twice

    def test_what_cannot_be_used(self):
        files = self.files()
        page = b"<!DOCTYPE html><html>Please log in</html>"
        origin = self.server(self.items, files={**files, "/files/s_2_1.tif": page})
        self.site(self.table("stac", origin.url + "/search"))
        self.assertRegex(self.fails(), r"/s_2_1.tif: cannot be read as a raster")
        self.assertFalse([p for p in (self.root / "photo.tif.fetching").iterdir() if "s_2_1" in p.name])
        for href, said in (
            ("file:///etc/passwd.tif", "is 'file:///etc/passwd.tif', which is no address of http or https"),
            ("s3://bucket/a.tif", "is 's3://bucket/a.tif', which is no address"),
            ("/vsicurl/x.tif\n", None),
        ):
            bad = self.server(lambda s, h=href: [stac_item(s, (1, 1), "s_1_1", href=h)])
            self.site(self.table("stac", bad.url + "/search"))
            self.assertIn(said or "HTTP 404", self.fails())
        away = self.server(lambda s: [stac_item(s, FAR, "s_far")])
        self.site(self.table("stac", away.url + "/search"))
        self.assertIn("has no sheet of the area, longitude 15.69", self.fails())
        self.site(self.table("stac", away.url + "/search", to="photo.mbtiles"))
        self.assertIn("name it .tif", self.fails(code=2))

    def test_paging_without_end(self):
        same = self.server(self.items, endless=True)
        self.site(self.table("stac", same.url + "/search"))
        self.assertIn("pages without end: the last 10 brought nothing new", self.fails())
        circle = self.serve(
            servers.Server(
                lambda *_: (200, {}, json.dumps({"features": [], "links": [{"rel": "next", "href": "?a"}]}).encode())
            )
        )
        self.site(self.table("stac", circle.url + "/search"))
        self.assertIn("pages lead round in a circle", self.fails())

    def test_answers_that_are_none(self):
        for content, said in (
            (b"", "is no answer of a STAC search (it is empty)"),
            (b"<html>Log in</html>", "a page of HTML: <html>Log in"),
            (b'{"features": [', "no JSON"),
            (b'{"code": "BadRequest", "description": "bbox is wrong"}', "the server says: bbox is wrong"),
            (b"[" * 100000, "more than 64 levels of JSON"),
            (b"[" + b"0," * 6000000 + b"0]", "more than 5000000 values"),
        ):
            origin = self.serve(servers.Server(lambda *_, c=content: (200, {}, c)))
            self.site(self.table("stac", origin.url + "/search"))
            self.assertIn(said, self.fails())


ATOM = (
    '<?xml version="1.0" encoding="UTF-8"?><feed xmlns="http://www.w3.org/2005/Atom" '
    'xmlns:georss="http://www.georss.org/georss" xmlns:inspire_dls="http://inspire.ec.europa.eu/schemas/inspire_dls/1.0">'
    "<title>{title}</title><id>{title}</id><updated>2022-01-01T00:00:00Z</updated>{body}</feed>"
)


def polygon(ring):
    """GeoRSS: latitude first."""
    return "<georss:polygon>" + " ".join(f"{y:.7f} {x:.7f}" for x, y in ring) + "</georss:polygon>"


def rectangle(west, south, east, north):
    return [(west, south), (east, south), (east, north), (west, north), (west, south)]


REGION = rectangle(15.6, 49.9, 15.8, 50.1)


class Atom(SheetCase):
    def service(self, pages, files):
        def answer(method, path, headers, body):
            if path in pages:
                text = pages[path].replace("SERVER", origin.url)
                return 200, {"Content-Type": "application/atom+xml"}, text.encode()
            return (200, {}, files[path]) if path in files else (404, {}, b"none")

        origin = self.serve(servers.Server(answer))
        return origin

    def entry(self, title, links, ring=REGION, crs="32633", more=""):
        category = f'<category term="http://www.opengis.net/def/crs/EPSG/0/{crs}" label="EPSG:{crs}"/>' if crs else ""
        place = polygon(ring) if ring else ""
        return f"<entry><title>{title}</title><id>{title}</id>{category}{place}{more}{links}</entry>"

    def sections(self, suffix="zip", media="application/zip", order=(0, 1, 2, 3)):
        links = ""
        for place, name in self.names().items():
            b = box(corners(*place))
            bbox = " ".join(f"{b[i]:.7f}" for i in order)
            links += f'<link rel="section" href="files/{name}.{suffix}" type="{media}" length="1000000" bbox="{bbox}"/>'
        return links

    def pages(self, entries, other=""):
        other = other or self.entry("DOP far", '<link rel="section" href="/files/far.zip" type="application/zip"/>')
        alternate = '<link rel="alternate" type="application/atom+xml" href="{}"/>'
        described = '<link rel="describedby" type="application/xml" href="SERVER/metadata.xml"/>'
        return {
            "/service.xml": ATOM.format(
                title="Orthophotos",
                body='<link rel="self" type="application/atom+xml" href="SERVER/service.xml"/>'
                + self.entry("DOP near", described + alternate.format("near/dataset.xml"), crs="")
                + self.entry("DOP far", alternate.format("SERVER/far.xml"), rectangle(3, 40, 4, 41), ""),
            ),
            "/near/dataset.xml": ATOM.format(
                title="DOP near",
                body='<link rel="up" type="application/atom+xml" href="../service.xml"/>' + entries,
            ),
            "/far.xml": ATOM.format(title="DOP far", body=other),
        }

    def zips(self):
        return {
            f"/near/files/{name}.zip": zipped(data__photo_dot_tif=self.sheet(*place), read_me_dot_txt="hello")
            for place, name in self.names().items()
            if place != FAR
        }

    def test_datasets_of_a_service_with_archives(self):
        direct = self.direct()
        files = self.zips()
        for order in ((0, 1, 2, 3), (1, 0, 3, 2)):  # providers write both
            (self.root / "photo.tif").unlink(missing_ok=True)
            origin = self.service(self.pages(self.entry("DOP near, TIFF", self.sections(order=order))), files)
            self.site(self.table("atom", origin.url + "/service.xml"))
            self.fetch()
            record = self.check_result(direct, origin)
            self.assertLess(record["sheets"], COLUMNS * ROWS)
            self.assertNotIn("/far.xml", origin.paths())

    def test_every_sheet_a_dataset_in_jpeg_2000(self):
        direct = self.direct("jp2")
        pages, service = {}, ""
        for place, name in self.names().items():
            link = f'<link href="/jp2/{name}.jp2" rel="alternate" type="image/jp2"/>'
            pages[f"/{name}.xml"] = ATOM.format(title=name, body=self.entry(name, link, corners(*place)))
            service += self.entry(
                name, f'<link rel="alternate" type="application/atom+xml" href="{name}.xml"/>', corners(*place)
            )
        pages["/service.xml"] = ATOM.format(title="sheets", body=service)
        files = {f"/jp2/{n}.jp2": self.sheet(*p, form="jp2") for p, n in self.names().items() if p != FAR}
        origin = self.service(pages, files)
        self.site(self.table("atom", origin.url + "/service.xml"))
        self.fetch()
        self.check_result(direct, origin)

    def test_offers_in_other_systems_and_formats(self):
        direct = self.direct()
        entries = self.entry("UTM 32", self.sections("32.zip"), crs="25832")
        entries += self.entry("UTM 33, ECW", self.sections("ecw", "image/x-ecw"))
        entries = entries + self.entry("UTM 33", self.sections())
        origin = self.service(self.pages(entries), self.zips())
        self.site(self.table("atom", origin.url + "/service.xml", format="image/x-ecw"))
        self.assertIn("HTTP 404", self.fails())
        del origin.log[:]
        self.site(self.table("atom", origin.url + "/service.xml"))
        self.assertIn("in another CRS or format are left out", self.fetch())
        self.check_result(direct, origin)
        self.assertFalse([p for p in origin.paths() if "32.zip" in p or "ecw" in p])

    def test_the_dataset_that_is_named(self):
        direct = self.direct()
        entries = self.entry("CIR 2022", self.sections("cir.zip")) + self.entry("RGB 2022", self.sections())
        origin = self.service(self.pages(entries), self.zips())
        self.site(self.table("atom", origin.url + "/service.xml", layer="pancake"))
        self.assertRegex(self.fails(), "nothing that touches the area is called 'pancake'; there are: .*RGB 2022")
        self.site(self.table("atom", origin.url + "/service.xml", layer="rgb 2022"))
        self.fetch()
        self.check_result(direct, origin)

    def test_archives_with_a_world_file_and_the_system_of_the_feed(self):
        direct = self.direct()
        files = {}
        for (column, row), name in self.names().items():
            tfw = f"1\n0\n0\n-1\n{WEST + column * SIDE + 0.5}\n{NORTH - row * SIDE - 0.5}\n"
            content = self.sheet(column, row, plain=True)
            files[f"/near/files/{name}.zip"] = zipped(a_dot_tif=content, a_dot_tfw=tfw)
        origin = self.service(self.pages(self.entry("DOP near", self.sections())), files)
        self.site(self.table("atom", origin.url + "/near/dataset.xml"))
        self.fetch()
        self.check_result(direct, origin)

    def test_what_cannot_be_used(self):
        bomb = (
            '<!DOCTYPE f [<!ENTITY a "'
            + "x" * 1000
            + '">'
            + "".join(f'<!ENTITY {chr(98 + i)} "{("&" + chr(97 + i) + ";") * 10}">' for i in range(9))
        )
        link = '<link rel="section" type="application/zip" href="{}"/>'

        def feed(links, ring=REGION):
            return ATOM.format(title="t", body=self.entry("e", links, ring))

        down = '<link rel="alternate" type="application/atom+xml" href="{}"/>'
        for pages, said in (
            ({"/a": "<html>no</html>"}, "is no Atom feed (the server answers a page of HTML"),
            ({"/a": "<feed><entry>"}, "is no Atom feed (XML: "),
            ({"/a": '<rss version="2.0"/>'}, "its root is <rss>"),
            ({"/a": bomb + "]><feed><title>&j;</title></feed>"}, "has no sheet of the area"),
            ({"/a": feed(link.format("a.zip"), corners(*FAR))}, "has no sheet"),
            (
                {"/a": feed(link.format("file:///etc/a.zip"))},
                "is 'file:///etc/a.zip', which is no address of http or https",
            ),
            (
                {"/a": feed(down.format("ftp://a/b.xml"))},
                "leads to 'ftp://a/b.xml', which is no address",
            ),
            (
                {"/a": feed("".join(link.format(f"{i}.zip") for i in range(9)))},
                "entry 'e' has more than 8 files and does not say where they lie",
            ),
            (
                {f"/{c}": feed(down.format(n)) for c, n in zip("abcdefg", "bcdefga", strict=True)},
                "leads on to more than 4 feeds below each other",
            ),
            (
                {f"/{c}": feed(down.format(n)) for c, n in zip("ab", "ba", strict=True)},
                "has no sheet of the area",
            ),
            ({"/a": feed(link.format("none.zip"))}, "HTTP 404 (not there)"),
        ):
            origin = self.service(pages, {})
            self.site(self.table("atom", origin.url + "/a"))
            self.assertIn(said, self.fails())
        for content, said in (
            (zipped(read_me_dot_txt="hello"), "is an archive without a raster, it holds read_me.txt"),
            (zipped(a_dot_tif="hello"), "a.zip: a.tif in it cannot be read as a raster"),
            (b"PK\x03\x04" + b"\0" * 500, "a.zip: "),
        ):
            pages = {"/a": feed(link.format("a.zip"))}
            origin = self.service(pages, {"/a.zip": content})
            self.site(self.table("atom", origin.url + "/a"))
            self.assertIn(said, self.fails())


class Index(SheetCase):
    def features(self, address="files/{}.jp2", **more):
        found = []
        for place, name in self.names().items():
            attributes = {"name": name, "preview": f"https://a.b/{name}.jpg", "link": address.format(name), **more}
            geometry = {"type": "Polygon", "coordinates": [corners(*place)]}
            found.append({"type": "Feature", "properties": attributes, "geometry": geometry})
        return {"type": "FeatureCollection", "features": found}

    def jp2s(self, folder="/x/files"):
        return {f"{folder}/{n}.jp2": self.sheet(*p, form="jp2") for p, n in self.names().items() if p != FAR}

    def origin(self, index, files, path="/x/index.geojson"):
        return self.serve(servers.file_origin({**files, path: index}))

    def test_a_geojson_with_sheets_in_jpeg_2000(self):
        direct = self.direct("jp2")
        origin = self.origin(json.dumps(self.features()).encode(), self.jp2s())
        self.site(self.table("sheets", origin.url + "/x/index.geojson"))
        self.fetch()
        record = self.check_result(direct, origin)
        self.assertEqual(record["sheets"], len(self.sheets_asked(origin)))

    def test_indices_in_other_formats_and_systems(self):
        direct = self.direct("jp2")
        plain = self.root / "plain.geojson"
        plain.write_text(json.dumps(self.features()))
        files = self.jp2s()
        for driver, name in (("GPKG", "i.gpkg"), ("ESRI Shapefile", "i.shp"), ("FlatGeobuf", "i.fgb")):
            made = self.root / "made"
            made.mkdir()
            gdal.VectorTranslate(str(made / name), str(plain), format=driver, dstSRS="EPSG:31468", reproject=True)
            content = (made / name).read_bytes()
            path = "/x/" + name
            if driver == "ESRI Shapefile":
                out = io.BytesIO()
                with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
                    for file in sorted(made.iterdir()):
                        archive.write(file, "folder/" + file.name)
                content, path = out.getvalue(), "/x/download?file=index"
            for file in made.iterdir():
                file.unlink()
            made.rmdir()
            (self.root / "photo.tif").unlink(missing_ok=True)
            origin = self.serve(servers.file_origin({**files, path.split("?")[0]: content}))
            self.site(self.table("sheets", origin.url + path))
            self.fetch()
            self.check_result(direct, origin)

    def test_addresses_out_of_a_property_or_a_pattern_and_local_indices(self):
        direct = self.direct("jp2")
        features = self.features(other="https://127.0.0.1:9/{}.zip")
        (self.root / "index.geojson").write_text(json.dumps(features))
        origin = self.origin(b"", self.jp2s())
        self.site(self.table("sheets", "index.geojson", layer=origin.url + "/x/files/{name}.jp2"))
        self.fetch()
        self.check_result(direct, origin)
        (self.root / "photo.tif").unlink()
        whole = self.features(address=origin.url + "/x/files/{}.jp2")
        (self.root / "index.geojson").write_text(json.dumps(whole))
        self.site(self.table("sheets", "index.geojson"))
        self.fetch()
        self.check_result(direct, origin)
        self.site(self.table("sheets", "index.geojson", layer="lnik"))
        self.assertIn("its sheets of the area have no 'lnik'; did you mean 'link'?", self.fails())
        (self.root / "photo.tif").unlink()
        (self.root / "index.geojson").write_text(json.dumps(self.features(address="../../{}.jp2")))
        self.site(self.table("sheets", "index.geojson"))
        self.assertIn("is no address of http or https, and a file of this machine is no page", self.fails())

    def test_terrain_keeps_every_height_and_what_no_sheet_shows_is_invalid(self):
        whole = heights(COLUMNS * SIDE, ROWS * SIDE, 1.0)
        files = {}
        for (column, row), name in self.names().items():
            if (column, row) not in (FAR, (2, 2)):
                part = whole[row * SIDE : (row + 1) * SIDE, column * SIDE : (column + 1) * SIDE]
                files[f"/x/files/{name}.zip"] = zipped(dgm_dot_tif=self.sheet(column, row, array=part))
        features = self.features(address="files/{}.zip")
        features["features"] = [f for f in features["features"] if f["properties"]["name"] != "s_2_2"]
        origin = self.origin(json.dumps(features).encode(), files)
        self.site(
            {"to": "dtm.tif", "kind": "sheets", "url": origin.url + "/x/index.geojson", "vertical_datum": "DHHN2016"}
        )
        self.fetch()
        part = gdal.Open(str(self.root / "dtm.tif"))
        west, _, _, north, _, _ = part.GetGeoTransform()
        column, row = round(west - WEST), round(NORTH - north)
        truth = whole[row : row + part.RasterYSize, column : column + part.RasterXSize].copy()
        truth[2 * SIDE - row : 3 * SIDE - row, 2 * SIDE - column : 3 * SIDE - column] = numpy.nan
        self.assertTrue(numpy.isnan(truth).any())
        numpy.testing.assert_array_equal(part.ReadAsArray(), truth)
        self.assertEqual(self.record("dtm.tif")["vertical_datum"], "DHHN2016")

    def test_a_photo_with_a_hole_is_invalid_there(self):
        files = self.jp2s()
        features = self.features()
        features["features"] = [f for f in features["features"] if f["properties"]["name"] != "s_2_2"]
        origin = self.origin(json.dumps(features).encode(), files)
        self.site(self.table("sheets", origin.url + "/x/index.geojson"))
        self.fetch()
        made = gdal.Open(str(self.root / "photo.tif"))
        valid = made.GetRasterBand(1).GetMaskBand().ReadAsArray()
        west, _, _, north, _, _ = made.GetGeoTransform()
        column, row = round(WEST + 2 * SIDE - west), round(north - NORTH + 2 * SIDE)
        self.assertEqual(valid[row + 5 : row + SIDE - 5, column + 5 : column + SIDE - 5].max(), 0)
        valid[row : row + SIDE, column : column + SIDE] = 255
        self.assertEqual(valid.min(), 255)

    def test_what_cannot_be_used(self):
        vrt = (
            b'<OGRVRTDataSource><OGRVRTLayer name="a"><SrcDataSource>/etc/passwd</SrcDataSource></OGRVRTLayer>'
            b"</OGRVRTDataSource>"
        )
        addresses = b"https://a.b/1.tif\nhttps://a.b/2.tif\n"
        for content, said in (
            (b"", "is empty"),
            (b"<!DOCTYPE html><html>no</html>", "is a page of HTML and no index of sheets"),
            (addresses, "is a list of addresses that says nothing of where the sheets lie"),
            (vrt, "cannot be read as an index of sheets"),
            (zipped(a_dot_txt="hello"), "is an archive without a vector file"),
            (json.dumps(self.features(address="file:///{}.tif")).encode(), "which is no address of http or https"),
            (json.dumps(self.features(address="{}")).encode(), "no property of its sheets is the address of a file"),
            (b'{"type": "FeatureCollection", "features": []}', "has no"),
        ):
            origin = self.origin(content, {})
            self.site(self.table("sheets", origin.url + "/x/index.geojson"))
            self.assertIn(said, self.fails())
        far = self.features()
        far["features"] = far["features"][-1:]
        origin = self.origin(json.dumps(far).encode(), {})
        self.site(self.table("sheets", origin.url + "/x/index.geojson"))
        self.assertIn("has no sheet of the area", self.fails())
        self.site(self.table("sheets", "none.geojson"))
        self.assertIn("none.geojson: no such file", self.fails())

    def test_keys_go_along_to_the_same_host_and_are_shown_nowhere(self):
        origin = self.origin(json.dumps(self.features()).encode(), self.jp2s())
        url = origin.url.replace("//", "//{env:WHO}:{env:WORD}@") + "/x/index.geojson?token={env:WORD}"
        self.site(self.table("sheets", url))
        said = self.fetch(env={"WHO": "me", "WORD": "hush-hush"})
        self.assertNotIn("hush", said + (self.root / "photo.tif.source.json").read_text())
        for path, _, headers in origin.log:
            self.assertEqual(headers["Authorization"], "Basic bWU6aHVzaC1odXNo")
            self.assertIn("token=hush-hush", path)


if __name__ == "__main__":
    unittest.main()

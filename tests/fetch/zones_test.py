#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""`orthodrive fetch` of sheets that differ: two UTM zones that meet in the area, CRSs with and without heights, sheets
that name none, kinds of numbers and of nodata, archives. Usage: zones_test.py TOOL [unittest's words]
"""

import gzip
import io
import json
import unittest
import urllib.parse
import zipfile

import numpy
import servers
from fetch_test import Case
from osgeo import gdal, osr

# Of the site, which lies in zone 33: the ground that the sheets show, and the zones' border.
WEST, EAST, SOUTH, NORTH = 550400, 551200, 5542000, 5542800
BORDER, SIDE = 550800, 200


def reference(code):
    made = osr.SpatialReference()
    made.SetFromUserInput(code)
    made.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return made


def moved(source, target, east, north):
    transform = osr.CoordinateTransformation(reference(source), reference(target))
    points = numpy.array(transform.TransformPoints(numpy.column_stack([east.ravel(), north.ravel()])))
    return points[:, 0].reshape(east.shape), points[:, 1].reshape(east.shape)


def height(east, north):
    """Of a hill, at metres of zone 33."""
    return 200 + 0.08 * (east - WEST) - 0.03 * (north - SOUTH) + 3 * numpy.sin(east / 40) * numpy.cos(north / 55)


def centres(west, north, size, gsd):
    along = (numpy.arange(round(size / gsd)) + 0.5) * gsd
    return numpy.meshgrid(west + along, north - along)


class Sheet:
    """A square north-up sheet with its south-west corner at multiples of its side, in any CRS."""

    def __init__(self, code, west, south, gsd=1.0, size=SIDE):
        self.code, self.west, self.south, self.gsd, self.size = code, west, south, gsd, size
        self.name = f"s_{code[-5:]}_{west}_{south}".replace(":", "_")

    def values(self, of):
        east, north = centres(self.west, self.south + self.size, self.size, self.gsd)
        return of(*moved(self.code, "EPSG:32633", east, north))

    def photo(self):
        return self.values(servers.picture).transpose(2, 0, 1)

    def terrain(self):
        return self.values(height).astype(numpy.float32)

    def corners(self, code="EPSG:4326"):
        w, s, e, n = self.west, self.south, self.west + self.size, self.south + self.size
        x, y = moved(self.code, code, numpy.array([w, e, e, w, w]), numpy.array([s, s, n, n, s]))
        return [[float(a), float(b)] for a, b in zip(x, y, strict=True)]

    def file(self, array, crs="own", nodata=None, driver="GTiff", kind=None):
        bands = array if array.ndim == 3 else array[None]
        kind = kind or (gdal.GDT_Byte if array.dtype == numpy.uint8 else gdal.GDT_Float32)
        memory = gdal.GetDriverByName("MEM").Create("", bands.shape[2], bands.shape[1], bands.shape[0], kind)
        memory.SetGeoTransform((self.west, self.gsd, 0, self.south + self.size, 0, -self.gsd))
        if crs:
            memory.SetSpatialRef(reference(self.code if crs == "own" else crs))
        for i, band in enumerate(bands):
            memory.GetRasterBand(i + 1).WriteArray(band)
            if nodata is not None:
                memory.GetRasterBand(i + 1).SetNoDataValue(nodata)
        path = f"/vsimem/made.{'asc' if driver == 'AAIGrid' else 'xyz' if driver == 'XYZ' else 'tif'}"
        gdal.GetDriverByName(driver).CreateCopy(path, memory)
        handle = gdal.VSIFOpenL(path, "rb")
        content = bytes(gdal.VSIFReadL(1, gdal.VSIStatL(path).size, handle))
        gdal.VSIFCloseL(handle)
        for left in gdal.ReadDir("/vsimem/") or []:
            gdal.Unlink("/vsimem/" + left)
        return content

    def world_file(self):
        return f"{self.gsd}\n0\n0\n-{self.gsd}\n{self.west + self.gsd / 2}\n{self.south + self.size - self.gsd / 2}\n"


def of_zone_33(end=BORDER):
    return [Sheet("EPSG:32633", w, s) for w in range(WEST, end, SIDE) for s in range(SOUTH, NORTH, SIDE)]


def of_zone_32():
    """All that show something east of the border, some of it west of it, too."""
    corners = [Sheet("EPSG:32633", BORDER, south, size=EAST - BORDER) for south in (SOUTH, NORTH - EAST + BORDER)]
    x = [p[0] for c in corners for p in c.corners("EPSG:32632")]
    y = [p[1] for c in corners for p in c.corners("EPSG:32632")]
    found = []
    for west in range(int(min(x) // SIDE * SIDE), int(max(x)) + 1, SIDE):
        for south in range(int(min(y) // SIDE * SIDE) - SIDE, int(max(y)) + 2 * SIDE, SIDE):
            sheet = Sheet("EPSG:32632", west, south)
            if max(p[0] for p in sheet.corners("EPSG:32633")) > BORDER:
                found.append(sheet)
    return found


def zipped(files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return out.getvalue()


class Zones(Case):
    def site(self, *tables):
        """The middle of the ground, 120 m inside: 100 m around the area are read."""
        x = numpy.array([WEST + 120.0, EAST - 120.0])
        lon, lat = moved("EPSG:32633", "EPSG:4326", x, numpy.array([SOUTH + 120.0, NORTH - 120.0]))
        return super().site(*tables, area=[float(v) for v in (lon[0], lat[0], lon[1], lat[1])])

    def read(self, name):
        made = gdal.Open(str(self.root / name))
        left, gsd, _, top, _, _ = made.GetGeoTransform()
        code = made.GetSpatialRef().GetAuthorityCode(None)
        east, north = numpy.meshgrid(
            left + (numpy.arange(made.RasterXSize) + 0.5) * gsd, top - (numpy.arange(made.RasterYSize) + 0.5) * gsd
        )
        return made, code, east, north

    def stac(self, sheets, files):
        """A search whose items name their CRS, two thirds of the ways that there are."""

        def answer(method, path, headers, body):
            parts = urllib.parse.urlparse(path).path
            if parts in files:
                return 200, {"Content-Type": "image/tiff"}, files[parts]
            if not parts.endswith("/search"):
                return 404, {}, b""
            features = []
            for i, sheet in enumerate(sheets):
                number = int(sheet.code[5:])
                features.append(
                    {
                        "id": sheet.name,
                        "geometry": {"type": "Polygon", "coordinates": [sheet.corners()]},
                        "properties": {"datetime": "2023-01-01" if number == 32633 else "2022-01-01"}
                        | ([{"proj:epsg": number}, {"proj:code": sheet.code}, {}][i % 3]),
                        "assets": {
                            f"{sheet.name}_1_m.tif": {
                                "href": f"{origin.url}/{sheet.name}.tif",
                                "type": "image/tiff; application=geotiff",
                                "proj:epsg": number,
                            },
                            f"{sheet.name}_1_m.xyz.zip": {"href": "no.zip", "type": "application/zip"},
                        },
                    }
                )
            return 200, {}, json.dumps({"type": "FeatureCollection", "features": features}).encode()

        origin = self.serve(servers.Server(answer))
        return origin

    def index(self, sheets, files, suffix):
        features = [
            {
                "type": "Feature",
                "geometry": {"type": "Polygon", "coordinates": [sheet.corners()]},
                "properties": {
                    "file": f"../x/{sheet.name}{suffix}",
                    "flown": "2023-05-01" if sheet.code.endswith("33") else "2022-05-01",
                },
            }
            for sheet in sheets
        ]
        page = json.dumps({"type": "FeatureCollection", "features": features}).encode()
        return self.serve(servers.file_origin({**files, "/x/index.geojson": page}))

    def check_terrain(self, name="dtm.tif", exact_until=BORDER, holes=False):
        made, code, east, north = self.read(name)
        self.assertEqual(code, "32633")
        heights, truth = made.ReadAsArray(), height(east, north)
        valid = ~numpy.isnan(heights)
        if not holes:
            self.assertTrue(valid.all())
        west = valid & (east < exact_until)
        numpy.testing.assert_array_equal(heights[west], truth[west].astype(numpy.float32))
        self.assertLess(numpy.abs(heights - truth)[valid].max(), 0.01)
        return made, valid, east, north

    def test_a_photo_of_two_zones_in_a_search(self):
        sheets = of_zone_32() + of_zone_33()
        files = {f"/{s.name}.tif": s.file(s.photo()) for s in sheets}
        origin = self.stac(sheets, files)
        table = {"to": "photo.tif", "kind": "stac", "url": origin.url + "/search", "layer": "*_1_m.tif"}
        self.site(table)
        self.fetch()
        made, code, east, north = self.read("photo.tif")
        self.assertEqual(code, "32633")
        bands = made.ReadAsArray()
        self.assertEqual(made.GetRasterBand(1).GetMaskBand().ReadAsArray().min(), 255)
        off = numpy.abs(bands[:3].astype(int) - servers.picture(east, north).transpose(2, 0, 1))
        for side in (east < BORDER - 1, east > BORDER + 1, numpy.abs(east - BORDER) < 5):
            self.assertGreater(side.sum(), 5000)
            self.assertLess(off[:, side].mean(), 4.0)
            self.assertLess(numpy.percentile(off[:, side], 99.5), 25)
        asked = {p.split("/")[-1] for p in origin.paths() if p.endswith(".tif")}
        self.assertTrue(any("32632" in name for name in asked) and any("32633" in name for name in asked))
        # A pattern that fits several assets is refused, one that fits none tells what there is.
        (self.root / "photo.tif").unlink()
        self.site({**table, "layer": "*_1_m*"})
        self.assertRegex(self.fails(), r"has 2 pictures \(s_.*; say which with layer")
        self.site({**table, "layer": "*_2_m.tif"})
        self.assertIn("no item of the area has an asset '*_2_m.tif'", self.fails())

    def test_terrain_of_two_zones_by_an_index_that_does_not_say_so(self):
        sheets = of_zone_32() + of_zone_33()
        files = {f"/x/{s.name}.zip": zipped({"a/dgm.tif": s.file(s.terrain())}) for s in sheets}
        origin = self.index(sheets, files, ".zip")
        self.site(
            {"to": "dtm.tif", "kind": "sheets", "url": origin.url + "/x/index.geojson", "vertical_datum": "DHHN2016"}
        )
        self.fetch()
        made, _, _, _ = self.check_terrain()
        self.assertEqual(made.GetMetadataItem("VERTICAL_DATUM"), "DHHN2016")
        self.assertFalse([p.name for p in self.root.iterdir() if "drawn" in p.name])

    def test_terrain_of_two_zones_as_local_files_and_coarser(self):
        names = []
        for sheet in of_zone_33() + of_zone_32():
            (self.root / f"{sheet.name}.tif").write_bytes(sheet.file(sheet.terrain()))
            names.append(f"{sheet.name}.tif")
        table = {"to": "dtm.tif", "kind": "raster", "urls": names, "vertical_datum": "d"}
        self.site(table)
        self.fetch()
        self.check_terrain()
        self.site({**table, "resolution_m": 4.0})
        self.fetch()
        made, code, east, north = self.read("dtm.tif")
        self.assertEqual((code, made.GetGeoTransform()[1]), ("32633", 4.0))
        self.assertLess(numpy.abs(made.ReadAsArray() - height(east, north)).max(), 0.15)

    def test_holes_and_the_first_on_top(self):
        """The first raster covers the later ones, whatever their zones; what none shows is invalid."""
        x, y = moved("EPSG:32633", "EPSG:32632", numpy.array([550700.0]), numpy.array([5542400.0]))
        low = Sheet("EPSG:32632", int(x[0]), int(y[0]) - 1000, size=2000)
        top = Sheet("EPSG:32633", 550600, 5542200)
        (self.root / "top.tif").write_bytes(top.file(numpy.full((200, 200), 5.0, numpy.float32)))
        (self.root / "low.tif").write_bytes(low.file(numpy.full((2000, 2000), 7.0, numpy.float32)))
        for names, inside in ((["top.tif", "low.tif"], 5.0), (["low.tif", "top.tif"], 7.0)):
            self.site({"to": "dtm.tif", "kind": "raster", "urls": names, "vertical_datum": "d"})
            self.fetch()
            made, _, east, north = self.read("dtm.tif")
            heights = made.ReadAsArray()
            covered = (east > 550601) & (east < 550799) & (north > 5542201) & (north < 5542399)
            x, y = moved("EPSG:32633", "EPSG:32632", east, north)
            shown = x > low.west + 2
            self.assertTrue((covered & shown).any() and (covered & (x < low.west - 2)).any())
            self.assertTrue((heights[covered & shown] == inside).all())
            numpy.testing.assert_allclose(heights[shown & (east > 550802)], 7.0, atol=1e-4)
            far = (x < low.west - 2) & ((east < 550598) | (north < 5542198) | (north > 5542402))
            self.assertTrue(numpy.isnan(heights[far]).all())

    def test_with_and_without_heights_or_a_name(self):
        """One CRS for the map: some sheets name a height system beside it, some nothing at all."""
        sheets = of_zone_33(EAST)
        crs = ["EPSG:32633+5773", "own", None]
        files = {f"/x/{s.name}.tif": s.file(s.terrain(), crs[i % 3]) for i, s in enumerate(sheets)}
        origin = self.index(sheets, files, ".tif")
        self.site({"to": "dtm.tif", "kind": "sheets", "url": origin.url + "/x/index.geojson"})
        self.fetch()
        made, _, _, _ = self.check_terrain(exact_until=EAST)
        self.assertIn("EGM96", made.GetMetadataItem("VERTICAL_DATUM"))

    def test_kinds_of_numbers_and_of_nodata(self):
        """Whole metres become integers in text files, and every sheet has a sign of its own for what it lacks."""
        sheets = of_zone_33(EAST)
        files = {}
        for i, sheet in enumerate(sheets):
            array = sheet.terrain()
            nodata = [-9999.0, -32767.0, 0.0, None][i % 4]
            if nodata is not None:
                array[:20, :30] = nodata
            if i % 5 == 4:
                files[f"/x/{sheet.name}.tif"] = sheet.file(
                    numpy.round(array).astype(numpy.int16), nodata=nodata, kind=gdal.GDT_Int16
                )
            else:
                files[f"/x/{sheet.name}.tif"] = sheet.file(array, nodata=nodata)
        origin = self.index(sheets, files, ".tif")
        self.site({"to": "dtm.tif", "kind": "sheets", "url": origin.url + "/x/index.geojson", "vertical_datum": "d"})
        self.fetch()
        made, _, east, north = self.read("dtm.tif")
        heights, truth = made.ReadAsArray(), height(east, north)
        for i, sheet in enumerate(sheets):
            of = (east > sheet.west) & (east < sheet.west + SIDE) & (north > sheet.south) & (north < sheet.south + SIDE)
            corner = of & (north > sheet.south + SIDE - 20) & (east < sheet.west + 30)
            rest = of & ~corner
            if not rest.any():
                continue
            if i % 4 != 3:
                self.assertTrue(numpy.isnan(heights[corner]).all(), sheet.name)
            if i % 5 == 4:
                numpy.testing.assert_array_equal(heights[rest], numpy.round(truth[rest].astype(numpy.float32)))
            else:
                numpy.testing.assert_array_equal(heights[rest], truth[rest].astype(numpy.float32))

    def test_archives_of_text_with_the_system_in_the_table(self):
        """Squares of a grid: several sheets and folders per archive, ASC, XYZ and TIFF with a world file; some squares
        are not on the server; what has no .prj has the CRS of the table."""
        files, squares = {}, []
        sheets = of_zone_33(EAST)
        for i in range(0, len(sheets), 2):
            content = {"read_me.txt": "hello", "deep/er/info.csv": "a;b"}
            for sheet in sheets[i : i + 2]:
                form = ("AAIGrid", "XYZ", "GTiff", "prj")[i // 2 % 4]
                array = sheet.terrain()
                if form == "AAIGrid":
                    content[f"deep/er/{sheet.name}.asc"] = sheet.file(array, None, driver="AAIGrid")
                elif form == "XYZ":
                    east, north = centres(sheet.west, sheet.south + SIDE, SIDE, 1.0)
                    rows = numpy.column_stack([east.ravel(), north.ravel(), array.ravel()])
                    content[f"{sheet.name}.xyz"] = "\n".join(f"{x:.2f} {y:.2f} {z:.5f}" for x, y, z in rows)
                elif form == "GTiff":
                    plain = gdal.GetDriverByName("GTiff").Create("/vsimem/p.tif", SIDE, SIDE, 1, gdal.GDT_Float32)
                    plain.GetRasterBand(1).WriteArray(array)
                    plain = None
                    handle = gdal.VSIFOpenL("/vsimem/p.tif", "rb")
                    content[f"a/{sheet.name}.tif"] = bytes(gdal.VSIFReadL(1, 10_000_000, handle))
                    gdal.VSIFCloseL(handle)
                    content[f"a/{sheet.name}.tfw"] = sheet.world_file()
                else:
                    content[f"{sheet.name}.asc"] = sheet.file(array, None, driver="AAIGrid")
                    content[f"{sheet.name}.prj"] = reference("EPSG:32633").ExportToWkt()
            files[f"/x/{i}.zip"] = zipped(content)
            squares.append(f"{i}.zip")
        origin = self.serve(servers.file_origin(files))
        urls = [origin.url + "/x/" + name for name in [*squares, "77.zip", "78.zip"]]
        table = {"to": "dtm.tif", "kind": "sheets", "urls": urls, "vertical_datum": "d"}
        self.site({**table, "crs": "EPSG:32633"})
        self.assertIn(f"{len(urls)} sheets, 2 are not on the server", self.fetch())
        made, code, east, north = self.read("dtm.tif")
        self.assertEqual(code, "32633")
        self.assertLess(numpy.abs(made.ReadAsArray() - height(east, north)).max(), 0.001)
        self.assertEqual(self.record("dtm.tif")["sheets"], len(squares))
        # Another CRS of the table is another request. In a wrong one the area has none of the sheets that name none.
        self.site({**table, "urls": urls[:1], "crs": "EPSG:32631"})
        self.assertIn("shows nothing of the area", self.fails())
        self.site({**table, "urls": urls[-2:], "crs": "EPSG:32633"})
        self.assertIn("none of its sheets is there", self.fails())
        self.site({**table, "crs": "EPSG:1"})
        self.assertIn("crs", self.fails())
        self.site({"to": "a.mbtiles", "kind": "xyz", "url": origin.url + "/{z}/{x}/{y}", "crs": "EPSG:32633"})
        self.assertIn("crs", self.fails())

    def test_gzip(self):
        sheets = of_zone_33(EAST)
        files = {f"/x/{s.name}.asc.gz": gzip.compress(s.file(s.terrain(), None, driver="AAIGrid")) for s in sheets}
        origin = self.serve(servers.file_origin(files))
        self.site(
            {
                "to": "dtm.tif",
                "kind": "sheets",
                "urls": [origin.url + name for name in files],
                "crs": "EPSG:32633",
                "vertical_datum": "d",
            }
        )
        self.fetch()
        made, _, east, north = self.read("dtm.tif")
        self.assertLess(numpy.abs(made.ReadAsArray() - height(east, north)).max(), 0.001)

    def test_what_does_not_go_together(self):
        one, other = of_zone_33()[0], of_zone_32()[0]
        for first, second, said in (
            (one.file(one.photo()), other.file(other.terrain()), "is no picture, and .* is one"),
            (one.file(one.terrain(), None), other.file(other.terrain(), None), "names no CRS, and neither does its"),
        ):
            (self.root / "a.tif").write_bytes(first)
            (self.root / "b.tif").write_bytes(second)
            self.site({"to": "dtm.tif", "kind": "raster", "urls": ["a.tif", "b.tif"]})
            self.assertRegex(self.fails(), said)


if __name__ == "__main__":
    unittest.main()

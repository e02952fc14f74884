# SPDX-License-Identifier: Apache-2.0
"""A site on this machine as the servers of its site file would give it: WMTS (a quad in web mercator, REST), an
interpreter of Overpass, terrain by ranges. Stands in for servers that a test cannot reach.
"""

import collections
import pathlib
import re
import threading
import tomllib

import servers
from osgeo import gdal

gdal.UseExceptions()
BLOCK = 8  # tiles a side that are warped at once
MATRIX = (
    "<TileMatrix><ows:Identifier>{z}</ows:Identifier><ScaleDenominator>{scale}</ScaleDenominator>"
    f"<TopLeftCorner>{-servers.HALF} {servers.HALF}</TopLeftCorner><TileWidth>256</TileWidth>"
    "<TileHeight>256</TileHeight><MatrixWidth>{count}</MatrixWidth><MatrixHeight>{count}</MatrixHeight></TileMatrix>"
)


def capabilities(table, finest_zoom):
    """The layer that the site file asks for; SERVER stands for the address."""
    matrices = "".join(
        MATRIX.format(z=z, scale=2 * servers.HALF / 256 / 2**z / 0.00028, count=2**z) for z in range(finest_zoom + 1)
    )
    return (
        '<Capabilities xmlns="http://www.opengis.net/wmts/1.0" xmlns:ows="http://www.opengis.net/ows/1.1"><Contents>'
        f'<Layer><ows:Identifier>{table["layer"]}</ows:Identifier><Style isDefault="true"><ows:Identifier>'
        f"{table['style']}</ows:Identifier></Style><Format>{table['format']}</Format><TileMatrixSetLink>"
        f"<TileMatrixSet>{table['tile_matrix_set']}</TileMatrixSet></TileMatrixSetLink>"
        f'<ResourceURL format="{table["format"]}" resourceType="tile" '
        'template="SERVER/tiles/{TileMatrix}/{TileRow}/{TileCol}.jpeg"/></Layer>'
        f"<TileMatrixSet><ows:Identifier>{table['tile_matrix_set']}</ows:Identifier>"
        f"<ows:SupportedCRS>urn:ogc:def:crs:EPSG::3857</ows:SupportedCRS>{matrices}</TileMatrixSet></Contents>"
        "</Capabilities>"
    )


class Tiles:
    """Of a photo, warped a block at a time."""

    def __init__(self, photo):
        self.photo, self.lock, self.blocks = gdal.Open(str(photo)), threading.Lock(), collections.OrderedDict()

    def block(self, z, x, y):
        if (z, x, y) not in self.blocks:
            side = 2 * servers.HALF / 2**z * BLOCK
            west, north = -servers.HALF + x * side, servers.HALF - y * side
            warped = gdal.Warp(
                "",
                self.photo,
                format="MEM",
                dstSRS="EPSG:3857",
                outputBounds=(west, north - side, west + side, north),
                width=256 * BLOCK,
                height=256 * BLOCK,
                resampleAlg="bilinear",
            )
            self.blocks[z, x, y] = warped.ReadAsArray()[:3].transpose(1, 2, 0)
            if len(self.blocks) > 32:
                self.blocks.popitem(last=False)
        return self.blocks[z, x, y]

    def jpeg(self, z, x, y):
        with self.lock:
            pixels = self.block(z, x // BLOCK, y // BLOCK)
        row, column = 256 * (y % BLOCK), 256 * (x % BLOCK)
        return servers.encoded(pixels[row : row + 256, column : column + 256])


def serve(site_file, folder, finest_zoom=19):
    """Servers, and the text of the site file with their addresses in place of its own. `folder` is a synthetic site."""
    text = pathlib.Path(site_file).read_text()
    tables = {table["kind"]: table for table in tomllib.loads(text)["fetch"]}
    tiles, roads = Tiles(folder / "ortho.tif"), (folder / "roads.osm").read_bytes()

    def answer(method, path, headers, body):
        if path.endswith("/interpreter"):
            return 200, {"Content-Type": "application/osm3s+xml"}, roads
        if path.endswith(".xml"):
            xml = capabilities(tables["wmts"], finest_zoom).replace("SERVER", main.url)
            return 200, {"Content-Type": "text/xml"}, xml.encode()
        found = re.fullmatch(r"/tiles/(\d+)/(\d+)/(\d+)\.jpeg", path)
        if not found:
            return 404, {}, b"no such page"
        z, row, column = map(int, found.groups())
        return 200, {"Content-Type": "image/jpeg"}, tiles.jpeg(z, column, row)

    main = servers.Server(answer)
    terrain = servers.file_origin({"/dtm.tif": (folder / "dtm_1m.tif").read_bytes()})
    for table, address in (
        (tables["wmts"], main.url + "/WMTSCapabilities.xml"),
        (tables["overpass"], main.url + "/interpreter"),
        (tables["cog"], terrain.url + "/dtm.tif"),
    ):
        text = text.replace(table["url"], address)
    return [main, terrain], text

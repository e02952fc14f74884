#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""item.json of a build is what STAC 1.0.0 asks of an item, and says what is true of the folder.

Usage: stac_item.py BUILT_FOLDER. The rules are those of the item specification (github.com/radiantearth/stac-spec,
item-spec/item-spec.md) and of the projection extension 1.1.0, written down here: there is no network in tests.
"""

import json
import pathlib
import re
import sys

from osgeo import gdal, ogr, osr

gdal.UseExceptions()
ogr.UseExceptions()
RFC3339 = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")
MEDIA = re.compile(r"[a-z]+/[a-z0-9.+-]+(; [a-z]+=[a-z-]+)*")


def check(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def check_item(item):
    required = {"type", "stac_version", "id", "geometry", "bbox", "properties", "links", "assets", "stac_extensions"}
    check(item.keys() == required, f"keys {sorted(item)}")
    check(item["type"] == "Feature" and item["stac_version"] == "1.0.0", "type and version")
    check(re.fullmatch(r"[a-z0-9_-]+", item["id"]), f"id {item['id']}")
    check(all(e.startswith("https://") and e.endswith("/schema.json") for e in item["stac_extensions"]), "extensions")
    check(isinstance(item["links"], list), "links")
    properties = item["properties"]
    if properties["datetime"] is None:
        check(all(RFC3339.fullmatch(properties[k]) for k in ("start_datetime", "end_datetime")), "no time at all")
    else:
        check(RFC3339.fullmatch(properties["datetime"]), f"datetime {properties['datetime']}")
    check(
        all(
            p["name"] and set(p["roles"]) <= {"licensor", "producer", "processor", "host"}
            for p in properties["providers"]
        ),
        "providers",
    )
    for key, asset in item["assets"].items():
        check(asset.keys() == {"href", "title", "type", "roles"}, f"asset {key}: {sorted(asset)}")
        check(MEDIA.fullmatch(asset["type"]), f"asset {key}: type {asset['type']}")
        check(set(asset["roles"]) <= {"data", "metadata", "overview", "thumbnail"}, f"asset {key}: roles")


def check_truth(item, folder):
    for key, asset in item["assets"].items():
        check((folder / asset["href"]).is_file(), f"asset {key}: {asset['href']} is not there")
    check({"labels", "roads", "opendrive", "tiles3d", "report", "run"} <= item["assets"].keys(), "assets are missing")
    geometry = ogr.CreateGeometryFromJson(json.dumps(item["geometry"]))
    check(geometry.IsValid() and geometry.GetGeometryName() == "POLYGON", "geometry")
    west, east, south, north = geometry.GetEnvelope()
    check(
        max(abs(a - b) for a, b in zip(item["bbox"], (west, south, east, north), strict=True)) < 1e-6,
        "bbox is not that of the geometry",
    )
    ring = item["geometry"]["coordinates"][0]
    check(ring[0] == ring[-1], "ring is not closed")
    # The labels lie where the item says, in the CRS that it says.
    labels = gdal.Open(str(folder / "labels.tif"))
    reference = osr.SpatialReference(wkt=labels.GetProjection())
    check(
        reference.GetAuthorityCode(None) == str(item["properties"]["proj:epsg"]), "proj:epsg is not that of the labels"
    )
    x, step, _, y, _, down = labels.GetGeoTransform()
    box = (x, y + down * labels.RasterYSize, x + step * labels.RasterXSize, y)
    off = max(abs(a - b) for a, b in zip(box, item["properties"]["proj:bbox"], strict=True))
    check(off < 2.0, f"proj:bbox is {off} m off the labels")


folder = pathlib.Path(sys.argv[1])
if not (folder / "run.json").exists():
    print(f"SKIPPED: {folder} was not built")
    sys.exit(77)
item = json.loads((folder / "item.json").read_text())
check_item(item)
check_truth(item, folder)


def expect_refused(item, break_it):
    """The check itself finds what is wrong."""
    broken = json.loads(json.dumps(item))
    break_it(broken)
    try:
        check_item(broken)
    except (SystemExit, KeyError):
        return
    sys.exit("FAILED: a broken item passes")


expect_refused(item, lambda broken: broken.pop("bbox"))
expect_refused(item, lambda broken: broken["properties"].update(datetime="today"))
expect_refused(item, lambda broken: broken["properties"].update(datetime=None, start_datetime="yesterday"))
expect_refused(item, lambda broken: broken["assets"]["labels"].update(type="tif"))
print(f"item.json: {len(item['assets'])} assets")

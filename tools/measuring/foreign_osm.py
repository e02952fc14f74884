# SPDX-License-Identifier: Apache-2.0
"""Junctions of other towns: extracts of OSM that users of other tools have found hard (../shared/foreign/osm), on a
made-up hill and without a photo: the verdict of `evaluate network` on each, and its lanes and limits beside those of
netconvert (foreign_lanes.py). Writes docs/measured/foreign_osm.md. Needs Debian's python3-gdal, python3-numpy and sumo.
"""

import statistics
import subprocess
import xml.etree.ElementTree as ET

import numpy as np
from osgeo import gdal, osr

from measuring.common import (
    PAGES,
    ROOT,
    Tool,
    add_only,
    add_table,
    add_tool,
    commit,
    fixed,
    header,
    read_results,
    row,
    write_page,
    write_results,
)
from measuring.foreign_lanes import lanes_part, measure_lanes
from measuring.verdict import KINDS

STORES = {"verdict": "foreign_osm.json", "lanes": "foreign_lanes.json"}
PAGE = PAGES / "foreign_osm.md"
EXTRACTS = ROOT.parent / "shared/foreign/osm"
FARTHEST_M, MARGIN_M = 1500.0, 100.0  # nodes further off belong to ways that leave the extract
TERRAIN_M, LABELS_M = 5.0, 1.0


def add_arguments(parser):
    add_tool(parser, "out/foreign_osm")
    add_only(parser, STORES)
    add_table(parser)


def utm_of(lon, lat):
    result = osr.SpatialReference()
    result.ImportFromEPSG((32600 if lat > 0 else 32700) + int((lon + 180) // 6) + 1)
    return result


def places_of(extract):
    """x and y of the nodes around the middle, in the UTM zone there, and that zone."""
    nodes = [n for n in ET.parse(extract).getroot().iter("node") if n.get("lon")]
    lonlat = [(float(n.get("lon")), float(n.get("lat"))) for n in nodes]
    utm, degrees = utm_of(*(statistics.median(v) for v in zip(*lonlat, strict=True))), osr.SpatialReference()
    degrees.ImportFromEPSG(4326)
    for crs in (utm, degrees):
        crs.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    places = np.array(osr.CoordinateTransformation(degrees, utm).TransformPoints(lonlat))[:, :2]
    return places[np.abs(places - np.median(places, axis=0)).max(axis=1) < FARTHEST_M], utm


def write_raster(file, box, pixel_m, crs, values, classes=None):
    """values: of x and y from the upper left corner, m."""
    west, south, east, north = box
    x, y = np.meshgrid(np.arange(west, east, pixel_m) - west, north - np.arange(north, south, -pixel_m))
    kind = gdal.GDT_Byte if classes else gdal.GDT_Float32
    raster = gdal.GetDriverByName("GTiff").Create(str(file), x.shape[1], x.shape[0], 1, kind)
    raster.SetGeoTransform((west, pixel_m, 0, north, 0, -pixel_m))
    raster.SetProjection(crs.ExportToWkt())
    raster.GetRasterBand(1).WriteArray(values(x, y))
    if classes:
        raster.SetMetadataItem("ORTHODRIVE_CLASSES", classes)
    raster.FlushCache()


def build(tool, extract, folder, classes):
    """roads.xodr of an extract."""
    places, utm = places_of(extract)
    box = [*np.floor(places.min(axis=0) - MARGIN_M), *np.ceil(places.max(axis=0) + MARGIN_M)]
    folder.mkdir(parents=True, exist_ok=True)
    hill = folder / "dtm.tif"
    write_raster(hill, box, TERRAIN_M, utm, lambda x, y: 50.0 + 4.0 * np.sin(x / 180.0) + 3.0 * np.cos(y / 140.0))
    write_raster(folder / "labels.tif", box, LABELS_M, utm, lambda x, _: np.zeros(x.shape), classes)
    tool("refine", "--method", "none", "--osm", extract, "--labels", folder / "labels.tif", "-o", folder / "lines.gpkg")
    tool("elevate", "--roads", folder / "lines.gpkg", "--dtm", hill, "-o", folder / "roads.gpkg")
    tool("network", "--roads", folder / "roads.gpkg", "-o", folder / "roads.xodr")
    return folder / "roads.xodr"


def measure_verdict(tool, xodr):
    scores = tool.json("evaluate", "network", xodr, "--json")
    return {key: scores[key] for key in ("length_m", "junctions", "broken_links", "lane_link_errors", "verdict")}


def faults_of(verdict):
    """ "step 591 mm (1)", one after the other."""
    texts = []
    for kind, (unit, factor, digits) in KINDS.items():
        if verdict[kind]["places"]:
            worst = fixed(factor * verdict[kind]["worst"], digits)
            texts.append(f"{kind.replace('_', ' ')} {worst} {unit} ({verdict[kind]['places']})")
    return ", ".join(texts)


ABOUT = """# Measured: junctions of other towns

`tools/measure foreign-osm` writes this page. Extracts of OSM that users of other tools have found hard, on a made-up
hill (waves of 4 m over 1.1 km and 3 m over 0.9 km) and without a photo: `refine --method none`, `elevate`, `network`.
Widths are those of tags and classes. The verdict is that of [evaluate.md](../evaluate.md): worst value and number of
places of each kind over its limit.

"""


def verdict_part(extracts):
    passed = sum(n["verdict"]["pass"] for n in extracts.values())
    text = f"{ABOUT}**The verdict is pass in {passed} of {len(extracts)}** (asked: in all).\n\n"
    text += header(["extract", "km", "junctions", "broken links, lane links", "verdict", "faults: worst (places)"])
    for name, n in extracts.items():
        verdict = "pass" if n["verdict"]["pass"] else "FAIL"
        links = f"{n['broken_links']}, {n['lane_link_errors']}"
        text += row([name, fixed(n["length_m"] / 1000, 1), n["junctions"], links, verdict, faults_of(n["verdict"])])
    return text


def measure(args):
    gdal.UseExceptions()
    tool, found = Tool(args.tool), {part: {} for part in args.only}
    small = tool.synth(args.out / "synth", "--preset", "village", "--size", "200", "--gsd", "1")
    classes = gdal.Open(str(small / "truth/labels.tif")).GetMetadataItem("ORTHODRIVE_CLASSES")
    for extract in sorted(EXTRACTS.glob("*.osm")):
        name, folder = extract.stem, args.out / extract.stem
        try:
            xodr = build(tool, extract, folder, classes)
            if "verdict" in found:
                found["verdict"][name] = measure_verdict(tool, xodr)
                print(name, "pass" if found["verdict"][name]["verdict"]["pass"] else "FAIL", flush=True)
            if "lanes" in found:
                found["lanes"][name] = measure_lanes(extract, xodr, folder)
        except subprocess.CalledProcessError as failed:
            raise SystemExit(f"{extract.name}: {failed}") from failed
    for part, extracts in found.items():
        write_results(STORES[part], {"commit": commit(), "extracts": extracts})


def run(args):
    if not args.table:
        measure(args)
    verdicts, lanes = (read_results(store, {"extracts": {}})["extracts"] for store in STORES.values())
    text = verdict_part(verdicts) + ("\n" + lanes_part(lanes) if lanes else "")
    write_page(PAGE, list(STORES.values()), text)

#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The outputs of a build open in QGIS, and QGIS draws them with the styles beside them, without anybody asking.

Usage: qgis_styles.py BUILT_FOLDER. Exit code 77: QGIS is not here (tools/setup --peers installs it).
"""

import json
import os
import pathlib
import shutil
import sys
import tempfile

os.environ["QT_QPA_PLATFORM"] = "offscreen"
from osgeo import gdal

gdal.UseExceptions()
try:
    from qgis.core import QgsApplication, QgsRasterLayer, QgsVectorLayer
except ImportError:
    print("SKIPPED: python3-qgis is not installed")
    sys.exit(77)


def check(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def vector(folder, path, field, values):
    layer = QgsVectorLayer(str(folder / path), path, "ogr")
    check(layer.isValid(), f"{path} is not valid")
    renderer = layer.renderer()
    check(renderer.type() == "categorizedSymbol", f"{path}: drawn as {renderer.type()}")
    check(renderer.classAttribute() == field, f"{path}: by {renderer.classAttribute()}")
    categories = [c.value() for c in renderer.categories()]
    check(values <= set(categories), f"{path}: categories {categories}")
    check(all(c.symbol() and c.symbol().symbolLayerCount() == 1 for c in renderer.categories()), f"{path}: no symbol")
    colors = [c.symbol().color().name() for c in renderer.categories()]
    check(len(set(colors)) > 1, f"{path}: one colour for all")
    # Every feature has a category, or the one for all others.
    drawn = set(categories)
    seen = {f[field] for f in layer.getFeatures()}
    check(seen <= drawn or "" in drawn, f"{path}: {seen - drawn} are drawn as nothing")
    print(f"{path}: {layer.featureCount()} features, {len(categories)} categories")


def raster(folder):
    labels = QgsRasterLayer(str(folder / "labels.tif"), "labels")
    check(labels.isValid(), "labels.tif is not valid")
    check(labels.renderer().type() == "paletted", f"labels.tif: drawn as {labels.renderer().type()}")
    classes = {int(c.value): (c.label, c.color.name()) for c in labels.renderer().classes()}
    dataset = gdal.Open(str(folder / "labels.tif"))  # the band lives as long as it does
    table = json.loads(dataset.GetMetadataItem("ORTHODRIVE_CLASSES"))["classes"]
    expected = {
        value: (entry["name"], "#{:02x}{:02x}{:02x}".format(*entry["color"])) for value, entry in enumerate(table)
    }
    check(classes == expected, f"labels.tif: {len(classes)} classes, the first {classes.get(0)}, not {expected[0]}")
    palette = dataset.GetRasterBand(1).GetColorTable()
    for value, (name, color) in classes.items():
        check(
            "#{:02x}{:02x}{:02x}".format(*palette.GetColorEntry(value)[:3]) == color,
            f"labels.tif: {name} is {color} in the style only",
        )
    print(f"labels.tif: {len(classes)} classes")


def findings(folder):
    """The style of this build on one finding of each kind: a good site has none, and QGIS shows no empty layer."""
    with tempfile.TemporaryDirectory() as folder_name:
        features = [
            {
                "type": "Feature",
                "properties": {"severity": severity},
                "geometry": {"type": "Point", "coordinates": [15.0 + i, 50.0]},
            }
            for i, severity in enumerate(("info", "warning", "error"))
        ]
        scratch = pathlib.Path(folder_name)
        (scratch / "findings.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": features}))
        shutil.copy(folder / "findings.qml", scratch)
        vector(scratch, "findings.geojson", "severity", {"info", "warning", "error"})


def main():
    folder = pathlib.Path(sys.argv[1])
    if not (folder / "run.json").exists():
        print(f"SKIPPED: {folder} was not built")
        sys.exit(77)
    application = QgsApplication([], False)
    application.initQgis()
    raster(folder)
    vector(folder, "roads.gpkg|layername=centrelines", "highway", {"residential", "motorway", ""})
    vector(folder, "roads.gpkg|layername=surface", "highway", {"residential", "motorway", ""})
    vector(folder, "road_graph.geojson", "state", {"before", "after"})
    findings(folder)
    application.exitQgis()  # after every layer is gone


main()

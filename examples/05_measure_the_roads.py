#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Road length and width by class, out of what `orthodrive build` leaves behind; numpy and GDAL are all that is needed.

Usage: 05_measure_the_roads.py FOLDER     (the folder that was given to `orthodrive build -o`)

Read docs/build.md first: it lists the files. Three of them say the same in three ways, and this program compares them:
roads.gpkg has the centre lines, roads.xodr the roads of simulators, labels.tif the pixels that the roads were seen in.
"""

import json
import pathlib
import sys
import xml.etree.ElementTree

import numpy
from osgeo import gdal, ogr

gdal.UseExceptions()
ogr.UseExceptions()


def lengths_by_class(roads_gpkg):
    """Length in m and mean width in m, weighted by length, by the value of OSM's highway."""
    lengths, widths = {}, {}
    source = ogr.Open(str(roads_gpkg))  # the layer lives no longer than its file
    for road in source.GetLayerByName("centrelines"):
        length = road.geometry().Length()
        lengths[road["highway"]] = lengths.get(road["highway"], 0.0) + length
        widths[road["highway"]] = widths.get(road["highway"], 0.0) + length * road["width_m"]
    return {name: (length, widths[name] / length) for name, length in lengths.items()}


def network_length(roads_xodr):
    """Length in m of the roads outside junctions."""
    roads = xml.etree.ElementTree.parse(roads_xodr).getroot().iter("road")
    return sum(float(road.get("length")) for road in roads if road.get("junction") == "-1")


def road_area(labels_tif):
    """Area in m2 of the pixels that were labelled as road. The file carries its class table."""
    source = gdal.Open(str(labels_tif))
    classes = json.loads(source.GetMetadataItem("ORTHODRIVE_CLASSES"))["classes"]
    values = [value for value, entry in enumerate(classes) if entry["role"] == "road"]
    _, pixel_width, _, _, _, pixel_height = source.GetGeoTransform()
    return numpy.isin(source.ReadAsArray(), values).sum() * abs(pixel_width * pixel_height)


def main():
    folder = pathlib.Path(sys.argv[1])
    by_class = lengths_by_class(folder / "roads.gpkg")
    for name, (length, width) in sorted(by_class.items(), key=lambda item: -item[1][0]):
        print(f"{name:<16} {length:8.0f} m  {width:5.2f} m wide")
    total = sum(length for length, _ in by_class.values())
    carriageway = sum(length * width for length, width in by_class.values())
    print(f"in all {total:.0f} m, in roads.xodr {network_length(folder / 'roads.xodr'):.0f} m outside junctions")
    print(f"carriageways {carriageway:.0f} m2, seen in the photo {road_area(folder / 'labels.tif'):.0f} m2")


main()

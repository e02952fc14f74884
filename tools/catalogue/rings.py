# SPDX-License-Identifier: Apache-2.0
"""Outlines of Natural Earth as rings of degrees in the catalogue's TOML: for outlines and countries."""

from osgeo import ogr


def rings_of(geometry, least_deg2):
    """The outer rings of its parts from that size on, the largest first, to a hundredth of a degree."""
    if geometry.GetGeometryType() in (ogr.wkbPolygon, ogr.wkbPolygon25D):
        parts = [geometry]
    else:
        parts = [geometry.GetGeometryRef(i) for i in range(geometry.GetGeometryCount())]
    parts = sorted((p for p in parts if p.GetArea() >= least_deg2), key=lambda p: -p.GetArea())
    return [[(round(x, 2), round(y, 2)) for x, y, *_ in p.GetGeometryRef(0).GetPoints()] for p in parts]


def print_entry(table, texts, rings):
    """[[table]] with its texts, then the rings in lines of at most 160 characters."""
    print(f"\n[[{table}]]")
    for key, text in texts.items():
        print(f'{key} = "{text}"')
    print("rings = [")
    for ring in rings:
        line = "  ["
        for x, y in ring:
            item = f"[{x:g},{y:g}],"
            if len(line) + len(item) > 158:
                print(line)
                line = "   "
            line += item
        print(line.rstrip(",") + "],")
    print("]")

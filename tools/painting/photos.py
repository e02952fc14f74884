# SPDX-License-Identifier: Apache-2.0
"""Photos as arrays; a piece is cut out with what lies around it."""

import os

import numpy
from osgeo import gdal

gdal.UseExceptions()


def open_photo(folder, name):
    for ending in ("", ".jpg", ".png", ".tif"):
        path = os.path.join(folder, name + ending)
        if os.path.isfile(path):
            return gdal.Open(path)
    raise SystemExit(f"{folder}: no photo {name}")


def cut(photo, x_px, y_px, width_px, height_px):
    """RGB floats 0-255 of a box; what lies outside the photo repeats its border."""
    x0, y0 = max(x_px, 0), max(y_px, 0)
    x1, y1 = min(x_px + width_px, photo.RasterXSize), min(y_px + height_px, photo.RasterYSize)
    rgb = numpy.stack([photo.GetRasterBand(b).ReadAsArray(x0, y0, x1 - x0, y1 - y0) for b in (1, 2, 3)], axis=2)
    pad = ((y0 - y_px, y_px + height_px - y1), (x0 - x_px, x_px + width_px - x1), (0, 0))
    return numpy.pad(rgb.astype(numpy.float32), pad, mode="edge")


def piece_photo(photo, piece, gsd_m, size_m, margin_px=0):
    n = round(size_m / gsd_m)
    return cut(
        photo,
        round(piece.x_m / gsd_m) - margin_px,
        round(piece.y_m / gsd_m) - margin_px,
        n + 2 * margin_px,
        n + 2 * margin_px,
    )

# SPDX-License-Identifier: Apache-2.0
"""Seeds grown to regions: a pixel takes the class of the seeds nearest to it in colour, texture and place.

Meant for what has no sharp outline (lawn, bare trees, trodden soil); roads and buildings are drawn as polygons.
"""

import numpy
from osgeo import gdal, ogr
from scipy import ndimage
from scipy.spatial import cKDTree

from painting.sheet import CLASSES

SEED_RADIUS_M = 0.7
PLACE_M = 25.0  # so far away counts like one standard deviation of a feature
SMOOTH_M = 0.45
ASK_EVERY_M = 0.4  # pixels between have the answer of the nearest: the search is what takes time
SMALLEST_M2 = 3.0
SIMPLIFY_M = 0.2


def features(rgb, gsd_m):
    """Per pixel: brightness and two colour differences at two scales, roughness at two scales, each over its spread."""
    light = rgb.mean(axis=2)
    green_red, green_blue = rgb[:, :, 1] - rgb[:, :, 0], rgb[:, :, 1] - rgb[:, :, 2]

    def blur(a, metres):
        return ndimage.gaussian_filter(a, metres / gsd_m)

    light_log = numpy.log(light + 12.0)
    planes = []
    for plane, weight in ((light_log, 1.0), (green_red, 1.0), (green_blue, 1.0)):
        planes += [(blur(plane, 0.3), weight), (blur(plane, 1.2), weight)]
    for metres, weight in ((0.8, 1.0), (2.0, 1.0)):
        rough = numpy.sqrt(numpy.maximum(blur(light_log**2, metres) - blur(light_log, metres) ** 2, 0.0))
        planes.append((rough, weight))
    return numpy.stack([p / (p.std() + 1e-6) * w for p, w in planes], axis=2).astype(numpy.float32)


def grow(rgb, gsd_m, seeds, margin_px, taken):
    """Class index per pixel of the piece (rgb has a margin). `taken`: pixels that polygons cover; they take the class
    of the nearest pixel outside, because nobody sees it."""
    f = features(rgb, gsd_m)
    height, width = taken.shape
    f = f[margin_px : margin_px + height, margin_px : margin_px + width]
    rows, columns = numpy.mgrid[0:height, 0:width].astype(numpy.float32)
    f = numpy.dstack([f, columns * gsd_m / PLACE_M, rows * gsd_m / PLACE_M])
    samples, labels = [], []
    radius = SEED_RADIUS_M / gsd_m
    for label, x, y in seeds:
        disc = (columns + 0.5 - x / gsd_m) ** 2 + (rows + 0.5 - y / gsd_m) ** 2 <= radius**2
        samples.append(f[disc])
        labels.append(numpy.full(int(disc.sum()), CLASSES.index(label)))
    samples, labels = numpy.concatenate(samples), numpy.concatenate(labels)
    step = max(1, round(ASK_EVERY_M / gsd_m))
    asked = f[step // 2 :: step, step // 2 :: step]
    _, nearest = cKDTree(samples).query(asked.reshape(-1, f.shape[2]), k=min(7, len(samples)), workers=1)
    votes = labels[nearest].reshape(*asked.shape[:2], -1)
    votes = votes[numpy.minimum(numpy.arange(height) // step, len(votes) - 1)]
    votes = votes[:, numpy.minimum(numpy.arange(width) // step, votes.shape[1] - 1)]
    share = [
        ndimage.gaussian_filter(((votes == c).mean(axis=2) * ~taken).astype(numpy.float32), SMOOTH_M / gsd_m)
        for c in range(len(CLASSES))
    ]
    grown = numpy.argmax(numpy.stack(share), axis=0).astype(numpy.uint8)
    if taken.any() and not taken.all():
        at = ndimage.distance_transform_edt(taken, return_distances=False, return_indices=True)
        grown = grown[at[0], at[1]]
    return _sieve(grown, round(SMALLEST_M2 / gsd_m**2))


def _raster(array):
    data = gdal.GetDriverByName("MEM").Create("", array.shape[1], array.shape[0], 1, gdal.GDT_Byte)
    data.GetRasterBand(1).WriteArray(array)
    return data


def _sieve(array, smallest_px):
    data = _raster(array)
    gdal.SieveFilter(data.GetRasterBand(1), None, data.GetRasterBand(1), smallest_px, 4)
    return data.GetRasterBand(1).ReadAsArray()


def outlines(grown, gsd_m):
    """(class, ring in metres), larger ones first: holes are painted by what is in them, so that no ring has holes."""
    source = ogr.GetDriverByName("Memory").CreateDataSource("")
    layer = source.CreateLayer("", None, ogr.wkbPolygon)
    layer.CreateField(ogr.FieldDefn("class", ogr.OFTInteger))
    data = _raster(grown)
    gdal.Polygonize(data.GetRasterBand(1), None, layer, 0)
    coats = []
    for feature in layer:
        shape = feature.GetGeometryRef()
        filled = ogr.Geometry(ogr.wkbPolygon)
        filled.AddGeometry(shape.GetGeometryRef(0))
        area = filled.Area()
        simple = filled.SimplifyPreserveTopology(SIMPLIFY_M / gsd_m)
        ring = simple.GetGeometryRef(0)
        points = [(ring.GetX(i) * gsd_m, ring.GetY(i) * gsd_m) for i in range(ring.GetPointCount() - 1)]
        coats.append((area, CLASSES[feature.GetField("class")], points))
    coats.sort(key=lambda coat: (-coat[0], coat[1], coat[2]))
    return [(label, points) for _, label, points in coats]

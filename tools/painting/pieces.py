# SPDX-License-Identifier: Apache-2.0
"""Pieces as polygons: from the painter's sheet, to GeoJSON and back, and as label images.

GeoJSON features have `piece`, `class`, `photo` and `held_out`; later ones cover earlier ones. Coordinates are pixels of
the photo (x to the right, y down; the file says `"coordinates": "pixels"` and `gsd_m`), or longitude and latitude when
the photo has a position.
"""

import json
import math

import numpy
from osgeo import gdal
from PIL import Image, ImageDraw

from painting import grow, photos, snap
from painting.sheet import CLASSES, SIZE_M

MARGIN_PX = 40
REACH_M = {"building": 1.0, "water": 1.0}  # others:
REACH_OTHERS_M = 0.6
FINER = 4  # label images are drawn so many times finer, a pixel takes the class of its centre


def compose(piece, photo, gsd_m):
    """[(class, ring in metres)] in the order of painting, and what looks wrong."""
    rgb = photos.piece_photo(photo, piece, gsd_m, SIZE_M, MARGIN_PX)
    edges = snap.Edges(rgb, gsd_m, MARGIN_PX)
    drawn, faults = [], []
    for coat in piece.coats:
        for ring in coat.rings:
            clipped = ring
            if coat.snap and coat.label not in ("vegetation", "grass", "unknown"):
                clipped = snap.snap_ring(ring, edges, SIZE_M, REACH_M.get(coat.label, REACH_OTHERS_M))
                if crosses_itself(clipped):
                    clipped = ring
            if crosses_itself(clipped):
                faults.append(f"{piece.name}: {coat.label} at {ring[0][0]:.1f},{ring[0][1]:.1f} crosses itself")
            drawn.append((coat.label, clip_to_square(clipped)))
    drawn = [(label, ring) for label, ring in drawn if len(ring) >= 3]
    n = round(SIZE_M / gsd_m)
    taken = draw([(label, scaled(ring, 1 / gsd_m)) for label, ring in drawn], n) != 255
    under = []
    if piece.seeds:
        under = grow.outlines(grow.grow(rgb, gsd_m, piece.seeds, MARGIN_PX, taken), gsd_m)
        square = [(0.0, 0.0), (SIZE_M, 0.0), (SIZE_M, SIZE_M), (0.0, SIZE_M)]
        under = [(under[0][0] if under else "unknown", square), *under]
    elif not taken.all():
        faults.append(f"{piece.name}: {100 * (1 - taken.mean()):.1f} % is not painted")
    return under + drawn, faults


def crosses_itself(ring):
    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    n = len(ring)
    for i in range(n):
        a, b = ring[i], ring[(i + 1) % n]
        for j in range(i + 2, n):
            if i == 0 and j == n - 1:
                continue
            c, d = ring[j], ring[(j + 1) % n]
            if side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0:
                return True
    return False


def clip_to_square(ring):
    """Sutherland-Hodgman against the piece."""
    for axis, limit, keep_less in ((0, 0.0, False), (0, SIZE_M, True), (1, 0.0, False), (1, SIZE_M, True)):
        inside = [p[axis] <= limit if keep_less else p[axis] >= limit for p in ring]
        result = []
        for i, q in enumerate(ring):
            p = ring[i - 1]
            if inside[i - 1] != inside[i]:
                t = (limit - p[axis]) / (q[axis] - p[axis])
                result.append(tuple(p[k] + t * (q[k] - p[k]) for k in (0, 1)))
            if inside[i]:
                result.append(q)
        ring = result
        if not ring:
            break
    return ring


def scaled(ring, factor):
    return [(x * factor, y * factor) for x, y in ring]


def draw(coats, size_px):
    """Class index per pixel (255: not painted) of coats in pixels."""
    image = Image.new("L", (size_px * FINER, size_px * FINER), 255)
    pen = ImageDraw.Draw(image)
    for label, ring in coats:
        pen.polygon([(x * FINER - 0.5, y * FINER - 0.5) for x, y in ring], fill=CLASSES.index(label))
    return numpy.asarray(image)[FINER // 2 :: FINER, FINER // 2 :: FINER].copy()


def write_geojson(path, name, pieces, photo_of, gsd_m, lonlat):
    """Composes all pieces. Returns what looks wrong."""
    faults, lines = [], []
    for piece in pieces:
        photo = photo_of(piece.photo)
        coats, found = compose(piece, photo, gsd_m)
        faults += found
        for label, ring in coats:
            points = [((x + piece.x_m) / gsd_m, (y + piece.y_m) / gsd_m) for x, y in ring]
            if lonlat:
                t = photo.GetGeoTransform()
                points = [(round(t[0] + x * t[1], 8), round(t[3] + y * t[5], 8)) for x, y in points]
            else:
                points = [(round(x, 1), round(y, 1)) for x, y in points]
            properties = {"piece": piece.name, "class": label, "photo": piece.photo}
            if piece.held_out:
                properties["held_out"] = True
            feature = {
                "type": "Feature",
                "properties": properties,
                "geometry": {"type": "Polygon", "coordinates": [points + points[:1]]},
            }
            lines.append(json.dumps(feature, separators=(",", ":")))
    head = {"type": "FeatureCollection", "name": name}
    if not lonlat:
        head["coordinates"] = "pixels"
    head["gsd_m"] = gsd_m
    with open(path, "w", encoding="utf-8") as out:
        out.write(json.dumps(head)[:-1] + ',\n "features": [\n' + ",\n".join(lines) + "\n]}\n")
    return faults


class Painted:
    """A piece out of a GeoJSON file: coats in pixels of the photo, and its square there."""

    def __init__(self, name, photo, held_out):
        self.name, self.photo, self.held_out, self.coats = name, photo, held_out, []

    def box_px(self):
        points = [p for _, ring in self.coats for p in ring]
        xs, ys = [p[0] for p in points], [p[1] for p in points]
        return round(min(xs)), round(min(ys)), math.floor(max(xs) + 0.1), math.floor(max(ys) + 0.1)

    def labels(self):
        x0, y0, x1, y1 = self.box_px()
        return draw([(label, [(x - x0, y - y0) for x, y in ring]) for label, ring in self.coats], max(x1 - x0, y1 - y0))


def read_geojson(path, photo_of):
    with open(path, encoding="utf-8") as file:
        data = json.load(file)
    pieces = {}
    for feature in data["features"]:
        p = feature["properties"]
        if p["class"] not in CLASSES:
            raise SystemExit(f"{path}: class '{p['class']}' of piece {p['piece']} is unknown")
        piece = pieces.setdefault(p["piece"], Painted(p["piece"], p["photo"], p.get("held_out", False)))
        ring = [tuple(c) for c in feature["geometry"]["coordinates"][0][:-1]]
        if data.get("coordinates") != "pixels":
            inverse = gdal.InvGeoTransform(photo_of(p["photo"]).GetGeoTransform())
            ring = [
                (inverse[0] + x * inverse[1] + y * inverse[2], inverse[3] + x * inverse[4] + y * inverse[5])
                for x, y in ring
            ]
        piece.coats.append((p["class"], ring))
    return pieces, data["gsd_m"]

# SPDX-License-Identifier: Apache-2.0
"""How well two independent paintings of the hand-made test pieces agree: what a network can reach at most on them.

Prints JSON: road IoU, mean IoU over the classes, pixel accuracy, road IoU of each piece. Both paintings are drawn on a
grid of half a metre; `unknown` in either does not count.
"""

import itertools
import json

from measuring.common import ROOT

TRUTH = ROOT / "models/truth"
CLASSES = ["ground", "road", "parking", "building", "vegetation", "grass", "water", "rail"]
UNKNOWN, CELLS = len(CLASSES), 256


def features_of(file):
    pieces = {}
    for f in json.loads((TRUTH / file).read_text())["features"]:
        polygons = (
            [f["geometry"]["coordinates"]] if f["geometry"]["type"] == "Polygon" else f["geometry"]["coordinates"]
        )
        pieces.setdefault(f["properties"]["piece"], []).append((f["properties"]["class"], polygons))
    return pieces


def box_of(features):
    points = [p for _, polygons in features for rings in polygons for ring in rings for p in ring]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs), min(ys), max(xs), max(ys)


def draw(features, box):
    """Class numbers, north to south; even-odd over all rings, so holes are left out."""
    west, south, east, north = box
    grid = [[UNKNOWN] * CELLS for _ in range(CELLS)]
    for name, polygons in features:
        value = CLASSES.index(name) if name in CLASSES else UNKNOWN
        for rings in polygons:
            edges = [(a, b) for ring in rings for a, b in itertools.pairwise(ring) if a[1] != b[1]]
            for row in range(CELLS):
                y = north - (row + 0.5) * (north - south) / CELLS
                crossings = sorted(
                    a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for a, b in edges if (a[1] <= y) != (b[1] <= y)
                )
                for x0, x1 in zip(crossings[::2], crossings[1::2], strict=False):
                    first = max(0, round((x0 - west) / (east - west) * CELLS))
                    last = min(CELLS, round((x1 - west) / (east - west) * CELLS))
                    for col in range(first, last):
                        grid[row][col] = value
    return grid


def iou(counts, c):
    union = sum(counts[c]) + sum(row[c] for row in counts) - counts[c][c]
    return counts[c][c] / union if union else None


def add_arguments(parser):
    pass


def run(args):
    first, second = features_of("handmade.geojson"), features_of("second_painting.geojson")
    total = [[0] * len(CLASSES) for _ in CLASSES]
    pieces = {}
    for piece, features in sorted(first.items()):
        box = box_of(features)
        own = [[0] * len(CLASSES) for _ in CLASSES]
        for row_a, row_b in zip(draw(features, box), draw(second[piece], box), strict=True):
            for a, b in zip(row_a, row_b, strict=True):
                if a != UNKNOWN and b != UNKNOWN:
                    own[a][b] += 1
                    total[a][b] += 1
        pieces[piece] = round(iou(own, CLASSES.index("road")) or 0.0, 3)
    by_class = {name: round(iou(total, c), 3) for c, name in enumerate(CLASSES)}
    print(
        json.dumps(
            {
                "road_iou": by_class["road"],
                "mean_iou": round(sum(by_class.values()) / len(by_class), 3),
                "pixel_accuracy": round(sum(total[c][c] for c in range(len(CLASSES))) / sum(map(sum, total)), 3),
                "iou": by_class,
                "road_iou_of_pieces": pieces,
            },
            indent=1,
        )
    )

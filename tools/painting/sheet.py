# SPDX-License-Identifier: Apache-2.0
"""The painter's sheet: what is painted, as text. Coordinates are metres in the piece, x to the right, y down.

    piece NAME PHOTO X_M Y_M [held_out]     a square of 100 x 100 m; its top left corner in the photo
    grow CLASS x,y x,y ... | CLASS x,y ...  seeds; each pixel takes the class of the seeds it looks like (grow.py)
    CLASS x,y x,y x,y ...                   a polygon
    box CLASS x,y x,y x,y                   a rectangle: two corners and a third point on the side across
    line CLASS WIDTH_M x,y x,y ...          a stroke
    disc CLASS RADIUS_M x,y x,y ...         discs: crowns of trees

Later lines cover earlier ones. A class with ~ behind it is left where it was drawn, others are drawn to the edges in
the photo (snap.py). A # begins a comment.
"""

import math
from dataclasses import dataclass, field

CLASSES = ["ground", "road", "parking", "building", "vegetation", "grass", "water", "rail", "unknown"]
SIZE_M = 100.0


@dataclass
class Coat:
    """One shape as drawn: rings are lists of (x, y) in metres; `snap` draws it to the edges in the photo."""

    label: str
    rings: list
    snap: bool


@dataclass
class Piece:
    name: str
    photo: str
    x_m: float
    y_m: float
    held_out: bool = False
    seeds: list = field(default_factory=list)  # (class, x, y)
    coats: list = field(default_factory=list)
    faults: list = field(default_factory=list)


def read_sheets(files):
    """Pieces by name, in the order of the files. A piece that is given again replaces the earlier one."""
    pieces = {}
    for file in files:
        piece = None
        with open(file, encoding="utf-8") as lines:
            for number, line in enumerate(lines, 1):
                words = line.split("#")[0].split()
                if not words:
                    continue
                try:
                    if words[0] == "piece":
                        piece = Piece(words[1], words[2], float(words[3]), float(words[4]), "held_out" in words[5:])
                        pieces[piece.name] = piece
                    else:
                        _read_line(piece, words)
                except (ValueError, IndexError, AttributeError) as error:
                    raise SystemExit(f"{file}:{number}: {line.strip()[:80]}: {error}") from error
    return pieces


def _read_line(piece, words):
    if words[0] == "grow":
        label = None
        for word in words[1:]:
            if "," in word:
                piece.seeds.append((label, *_point(word)))
            elif word != "|":
                label = _label(word)[0]
    elif words[0] == "box":
        label, snap = _label(words[1])
        piece.coats.append(Coat(label, [_rectangle([_point(w) for w in words[2:]])], snap))
    elif words[0] == "line":
        label, snap = _label(words[1])
        piece.coats.append(Coat(label, [_stroke([_point(w) for w in words[3:]], float(words[2]))], snap))
    elif words[0] == "disc":
        label, _ = _label(words[1])
        for word in words[3:]:
            piece.coats.append(Coat(label, [_disc(_point(word), float(words[2]))], False))
    else:
        label, snap = _label(words[0])
        points = [_point(w) for w in words[1:]]
        if len(points) < 3:
            raise ValueError("a polygon has at least three points")
        piece.coats.append(Coat(label, [points], snap))


def _label(word):
    name = word.rstrip("~")
    if name not in CLASSES:
        raise ValueError(f"class '{name}' is unknown, use one of {' '.join(CLASSES)}")
    return name, name == word


def _point(word):
    x, y = word.split(",")
    return float(x), float(y)


def _rectangle(points):
    (ax, ay), (bx, by), (cx, cy) = points
    length = math.hypot(bx - ax, by - ay)
    nx, ny = -(by - ay) / length, (bx - ax) / length
    depth = (cx - bx) * nx + (cy - by) * ny
    return [(ax, ay), (bx, by), (bx + nx * depth, by + ny * depth), (ax + nx * depth, ay + ny * depth)]


def _stroke(points, width):
    """The band of a polyline, mitred at its bends."""
    left, right = [], []
    for i, (x, y) in enumerate(points):
        normals = []
        for a, b in ((i - 1, i), (i, i + 1)):
            if a >= 0 and b < len(points):
                dx, dy = points[b][0] - points[a][0], points[b][1] - points[a][1]
                length = math.hypot(dx, dy)
                normals.append((-dy / length, dx / length))
        nx, ny = sum(n[0] for n in normals), sum(n[1] for n in normals)
        scale = width / 2 * len(normals) / max(nx * nx + ny * ny, 0.5)
        left.append((x + nx * scale, y + ny * scale))
        right.append((x - nx * scale, y - ny * scale))
    return left + right[::-1]


def _disc(center, radius):
    return [
        (center[0] + radius * math.cos(k * math.pi / 8), center[1] + radius * math.sin(k * math.pi / 8))
        for k in range(16)
    ]

# SPDX-License-Identifier: Apache-2.0
"""Pictures for the painter: a piece with a grid in metres, and what was painted over it."""

import numpy
from PIL import Image, ImageDraw

from painting.sheet import CLASSES

COLORS = numpy.array(
    [
        (192, 163, 19),
        (76, 76, 76),
        (19, 163, 192),
        (230, 23, 23),
        (28, 115, 11),
        (115, 230, 92),
        (19, 62, 192),
        (153, 84, 15),
        (255, 0, 255),
    ],
    dtype=numpy.float32,
)  # those of the class table
EDGE_COLORS = [
    (255, 220, 0),
    (255, 255, 255),
    (0, 255, 255),
    (255, 40, 40),
    (0, 140, 0),
    (150, 255, 120),
    (60, 110, 255),
    (255, 140, 30),
    (255, 0, 255),
]
RULER_PX = 34


def enlarged(rgb, px):
    """Brightened a little, so that shadows can be read."""
    image = Image.fromarray(numpy.clip(rgb, 0, 255).astype(numpy.uint8)).resize((px, px), Image.LANCZOS)
    lut = [round(255 * (v / 255) ** 0.75) for v in range(256)] * 3
    return image.point(lut)


def with_ruler(image, x0_m, y0_m, x1_m, y1_m, grid_m):
    """A margin with numbers and thin lines every `grid_m`."""
    px = image.size[0]
    whole = Image.new("RGB", (px + RULER_PX, px + RULER_PX), (255, 255, 255))
    lines = Image.new("RGBA", image.size, (0, 0, 0, 0))
    pen, text = ImageDraw.Draw(lines), ImageDraw.Draw(whole)
    scale = px / (x1_m - x0_m)
    for k in range(int((x1_m - x0_m) / grid_m) + 1):
        at = k * grid_m * scale
        pen.line((at, 0, at, px), fill=(255, 255, 0, 90))
        pen.line((0, at, px, at), fill=(255, 255, 0, 90))
        text.text((RULER_PX + at - 6, 10), f"{x0_m + k * grid_m:g}", fill=(0, 0, 0))
        text.text((4, RULER_PX + at - 6), f"{y0_m + k * grid_m:g}", fill=(0, 0, 0))
    whole.paste(Image.alpha_composite(image.convert("RGBA"), lines).convert("RGB"), (RULER_PX, RULER_PX))
    return whole


def overlay(rgb, labels, px, opacity):
    """The photo with the classes' colours over it and lines between them."""
    base = numpy.asarray(enlarged(rgb, px)).astype(numpy.float32)
    at = (numpy.arange(px) * labels.shape[0] / px).astype(int)
    big = labels[at][:, at]
    color = numpy.vstack([COLORS, numpy.zeros((256 - len(CLASSES), 3), numpy.float32)])[big]
    mixed = base * (1 - opacity) + color * opacity
    edge = numpy.zeros(big.shape, bool)
    edge[:, 1:] |= big[:, 1:] != big[:, :-1]
    edge[1:] |= big[1:] != big[:-1]
    edge_color = numpy.vstack([numpy.array(EDGE_COLORS, numpy.float32), numpy.zeros((247, 3), numpy.float32)])[big]
    mixed[edge] = edge_color[edge]
    return Image.fromarray(mixed.astype(numpy.uint8))

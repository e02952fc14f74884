# SPDX-License-Identifier: Apache-2.0
"""Draws the sides of a polygon to edges in the photo.

Each side longer than `min_side_m` is moved along its normal to where the brightness changes most along the whole side,
at most `reach_m` away; the corners are where neighbouring sides meet. A side on the border of the piece stays.
"""

import math

import numpy
from scipy import ndimage

STEP_M = 0.1
FAINT = 3.0**0.5  # root of the grey levels a pixel, summed over the colours
PER_METRE = 0.10  # share of the best edge that a metre of way costs


class Edges:
    def __init__(self, rgb, gsd_m, margin_px):
        smooth = ndimage.gaussian_filter(rgb, (1.0, 1.0, 0.0))
        self.dx = ndimage.sobel(smooth, axis=1) / 8.0
        self.dy = ndimage.sobel(smooth, axis=0) / 8.0
        self.gsd_m, self.margin_px = gsd_m, margin_px

    def across(self, x_m, y_m, nx, ny):
        """Change of colour along the normal, at points in metres of the piece (arrays)."""
        at = [
            numpy.asarray(y_m) / self.gsd_m + self.margin_px - 0.5,
            numpy.asarray(x_m) / self.gsd_m + self.margin_px - 0.5,
        ]
        total = 0.0
        for band in range(3):
            gx = ndimage.map_coordinates(self.dx[:, :, band], at, order=1, mode="nearest")
            gy = ndimage.map_coordinates(self.dy[:, :, band], at, order=1, mode="nearest")
            total = total + gx * nx + gy * ny
        return total


def snap_ring(ring, edges, size_m, reach_m, min_side_m=2.0):
    count = len(ring)
    sides = []
    for i in range(count):
        (ax, ay), (bx, by) = ring[i], ring[(i + 1) % count]
        length = math.hypot(bx - ax, by - ay)
        if length == 0.0:
            sides.append(None)
            continue
        nx, ny = -(by - ay) / length, (bx - ax) / length
        shift = 0.0
        if length >= min_side_m and not _on_border(ax, ay, bx, by, size_m):
            shift = _best_shift(edges, (ax, ay), (bx, by), (nx, ny), length, reach_m)
        sides.append((ax + nx * shift, ay + ny * shift, bx + nx * shift, by + ny * shift, shift))
    return [_corner(sides[i - 1], sides[i], ring[i], reach_m, size_m) for i in range(count)]


def _on_border(ax, ay, bx, by, size_m):
    near = 0.3
    return any((a < near and b < near) or (a > size_m - near and b > size_m - near) for a, b in ((ax, bx), (ay, by)))


def _best_shift(edges, a, b, normal, length, reach_m):
    along = numpy.linspace(0.08, 0.92, max(6, int(length / 0.25)))
    x = a[0] + (b[0] - a[0]) * along
    y = a[1] + (b[1] - a[1]) * along
    shifts = numpy.arange(-reach_m, reach_m + STEP_M / 2, STEP_M)
    strength = []
    for shift in shifts:
        change = edges.across(x + normal[0] * shift, y + normal[1] * shift, *normal)
        strength.append(abs(numpy.mean(numpy.sign(change) * numpy.sqrt(abs(change)))))  # the root: no few pixels decide
    strength = ndimage.gaussian_filter1d(numpy.array(strength), 1.0)
    if strength.max() < FAINT:  # nothing to be seen: the painter knows better
        return 0.0
    return float(shifts[numpy.argmax(strength / strength.max() - PER_METRE * abs(shifts))])


def _corner(before, after, old, reach_m, size_m):
    if before is None or after is None:
        return old
    ax, ay, bx, by, _ = before
    cx, cy, dx, dy, _ = after
    cross = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
    lengths = math.hypot(bx - ax, by - ay) * math.hypot(dx - cx, dy - cy)
    if abs(cross) > 0.25 * lengths:
        t = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / cross
        p = (ax + t * (bx - ax), ay + t * (by - ay))
        if math.hypot(p[0] - old[0], p[1] - old[1]) <= 2.0 * reach_m:
            return p
    return ((bx + cx) / 2, (by + cy) / 2)

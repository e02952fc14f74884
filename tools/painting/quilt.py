# SPDX-License-Identifier: Apache-2.0
"""Textures quilted out of painted photos: Efros and Freeman, Image quilting for texture synthesis and transfer, 2001.

A texture is the detail of a class without its colour: each source patch is divided by its own mean, so that a tile
holds 128 where it is as bright as the patch around it. Tiles go on at their edges: patches at the last column and row
fit the first ones, too. Where the paper takes one of the patches within a tolerance of the least error, one of the best
sixteenth is taken: smooth patches fit each other best, and a tile would fill with one of them.
"""

import numpy

OVERLAP_SHARE = 0.25
BEST_SHARE = 1 / 16
CALM_SHARE = 0.95


def detail_patches(pictures, label, patch_px, most, random):
    """Patches that show one class alone, N x patch x patch x 3, around 1. `pictures`: pairs of photo and labels."""
    found = []
    for rgb, labels in pictures:
        is_class = labels == label
        if is_class.sum() < 4 * patch_px * patch_px:
            continue
        # Sums over squares of the mask: those that are whole.
        table = numpy.pad(is_class.astype(numpy.int64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        n = patch_px
        whole = table[n:, n:] - table[:-n, n:] - table[n:, :-n] + table[:-n, :-n] == n * n
        rows, cols = numpy.nonzero(whole)
        for i in random.permutation(len(rows))[:most]:
            patch = rgb[rows[i] : rows[i] + n, cols[i] : cols[i] + n] + 1.0
            found.append(numpy.rot90(patch / patch.mean(axis=(0, 1)), random.integers(4)))
    if not found:
        return numpy.zeros((0, patch_px, patch_px, 3))
    chosen = numpy.stack([found[i] for i in random.permutation(len(found))[:most]])
    unrest = chosen.var(axis=(1, 2)).sum(axis=1)  # cars and masts that were painted over
    return chosen[unrest <= numpy.quantile(unrest, CALM_SHARE)]


def cut(error):
    """The path of least error from the first to the last row: a column in each (section 2.1 of the paper)."""
    cost = error.copy()
    for row in range(1, len(cost)):
        before = numpy.pad(cost[row - 1], 1, constant_values=numpy.inf)
        cost[row] += numpy.minimum(numpy.minimum(before[:-2], before[1:-1]), before[2:])
    path = [int(cost[-1].argmin())]
    for row in range(len(cost) - 2, -1, -1):
        first = max(0, path[-1] - 1)
        path.append(first + int(cost[row, first : path[-1] + 2].argmin()))
    return numpy.array(path[::-1])


def taken_pixels(error, overlap, filled):
    """Of a new patch those pixels that are taken: beyond the cuts through its overlaps with what lies around it."""
    n = len(error)
    taken = numpy.ones((n, n), bool)
    columns, middle = numpy.arange(overlap), n // 2
    strips = (
        (filled[middle, 0], error, taken),
        (filled[middle, -1], error[:, ::-1], taken[:, ::-1]),
        (filled[0, middle], error.T, taken.T),
        (filled[-1, middle], error[::-1].T, taken[::-1].T),
    )
    for is_filled, of_error, of_taken in strips:  # left, right, top, bottom: views of one array
        if is_filled:
            of_taken[:, :overlap] &= columns[None, :] >= cut(of_error[:, :overlap])[:, None]
    return taken


def quilt(patches, tiles, random):
    """A square tile of so many patches a side, values around 1."""
    n = patches.shape[1]
    overlap = max(1, round(OVERLAP_SHARE * n))
    step = n - overlap
    size = tiles * step
    canvas, filled = numpy.ones((size, size, 3)), numpy.zeros((size, size), bool)
    for row in range(tiles):
        for col in range(tiles):
            at = numpy.ix_((numpy.arange(n) + row * step) % size, (numpy.arange(n) + col * step) % size)
            there, known = canvas[at], filled[at]
            errors = (((patches - there) ** 2).sum(axis=3) * known).sum(axis=(1, 2))
            best = numpy.argsort(errors, kind="stable")[: max(1, int(BEST_SHARE * len(patches)))]
            patch = patches[best[random.integers(len(best))]]
            taken = taken_pixels(((patch - there) ** 2).sum(axis=2), overlap, known) | ~known
            there[taken] = patch[taken]
            canvas[at] = there
            filled[at] = True
    return canvas

"""Lists of the Gaussians that touch each tile of the image, nearest first."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact, exact_part
from fsel.reconstruct.gaussians.projection import HALF_X, HALF_Y, LEAN, RANGE, XX, XY, YY, U, V

TILE = 8  # pixels
SLACK = 0.01  # pixels by which spans are widened: a pair too many costs time, one too few an error
DIGIT = 11  # bits sorted at a time


def by_depth(depth):
    """Return the stable order of positive float32 depths, nearest first, by a radix sort."""
    order, spare = np.arange(len(depth), dtype=np.int32), np.empty(len(depth), np.int32)
    ends = np.empty((1 << DIGIT) + 1, np.int64)
    for step in range(3):
        _sort(depth.view(np.uint32), DIGIT * step, order, ends, spare)
        order, spare = spare, order
    return order


@exact
def _sort(bits, shift, order, ends, ordered):
    """Fill an order sorted by a digit of numbers, the bits from `shift` on."""
    mask, shift = np.uint32((1 << DIGIT) - 1), np.uint32(shift)
    for b in range(len(ends)):
        ends[b] = 0
    for n in range(len(bits)):
        ends[((bits[n] >> shift) & mask) + 1] += 1
    for b in range(len(ends) - 1):
        ends[b + 1] += ends[b]
    for n in range(len(bits)):
        digit = (bits[order[n]] >> shift) & mask
        ordered[ends[digit]] = order[n]
        ends[digit] += 1


@exact
def arrange(order, place, rows, height, ordered, rank, lines, first, last):
    """Fill `first` to `last` of the Gaussians in (v,) order, and the (v,) int32 rank of each.

    `place` are the (v,) rows of `rows` that `projection.project` filled, and `lines`, (v, 2) int16,
    is filled with the first and last row of tiles of each Gaussian in order.
    """
    for n in range(first, last):
        rank[order[n]] = n
        for k in range(rows.shape[1]):
            ordered[n, k] = rows[place[order[n]], k]
        lines[n, 0], lines[n, 1] = _lines(ordered, n, height)


def assign(rows, lines, width, top, bottom):
    """Return the tiles of sorted Gaussians with a pixel centre where alpha is 1/255 or more.

    Only tiles of the rows of tiles `top` to `bottom`, the latter excluded.

    Args:
        rows, lines: (v, COLUMNS) projected Gaussians, nearest first, as `arrange` fills them.
        width: pixels.

    Returns:
        starts (tiles + 1,) int64 and members int32: those of tile t, row by row, are
        `members[starts[t] : starts[t + 1]]`, nearest first.
    """
    across = (width + TILE - 1) // TILE
    highest, lowest = np.maximum(lines[:, 0], top), np.minimum(lines[:, 1], bottom - 1)
    met = np.maximum(lowest.astype(np.int64) - highest + 1, 0).sum()
    starts, spans = np.zeros(across * (bottom - top) + 1, np.int64), np.empty((met, 3), np.int32)
    _cover(rows, lines, width, across, top, bottom, starts, spans)
    np.cumsum(starts, out=starts)
    members = np.empty(starts[-1], np.int32)
    _fill(spans, starts[:-1].copy(), members)
    return starts, members


@exact
def _cover(rows, lines, width, across, top, bottom, starts, spans):
    """Fill the (m, 3) Gaussian, first and last tile of each line of tiles that is met, and count
    the members of each tile after it in `starts`."""
    k = 0
    for n in range(len(rows)):
        for line in range(max(lines[n, 0], top), min(lines[n, 1], bottom - 1) + 1):
            first, last = _span(rows, n, line, width)
            before = (line - top) * across
            spans[k, 0], spans[k, 1], spans[k, 2] = n, before + first, before + last
            k += 1
            for at in range(before + first, before + last + 1):
                starts[at + 1] += 1


@exact
def _fill(spans, ends, members):
    for k in range(len(spans)):
        for at in range(spans[k, 1], spans[k, 2] + 1):
            members[ends[at]] = spans[k, 0]
            ends[at] += 1


def joined(bands):
    """Return starts and members of all tiles from those of bands of rows of tiles."""
    before = np.cumsum([0, *(len(members) for _, members in bands)])
    starts = [part[1:] + gone for (part, _), gone in zip(bands, before, strict=False)]
    return np.concatenate([bands[0][0][:1], *starts]), np.concatenate([m for _, m in bands])


@exact_part
def _lines(rows, n, height):
    """Return the first and last row of tiles that an ellipse may reach."""
    low = max(rows[n, V] - rows[n, HALF_Y] - 0.5 - SLACK, 0.0)
    high = min(rows[n, V] + rows[n, HALF_Y] - 0.5 + SLACK, height - 1.0)
    return int(np.ceil(low)) // TILE, int(np.floor(high)) // TILE


@exact_part
def _span(rows, n, line, width):
    """Return the first and last tile of a row whose pixel centres an ellipse may reach."""
    low = max(line * TILE + 0.5 - rows[n, V], -rows[n, HALF_Y])
    high = min(line * TILE + TILE - 0.5 - rows[n, V], rows[n, HALF_Y])
    if low > high:  # the ellipse ends between two rows of centres; rounding decides
        low = high = min(max(0.5 * (low + high), -rows[n, HALF_Y]), rows[n, HALF_Y])
    # how far below the middle the right end is farthest
    widest = rows[n, LEAN] * rows[n, HALF_X]
    right = _edge(rows, n, min(max(widest, low), high), 1.0)
    left = _edge(rows, n, min(max(-widest, low), high), -1.0)
    first = max(int(np.ceil(rows[n, U] + left - 0.5 - SLACK)), 0)
    last = min(int(np.floor(rows[n, U] + right - 0.5 + SLACK)), width - 1)
    if first > last:
        return 1, 0
    return first // TILE, last // TILE


@exact_part
def _edge(rows, n, y, side):
    """Return the left (-1) or right (1) end of the ellipse at a height, from its middle."""
    a, b, c = -2.0 * rows[n, XX], -1.0 * rows[n, XY], -2.0 * rows[n, YY]
    return (-b * y + side * np.sqrt(max(b * b * y * y - a * (c * y * y - rows[n, RANGE]), 0.0))) / a

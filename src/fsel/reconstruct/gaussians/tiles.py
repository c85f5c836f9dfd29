"""Which Gaussians touch which tile of the image, nearest first."""

from __future__ import annotations

import numpy as np

from fsel.reconstruct.gaussians.projection import (
    HALF_X,
    HALF_Y,
    LEAN,
    RANGE,
    XX,
    XY,
    YY,
    U,
    V,
)
from fsel.reconstruct.gaussians.table import jit

TILE = 8  # pixels
SLACK = 0.01  # pixels by which spans are widened: a pair too many costs time, one too few an error
DIGIT = 11  # bits sorted at a time


@jit
def by_depth(depth):
    """Order of positive float32 depths, nearest first, lowest index among equals: a radix sort."""
    count = len(depth)
    bits = depth.view(np.uint32)
    order, spare = np.arange(count).astype(np.int32), np.empty(count, np.int32)
    mask = np.uint32((1 << DIGIT) - 1)
    for step in range(3):
        shift = np.uint32(DIGIT * step)
        ends = np.zeros((1 << DIGIT) + 1, np.int64)
        for n in range(count):
            ends[((bits[n] >> shift) & mask) + 1] += 1
        for b in range(1 << DIGIT):
            ends[b + 1] += ends[b]
        for n in range(count):
            digit = (bits[order[n]] >> shift) & mask
            spare[ends[digit]] = order[n]
            ends[digit] += 1
        order, spare = spare, order
    return order


@jit
def sort_rows(depth, rows, source):
    """Projected Gaussians and their sources, nearest first."""
    order = by_depth(depth)
    ordered, origin = np.empty_like(rows), np.empty(len(order), np.int32)
    for n in range(len(order)):
        ordered[n] = rows[order[n]]
        origin[n] = source[order[n]]
    return ordered, origin


@jit
def assign(rows, width, height):
    """Tiles of sorted Gaussians: those with a pixel centre inside the ellipse where alpha is 1/255.

    Args:
        rows: (v, COLUMNS) projected Gaussians, nearest first.
        width: pixels.
        height: pixels.

    Returns:
        starts (tiles + 1,) int64 and members int32: those of tile t, a row of tiles after the
        other, are `members[starts[t] : starts[t + 1]]`, nearest first.
    """
    across, down = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    starts = np.zeros(across * down + 1, np.int64)
    for n in range(len(rows)):
        top, bottom = _lines(rows[n], height)
        for line in range(top, bottom + 1):
            first, last = _span(rows[n], line, width)
            for column in range(first, last + 1):
                starts[line * across + column + 1] += 1
    for t in range(across * down):
        starts[t + 1] += starts[t]
    ends = starts[:-1].copy()
    members = np.empty(starts[-1], np.int32)
    for n in range(len(rows)):
        top, bottom = _lines(rows[n], height)
        for line in range(top, bottom + 1):
            first, last = _span(rows[n], line, width)
            for column in range(first, last + 1):
                at = line * across + column
                members[ends[at]] = n
                ends[at] += 1
    return starts, members


@jit
def _lines(row, height):
    """First and last row of tiles that an ellipse may reach."""
    low = max(row[V] - row[HALF_Y] - 0.5 - SLACK, 0.0)
    high = min(row[V] + row[HALF_Y] - 0.5 + SLACK, height - 1.0)
    return int(np.ceil(low)) // TILE, int(np.floor(high)) // TILE


@jit
def _span(row, line, width):
    """First and last tile of a row of tiles whose pixel centres an ellipse may reach."""
    low = max(line * TILE + 0.5 - row[V], -row[HALF_Y])
    high = min(line * TILE + TILE - 0.5 - row[V], row[HALF_Y])
    if low > high:  # the ellipse ends between two rows of centres; rounding decides
        low = high = min(max(0.5 * (low + high), -row[HALF_Y]), row[HALF_Y])
    widest = row[LEAN] * row[HALF_X]  # where, from the middle down, the right end is farthest
    right = _edge(row, min(max(widest, low), high), 1.0)
    left = _edge(row, min(max(-widest, low), high), -1.0)
    first = max(int(np.ceil(row[U] + left - 0.5 - SLACK)), 0)
    last = min(int(np.floor(row[U] + right - 0.5 + SLACK)), width - 1)
    if first > last:
        return 1, 0
    return first // TILE, last // TILE


@jit
def _edge(row, y, side):
    """Left (-1) or right (1) end of the ellipse at a height, from its middle."""
    a, b, c = -2.0 * row[XX], -1.0 * row[XY], -2.0 * row[YY]
    return (-b * y + side * np.sqrt(max(b * b * y * y - a * (c * y * y - row[RANGE]), 0.0))) / a

"""The compiled greedy loop: what follows the picks, its z-scores, the network, the argmax.

Geometry and z-scores are float64; how the network is spared most candidates, and how the rest are
scored: `fsel.selector.screening`.
"""

from __future__ import annotations

import math

import numba
import numpy as np

from fsel.features.conditioned import ENOUGH, FEW, GROUP, NOVEL, SPREAD
from fsel.features.static import FLAT
from fsel.geometry import SAME_AXIS
from fsel.selector.screening import COLUMNS, best_row, highest, screen

UNSCORED = 1e30  # what a row could have whose score was never computed

_jit = numba.njit(cache=True, nogil=True, error_model="numpy")  # 1 / 0 is infinite
_fast = numba.njit(cache=True, nogil=True, fastmath=True)


@_jit
def memory(n, views):
    """What `fold` remembers of the picks, before the first.

    Args:
        n: rows.
        views: of the coverage input; 0 without it.

    Returns:
        squares, (3, n) squared distance and chords to the nearest pick, used without coverage;
        ranked, (3, 4, n) those to the nearest four, and crowd, (3, n) the sums of their inverses
        over all picks, used with it; covered, (O,) summed kernel of the picks; apart, (n,) look
        distance to the nearest pick, at most `NOVEL`.
    """
    used, plain = (n, 0) if views > 0 else (0, n)
    squares = np.full((3, plain), np.inf)
    ranked, crowd = np.full((3, GROUP, used), np.inf), np.zeros((3, used))
    return squares, ranked, crowd, np.zeros(views), np.full(n, NOVEL)


@_jit
def fold(row, selectable, relations, remembered, raw):
    """Fold one pick into what follows the selection.

    Args:
        row: the pick.
        selectable: (n,) bool, False for the picks, `row` among them.
        relations: centers, axes, bearings, (n, 3) float64; descriptors, (n, D) float32; kernel,
            (n, O), and looks, (n, 6), float64. D or O may be 0.
        remembered: see `memory`; changed.
        raw: (5, n) raw columns; changed.
    """
    centers, axes, bearings, descriptors, kernel, looks = relations
    squares, ranked, crowd, covered, apart = remembered
    count = len(selectable) - selectable.sum()
    if descriptors.shape[1] > 0:
        _likest(descriptors, row, count == 1, raw[2])
    if len(covered) == 0:
        _nearest(centers, row, squares[0], raw[0])
        _smallest_angle(axes, row, squares[1], raw[1])
        _smallest_angle(bearings, row, squares[2], raw[3])
        return
    for c, points in enumerate((centers, axes, bearings)):
        _company(points, row, count, ranked[c], crowd[c], raw[SPREAD[c]])
        _enough(selectable, raw[SPREAD[c]])
    for o in range(len(covered)):
        covered[o] += kernel[row, o]
    _least_apart(looks, row, apart)
    coverage_gain(kernel, covered, apart, raw[4])


@_jit
def _company(points, row, count, ranked, crowd, out):
    """Distance to the fourth nearest of few picks, or the inverse root of the summed inverse
    squares of many; see `fsel.features.conditioned`."""
    x, y, z = points[row, 0], points[row, 1], points[row, 2]
    for i in range(len(points)):
        out[i] = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
        crowd[i] += 1 / out[i]
    if count < FEW:
        last = min(count, GROUP) - 1
        for i in range(len(out)):
            gap = out[i]
            for r in range(GROUP):
                less = gap < ranked[r, i]
                ranked[r, i], gap = gap if less else ranked[r, i], ranked[r, i] if less else gap
            out[i] = math.sqrt(ranked[last, i])
    else:
        for i in range(len(out)):
            out[i] = 1 / math.sqrt(crowd[i])


@_jit
def _enough(selectable, out):
    """Bound a column by a multiple of its mean over the rows that are still selectable."""
    total, left = 0.0, 0
    for i in range(len(out)):
        if selectable[i]:
            total += out[i]
            left += 1
    ceiling = ENOUGH * total / max(left, 1)
    for i in range(len(out)):
        out[i] = min(out[i], ceiling)


@_jit
def _nearest(points, row, squares, out):
    x, y, z = points[row, 0], points[row, 1], points[row, 2]
    for i in range(len(points)):
        gap = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
        if gap < squares[i]:
            squares[i] = gap
            out[i] = math.sqrt(gap)


@_jit
def _smallest_angle(vectors, row, squares, out):
    """2 atan2(|a - b|, |a + b|), taken only where the chord |a - b| has shrunk."""
    x, y, z = vectors[row, 0], vectors[row, 1], vectors[row, 2]
    for i in range(len(vectors)):
        a, b, c = vectors[i, 0], vectors[i, 1], vectors[i, 2]
        chord = (a - x) ** 2 + (b - y) ** 2 + (c - z) ** 2
        if chord < squares[i]:
            squares[i] = chord
            total = (a + x) ** 2 + (b + y) ** 2 + (c + z) ** 2
            chord = math.sqrt(chord) if chord > SAME_AXIS**2 else 0.0
            out[i] = 2 * math.atan2(chord, math.sqrt(total))


@_fast
def _likest(descriptors, row, first, out):
    for i in range(len(descriptors)):
        likeness = 0.0
        for d in range(descriptors.shape[1]):
            likeness += np.float64(descriptors[i, d]) * np.float64(descriptors[row, d])
        if first or likeness > out[i]:
            out[i] = likeness


@_jit
def _least_apart(looks, row, out):
    for i in range(len(looks)):
        here, ahead = 0.0, 0.0
        for c in range(3):
            here += (looks[i, c] - looks[row, c]) ** 2
            ahead += (looks[i, c + 3] - looks[row, c + 3]) ** 2
        out[i] = min(out[i], math.sqrt(here) + math.sqrt(ahead))


@_fast
def coverage_gain(kernel, covered, apart, out):
    """Each row's mean closeness to the views, each view discounted by what covers it; in
    proportion less where the row looks much like one picked."""
    discount = 1 / (1 + covered)
    for i in range(len(kernel)):
        gain = 0.0
        for o in range(len(discount)):
            gain += kernel[i, o] * discount[o]
        out[i] = gain / max(len(discount), 1) * (apart[i] / NOVEL)


@_jit
def standardise_rows(raw, rows, out):
    """Write z-scores over the rows still selectable of all (5, n) columns but the last, the
    coverage gain, which is copied, to `out` (n, 5) float64.

    Population deviation; a flat column, and a row that was picked, becomes zero.
    """
    count = rows.sum()
    for i in range(len(rows)):
        out[i, COLUMNS - 1] = raw[COLUMNS - 1, i] if rows[i] else 0.0
    for c in range(COLUMNS - 1):
        column = raw[c]
        total = 0.0
        scale = 0.0
        for i in range(len(column)):
            if rows[i]:
                total += column[i]
                scale = max(scale, abs(column[i]))
        mean = total / max(count, 1)
        spread = 0.0
        for i in range(len(column)):
            if rows[i]:
                spread += (column[i] - mean) ** 2
        deviation = math.sqrt(spread / max(count, 1))
        factor = 1 / deviation if deviation > FLAT * scale else 0.0
        for i in range(len(column)):
            out[i, c] = (column[i] - mean) * factor if rows[i] else 0.0


@_jit
def run(k, columns, static, base, relations, layers, picks, scores):
    """The greedy loop (paper, Eq. 1 and 2).

    Args:
        k: how many picks.
        columns: (5,) the inputs that follow the selection.
        static: (n, 19) float64 inputs, without what those columns get from the selection.
        base: (n, 64) float32, see `screen`.
        relations: see `fold`.
        layers: float32 ones, see `screen`; float64 ones, see `exact_score`; bounds, see `highest`.
        picks: (k,) int64, written.
        scores: (k,) float64, written.
    """
    kernel = relations[4]
    narrow, wide, bounds = layers
    n = len(static)
    raw = np.zeros((COLUMNS, n))
    remembered = memory(n, kernel.shape[1])
    coverage_gain(kernel, remembered[3], remembered[4], raw[4])
    selectable = np.ones(n, np.bool_)
    inputs = np.empty((n, COLUMNS))
    seen, most = np.zeros((n, COLUMNS)), np.empty(n)
    approximate = np.full(n, np.float32(UNSCORED))
    for step in range(k):
        standardise_rows(raw, selectable, inputs)
        highest(approximate, inputs, seen, bounds, most)
        rows = screen(
            most, selectable, static, base, inputs, columns, (narrow, wide), approximate, seen
        )
        row, scores[step] = best_row(rows, approximate, static, inputs, columns, wide)
        picks[step] = row
        selectable[row] = False
        fold(row, selectable, relations, remembered, raw)

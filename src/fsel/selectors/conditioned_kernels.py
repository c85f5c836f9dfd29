"""The selection-conditioned columns, compiled: updated by each pick, in float64."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fsel.core.compiled import exact, exact_part, reordered, reordered_part
from fsel.core.geometry import SAME_AXIS
from fsel.features.columns import D_MIN_S, FOLLOWING, GAIN, GAMMA_MIN_S, PHI_NOV, RHO_MAX_S, SPREAD
from fsel.features.conditioned import BEST, ENOUGH, FEW, GROUP, NOVEL, POINTS, SECOND


class Memory(NamedTuple):
    """State of `update`: what it remembers of the picks.

    Attributes:
        squares: (3, n) squared distance and chords to the nearest pick, used without a target gain.
        ranked: (3, 4, n) those to the nearest four, used with it.
        inverse_sums: (3, n) the sums of their inverses over all picks, used with it.
        covered: (O,) summed closeness of the picks to each view.
        apart: (n,) look distance to the nearest pick, at most `NOVEL`.
        sights: (2, O, Q) of each point of each view, see `fsel.features.conditioned.with_sight`.
        gains: (O, M) what the nearest rows of each view would add to it.
    """

    squares: np.ndarray
    ranked: np.ndarray
    inverse_sums: np.ndarray
    covered: np.ndarray
    apart: np.ndarray
    sights: np.ndarray
    gains: np.ndarray


@exact
def begin(rows):
    """Return the raw columns, (5, n), and the memory before the first pick."""
    n, views = rows.closeness.shape
    used, plain = (n, 0) if views > 0 else (0, n)
    nearest, seen, _ = rows.visible
    memory = Memory(
        np.full((3, plain), np.inf),
        np.full((3, GROUP, used), np.inf),
        np.zeros((3, used)),
        np.zeros(views),
        np.full(n, NOVEL),
        np.zeros((2, len(nearest), seen.shape[2])),
        np.zeros(nearest.shape),
    )
    raw = np.zeros((FOLLOWING, n))
    for o in range(len(nearest)):
        _visibility_gains(rows.visible, o, memory)
    _gain(rows, memory, raw[GAIN])
    return raw, memory


@exact
def update(row, selectable, rows, memory, raw):
    """Update the memory and the (5, n) raw columns by one pick, no longer `selectable`."""
    count = len(selectable) - selectable.sum()
    if rows.descriptors.shape[1] > 0:
        _likest(rows.descriptors, row, count == 1, raw[RHO_MAX_S])
    if len(memory.covered) == 0:
        _nearest(rows.centers, row, memory.squares[0], raw[D_MIN_S])
        _smallest_angle(rows.axes, row, memory.squares[1], raw[GAMMA_MIN_S])
        _smallest_angle(rows.bearings, row, memory.squares[2], raw[PHI_NOV])
        return
    for c, points in enumerate((rows.centers, rows.axes, rows.bearings)):
        _spread(points, row, count, memory.ranked[c], memory.inverse_sums[c], raw[SPREAD[c]])
        _enough(selectable, raw[SPREAD[c]])
    for o in range(len(memory.covered)):
        memory.covered[o] += rows.closeness[row, o]
    _least_apart(rows.look_embedding, row, memory.apart)
    _look(rows.visible, row, memory)
    _gain(rows, memory, raw[GAIN])
    if count > rows.decay_start:
        for i in range(len(selectable)):
            raw[GAIN, i] *= rows.decay_start / count


@exact_part
def _spread(points, row, count, ranked, inverse_sums, out):
    """Distance to the fourth nearest of few picks, or the inverse root of the summed inverse
    squares of many; see `fsel.features.conditioned`."""
    x, y, z = points[row, 0], points[row, 1], points[row, 2]
    for i in range(len(points)):
        out[i] = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
        inverse_sums[i] += 1 / out[i]
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
            out[i] = 1 / math.sqrt(inverse_sums[i])


@exact_part
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


@exact_part
def _nearest(points, row, squares, out):
    x, y, z = points[row, 0], points[row, 1], points[row, 2]
    for i in range(len(points)):
        gap = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2 + (points[i, 2] - z) ** 2
        if gap < squares[i]:
            squares[i] = gap
            out[i] = math.sqrt(gap)


@exact_part
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


@reordered_part
def _likest(descriptors, row, first, out):
    for i in range(len(descriptors)):
        likeness = 0.0
        for d in range(descriptors.shape[1]):
            likeness += np.float64(descriptors[i, d]) * np.float64(descriptors[row, d])
        if first or likeness > out[i]:
            out[i] = likeness


@exact_part
def _least_apart(looks, row, out):
    for i in range(len(looks)):
        here, ahead = 0.0, 0.0
        for c in range(3):
            here += (looks[i, c] - looks[row, c]) ** 2
            ahead += (looks[i, c + 3] - looks[row, c + 3]) ** 2
        out[i] = min(out[i], math.sqrt(here) + math.sqrt(ahead))


@exact_part
def _look(visible, row, memory):
    """Count what a pick sees, in the views that it is near to."""
    nearest, seen, two = visible
    for o in range(len(nearest)):
        for m in range(nearest.shape[1]):
            if nearest[o, m] == row:
                first, second = memory.sights[0][o], memory.sights[1][o]
                for q, sight in enumerate(seen[o, m]):
                    if two:
                        second[q] = max(second[q], min(first[q], sight))
                    first[q] = max(first[q], sight) if two else first[q] + sight
                _visibility_gains(visible, o, memory)


@reordered_part
def _visibility_gains(visible, o, memory):
    """One view's part of `fsel.features.conditioned.visibility_gain`."""
    seen, out = visible.seen[o], memory.gains[o]
    first, second = memory.sights[0][o], memory.sights[1][o]
    count = len(visible.seen) * len(first)
    slope = (1 + first) * np.exp(-first) / count
    for m in range(len(seen)):
        gain = 0.0
        if visible.two:
            for q in range(len(first)):
                gain += (BEST - SECOND) * max(seen[m, q] - first[q], 0.0)
                gain += SECOND * max(seen[m, q] - second[q], 0.0)
            gain /= count
        else:
            for q in range(len(slope)):
                gain += seen[m, q] * slope[q]
        out[m] = gain


@exact_part
def _gain(rows, memory, out):
    """The target gain: closeness to the views, and their points that come into view."""
    target_gain(rows.closeness, memory.covered, memory.apart, out)
    nearest = rows.visible.nearest
    for o in range(len(nearest)):
        for m in range(nearest.shape[1]):
            out[nearest[o, m]] += POINTS * memory.gains[o, m]


@reordered
def target_gain(closeness, covered, apart, out):
    """Write each row's mean closeness to the views, each view discounted by what covers it; in
    proportion less where the row looks much like one picked."""
    discount = 1 / (1 + covered)
    for i in range(len(closeness)):
        gain = 0.0
        for o in range(len(discount)):
            gain += closeness[i, o] * discount[o]
        out[i] = gain / max(len(discount), 1) * (apart[i] / NOVEL)

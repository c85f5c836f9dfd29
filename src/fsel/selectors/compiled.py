"""The compiled greedy loop: z-scores of what follows the picks, the score, the argmax.

All of it is float64, but for a network's screening; how a network is spared most candidates, and
how the rest are scored: `fsel.selectors.screening`.
"""

from __future__ import annotations

import math

import numpy as np

from fsel.core.compiled import exact
from fsel.features.columns import FOLLOWING, GAIN
from fsel.features.static import FLAT
from fsel.selectors.following import begin, update
from fsel.selectors.screening import best_of, best_row, highest, screen

UNSCORED = 1e30  # what a row could have whose score was never computed


@exact
def _scale(column, selectable):
    """Mean of a column over the rows still selectable, and what its z-scores are multiplied by:
    one over the population deviation, or zero where the column is flat."""
    total, scale, count = 0.0, 0.0, 0
    for i in range(len(column)):
        if selectable[i]:
            total += column[i]
            scale = max(scale, abs(column[i]))
            count += 1
    mean = total / max(count, 1)
    spread = 0.0
    for i in range(len(column)):
        if selectable[i]:
            spread += (column[i] - mean) ** 2
    deviation = math.sqrt(spread / max(count, 1))
    return mean, 1 / deviation if deviation > FLAT * scale else 0.0


@exact
def standardise_rows(raw, selectable, out):
    """Write z-scores over the rows still selectable of all (5, n) columns but the target gain,
    which is copied, to `out` (n, 5) float64. A row that was picked becomes zero."""
    for i in range(len(selectable)):
        out[i, GAIN] = raw[GAIN, i] if selectable[i] else 0.0
    for c in range(GAIN):
        mean, factor = _scale(raw[c], selectable)
        for i in range(len(selectable)):
            out[i, c] = (raw[c, i] - mean) * factor if selectable[i] else 0.0


@exact
def run_linear(k, fixed, coefficients, rows, picks, scores):
    """The greedy loop (paper, Eq. 1 and 2) with a linear scorer.

    Args:
        k: how many picks.
        fixed: (n,) float64 part of the scores that no pick changes.
        coefficients: (5,) float64 of the inputs that follow the selection.
        rows: see `fsel.selectors.greedy.Rows`.
        picks: (k,) int64, written.
        scores: (k,) float64, written.
    """
    n = len(fixed)
    raw, memory = begin(rows)
    selectable, total = np.ones(n, np.bool_), np.empty(n)
    for step in range(k):
        total[:] = fixed
        for c in range(FOLLOWING):
            if coefficients[c] != 0:
                mean, factor = _scale(raw[c], selectable) if c != GAIN else (0.0, 1.0)
                for i in range(n):
                    total[i] += coefficients[c] * ((raw[c, i] - mean) * factor)
        row = best_of(total, selectable)
        picks[step], scores[step] = row, total[row]
        selectable[row] = False
        update(row, selectable, rows, memory, raw)


@exact
def run_network(k, static, base, rows, layers, picks, scores):
    """The greedy loop (paper, Eq. 1 and 2) with a network.

    Args:
        k: how many picks.
        static: (n, 19) float64 inputs, without what the selection adds to those that follow it.
        base: (n, 64) float32, see `screen`.
        rows: see `fsel.selectors.greedy.Rows`.
        layers: see `fsel.selectors.scorer.Layers`.
        picks: (k,) int64, written.
        scores: (k,) float64, written.
    """
    n = len(static)
    raw, memory = begin(rows)
    selectable = np.ones(n, np.bool_)
    inputs = np.empty((n, FOLLOWING))
    seen, most = np.zeros((n, FOLLOWING)), np.empty(n)
    approximate = np.full(n, np.float32(UNSCORED))
    for step in range(k):
        standardise_rows(raw, selectable, inputs)
        highest(approximate, inputs, seen, layers.bounds, most)
        open_rows = screen(most, selectable, static, base, inputs, layers, approximate, seen)
        row, scores[step] = best_row(open_rows, approximate, static, inputs, layers.wide)
        picks[step] = row
        selectable[row] = False
        update(row, selectable, rows, memory, raw)

"""The greedy loop in plain NumPy, for pools so small that compiling would take longer.

It picks what `fsel.selector.compiled` picks: the first run after an installation then needs no
compiler, and no run needs to import one. `benchmarks/selector.py` times both.
"""

from __future__ import annotations

import numpy as np

from fsel.features.conditioned import ENOUGH, FEW, GROUP, NOVEL, SPREAD
from fsel.geometry import viewing_angles
from fsel.selector.greedy import DYNAMIC, Prepared, standardise
from fsel.selector.scorer import Scorer

LARGEST_POOL = 1000  # rows; beyond, the compiled loop is faster even with its import
TIE = 450  # roundings of a score: a matrix product may part equal rows in their last bits


def greedy(
    prepared: Prepared, weights: dict[str, np.ndarray], k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pick k rows, the best-scored remaining one at each step (paper, Eq. 1 and 2).

    Arguments, returned arrays, ties and errors are those of `fsel.selector.greedy.greedy`. The
    arithmetic is that of `prepared.static`: float64, or float32 to see what that would cost.
    """
    scorer = Scorer(weights, {})
    n = len(prepared.pool)
    if not 1 <= k <= n:
        raise ValueError(f"k must be between 1 and the pool's {n} rows, got {k}")
    rows, scores = np.empty(k, np.int64), np.empty(k)
    free = np.ones(n, bool)
    precision = prepared.static.dtype
    tie = TIE * np.finfo(precision).eps
    raw = np.zeros((n, len(DYNAMIC)), precision)
    remembered = _Memory(prepared)
    raw[:, 4] = remembered.gain()
    inputs = prepared.static.copy()
    for step in range(k):
        inputs[:, DYNAMIC[:4]] = standardise(raw[:, :4], free)
        inputs[:, DYNAMIC[4]] = prepared.static[:, DYNAMIC[4]] + raw[:, 4]
        value = np.where(free, scorer.scores(inputs), -np.inf)
        best = value.max()
        rows[step] = np.argmax(value >= best - tie * abs(best))
        scores[step] = value[rows[step]]
        free[rows[step]] = False
        remembered.fold(rows[: step + 1], free, raw)
    return rows, scores


class _Memory:
    """What the picks leave behind; arrays are of the arithmetic's precision."""

    def __init__(self, prepared: Prepared) -> None:
        self.prepared = prepared
        (n, views), precision = prepared.kernel.shape, prepared.static.dtype
        self.covered = np.zeros(views, precision)
        self.apart = np.full(n, NOVEL, precision)
        self.squares = np.empty((len(SPREAD), 0, n), precision)

    def fold(self, rows: np.ndarray, free: np.ndarray, raw: np.ndarray) -> None:
        """Update the columns d_min_s, gamma_min_s, rho_max_s, phi_nov and coverage gain."""
        described, row, first = self.prepared.descriptors, rows[-1], len(rows) == 1
        likeness = np.einsum("nd,d->n", described, described[row], dtype=np.float64)
        raw[:, 2] = likeness if first else np.maximum(raw[:, 2], likeness)
        if len(self.covered) == 0:
            self._nearest(row, first, raw)
            return
        self._company(row, free, raw)
        self.covered += self.prepared.kernel[row]
        shift = (self.prepared.looks - self.prepared.looks[row]).reshape(-1, 2, 3)
        self.apart = np.minimum(self.apart, np.linalg.norm(shift, axis=2).sum(axis=1))
        raw[:, 4] = self.gain()

    def gain(self) -> np.ndarray:
        """(n,) see `compiled.coverage_gain`."""
        gain = self.prepared.kernel @ (1 / (1 + self.covered)) / max(len(self.covered), 1)
        return gain * (self.apart / NOVEL)

    def _nearest(self, row: int, first: bool, raw: np.ndarray) -> None:
        given = self.prepared
        nearest = {
            0: np.linalg.norm(given.centers - given.centers[row], axis=1),
            1: viewing_angles(given.axes, given.axes[row]),
            3: viewing_angles(given.bearings, given.bearings[row]),
        }
        for column, value in nearest.items():
            raw[:, column] = value if first else np.minimum(raw[:, column], value)

    def _company(self, row: int, free: np.ndarray, raw: np.ndarray) -> None:
        """See `fsel.features.conditioned`."""
        given = (self.prepared.centers, self.prepared.axes, self.prepared.bearings)
        new = [np.sum((points - points[row]) ** 2, axis=1) for points in given]
        self.squares = np.concatenate([self.squares, np.array(new)[:, None]], axis=1)
        picked = self.squares.shape[1]
        if picked < FEW:
            distance = np.sqrt(np.sort(self.squares, axis=1)[:, min(picked, GROUP) - 1])
        else:
            with np.errstate(divide="ignore"):  # a pick's own distance is zero, and so is its sum
                distance = 1 / np.sqrt((1 / self.squares).sum(axis=1))
        ceiling = ENOUGH * distance[:, free].mean(axis=1) if free.any() else np.zeros(len(SPREAD))
        raw[:, SPREAD] = np.minimum(distance, ceiling[:, None]).T

"""The greedy loop in plain NumPy, which picks what `fsel.selectors.compiled` picks, for pools so
small that importing or running a compiler would take longer."""

from __future__ import annotations

import numpy as np

from fsel.core.geometry import viewing_angles
from fsel.features.columns import (
    CONDITIONED_INPUTS,
    D_MIN_S,
    FOLLOWING,
    GAIN,
    GAMMA_MIN_S,
    PHI_NOV,
    RHO_MAX_S,
    SPREAD,
    TARGET_GAIN_INPUT,
)
from fsel.features.conditioned import (
    ENOUGH,
    FEW,
    GROUP,
    NOVEL,
    POINTS,
    visibility_gain,
    with_sight,
)
from fsel.selectors.greedy import Prepared, check_budget, standardise
from fsel.selectors.scorer import Scorer

LARGEST = 200_000  # rows times picks; beyond, the compiled loop is faster even with its import
TIE = 450  # roundings of a score: a matrix product may part equal rows in their last bits


def greedy(prepared: Prepared, scorer: Scorer, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Pick as `fsel.selectors.greedy.greedy`, one row at a time in the precision of
    `prepared.static`: float64, or float32 to see what that would cost."""
    check_budget(prepared, k)
    picks, scores = np.empty(k, np.int64), np.empty(k)
    tie = TIE * np.finfo(prepared.static.dtype).eps
    walk = Walk(prepared)
    for step in range(k):
        value = np.where(walk.free, scorer.scores(walk.inputs()), -np.inf)
        best = value.max()
        if step < len(prepared.given):
            picks[step] = prepared.given[step]
        else:
            picks[step] = np.argmax(value >= best - tie * abs(best))
        scores[step] = value[picks[step]]
        walk.add(picks[step])
    return picks, scores


class Walk:
    """The inputs of a pool's rows while rows are picked; `free` is (n,) bool, False once picked."""

    def __init__(self, prepared: Prepared) -> None:
        self._rows = rows = prepared.rows
        (n, views), precision = rows.closeness.shape, prepared.static.dtype
        self.free = np.ones(n, bool)
        self._inputs = prepared.static.copy()
        self._remote = prepared.static[:, TARGET_GAIN_INPUT]
        self._covered = np.zeros(views, precision)
        self._sights = np.zeros((2, *rows.visible.seen.shape[::2]), rows.visible.seen.dtype)
        self._apart = np.full(n, NOVEL, precision)
        self._squares = np.empty((len(SPREAD), 0, n), precision)
        self._raw = np.zeros((n, FOLLOWING), precision)
        self._raw[:, GAIN] = self._gain()

    def inputs(self) -> np.ndarray:
        """Return (n, 19) inputs at the present step."""
        self._inputs[:, CONDITIONED_INPUTS] = standardise(self._raw[:, :GAIN], self.free)
        self._inputs[:, TARGET_GAIN_INPUT] = self._remote + self._raw[:, GAIN]
        return self._inputs

    def add(self, row: int) -> None:
        """Pick a row."""
        rows, raw, first = self._rows, self._raw, self.free.all()
        self.free[row] = False
        described = rows.descriptors
        likeness = np.einsum("nd,d->n", described, described[row], dtype=np.float64)
        raw[:, RHO_MAX_S] = likeness if first else np.maximum(raw[:, RHO_MAX_S], likeness)
        if len(self._covered) == 0:
            nearest = {
                D_MIN_S: np.linalg.norm(rows.centers - rows.centers[row], axis=1),
                GAMMA_MIN_S: viewing_angles(rows.axes, rows.axes[row]),
                PHI_NOV: viewing_angles(rows.bearings, rows.bearings[row]),
            }
            for column, value in nearest.items():
                raw[:, column] = value if first else np.minimum(raw[:, column], value)
            return
        self._spread(row)
        self._covered += rows.closeness[row]
        self._sights = with_sight(self._sights, rows.visible, row)
        shift = (rows.look_embedding - rows.look_embedding[row]).reshape(-1, 2, 3)
        self._apart = np.minimum(self._apart, np.linalg.norm(shift, axis=2).sum(axis=1))
        picked = np.count_nonzero(~self.free)
        raw[:, GAIN] = self._gain() * min(1.0, rows.decay_start / picked)

    def _gain(self) -> np.ndarray:
        """Return (n,) target gains, see `fsel.selectors.conditioned_kernels.target_gain`."""
        gain = self._rows.closeness @ (1 / (1 + self._covered)) / max(len(self._covered), 1)
        seen = visibility_gain(self._rows.visible, self._sights, len(gain))
        return gain * (self._apart / NOVEL) + POINTS * seen

    def _spread(self, row: int) -> None:
        """Update the distances to the picks, see `fsel.features.conditioned`."""
        given = (self._rows.centers, self._rows.axes, self._rows.bearings)
        new = [np.sum((points - points[row]) ** 2, axis=1) for points in given]
        self._squares = np.concatenate([self._squares, np.array(new)[:, None]], axis=1)
        picked = self._squares.shape[1]
        if picked < FEW:
            nth = min(picked, GROUP) - 1
            distance = np.sqrt(np.sort(self._squares, axis=1)[:, nth])
        else:
            with np.errstate(divide="ignore"):  # a pick's own distance is zero, and so is its sum
                distance = 1 / np.sqrt((1 / self._squares).sum(axis=1))
        ceiling = np.zeros(len(SPREAD))
        if self.free.any():
            ceiling = ENOUGH * distance[:, self.free].mean(axis=1)
        self._raw[:, SPREAD] = np.minimum(distance, ceiling[:, None]).T

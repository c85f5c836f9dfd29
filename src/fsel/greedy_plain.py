"""The greedy loop in plain NumPy, for pools so small that compiling would take longer.

It picks what `fsel.greedy_kernel` picks: the first run after an installation then needs no
compiler, and no run needs to import one. `benchmarks/selector.py` times both.
"""

from __future__ import annotations

import numpy as np

from fsel.closeness import NOVEL
from fsel.geometry import viewing_angles
from fsel.scorer import Scorer
from fsel.selector import DYNAMIC, Prepared, standardise

LARGEST_POOL = 1000  # rows; beyond, the compiled loop is faster even with its import
TIE = 450  # roundings of a score: a matrix product may part equal rows in their last bits


def greedy(
    prepared: Prepared, weights: dict[str, np.ndarray], k: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pick k rows, the best-scored remaining one at each step (paper, Eq. 1 and 2).

    Arguments, returned arrays, ties and errors are those of `fsel.selector.greedy`. The arithmetic
    is that of `prepared.static`: float64, or float32 to see what that would cost.
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
    views = max(prepared.kernel.shape[1], 1)
    raw[:, 4] = prepared.kernel.sum(axis=1) / views
    covered = np.zeros(prepared.kernel.shape[1], precision)
    apart = np.full(n, NOVEL, precision)
    inputs = prepared.static.copy()
    for step in range(k):
        inputs[:, DYNAMIC[:4]] = standardise(raw[:, :4], free)
        inputs[:, DYNAMIC[4]] = prepared.static[:, DYNAMIC[4]] + raw[:, 4]
        value = np.where(free, scorer.scores(inputs), -np.inf)
        best = value.max()
        rows[step] = np.argmax(value >= best - tie * abs(best))
        scores[step] = value[rows[step]]
        free[rows[step]] = False
        covered += prepared.kernel[rows[step]]
        _fold(prepared, int(rows[step]), step == 0, covered, apart, raw)
    return rows, scores


def _fold(
    prepared: Prepared,
    row: int,
    first: bool,
    covered: np.ndarray,
    apart: np.ndarray,
    raw: np.ndarray,
) -> None:
    """Update the columns d_min_s, gamma_min_s, rho_max_s, phi_nov and coverage gain."""
    described = prepared.descriptors
    nearest = {
        0: np.linalg.norm(prepared.centers - prepared.centers[row], axis=1),
        1: viewing_angles(prepared.axes, prepared.axes[row]),
        3: viewing_angles(prepared.bearings, prepared.bearings[row]),
    }
    likeness = np.einsum("nd,d->n", described, described[row], dtype=np.float64)
    for column, value in nearest.items():
        raw[:, column] = value if first else np.minimum(raw[:, column], value)
    raw[:, 2] = likeness if first else np.maximum(raw[:, 2], likeness)
    shift = (prepared.looks - prepared.looks[row]).reshape(-1, 2, 3)
    np.minimum(apart, np.linalg.norm(shift, axis=2).sum(axis=1), out=apart)
    gain = prepared.kernel @ (1 / (1 + covered)) / max(len(covered), 1)
    raw[:, 4] = gain * (apart / NOVEL)

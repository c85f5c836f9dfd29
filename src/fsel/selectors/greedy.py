"""The greedy loop around a scorer (paper, section 3.3): what no pick changes is computed once."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import ModuleType
from typing import NamedTuple

import numpy as np

from fsel.features.columns import FOLLOWING_INPUTS
from fsel.features.conditioned import Visibility
from fsel.features.static import FLAT
from fsel.selectors.scorer import Linear, Network, Scorer, layers_of


def loop() -> ModuleType:
    """Return the compiled loop, imported when first used, since numba takes long to import."""
    from fsel.selectors import compiled

    return compiled


class Rows(NamedTuple):
    """Poses and appearance by which the n rows of a pool are compared, with O views.

    Attributes:
        centers: (n, 3) float64 camera centres, relative to their mean.
        axes: (n, 3) unit optical axes.
        bearings: (n, 3) unit directions from the common reference point.
        descriptors: (n, D) float32; D = 0 when appearance is not read.
        closeness: (n, O) float64 of row and view, for the target gain; O = 0 when it is not read.
        look_embedding: (n, 6) float64, see `fsel.features.conditioned.look_embedding`.
        visible: what the rows see of the views, for the target gain.
        decay_start: picks after which the target gain counts less, in inverse proportion.
    """

    centers: np.ndarray
    axes: np.ndarray
    bearings: np.ndarray
    descriptors: np.ndarray
    closeness: np.ndarray
    look_embedding: np.ndarray
    visible: Visibility
    decay_start: float = np.inf


@dataclass(frozen=True)
class Prepared:
    """Everything that a greedy selection needs and that no pick changes.

    Attributes:
        pool: (n,) int64 frames, ascending; the rows of everything below.
        static: (n, 19) float64 standardised inputs less what follows the selection; of the target
            gain, minus the penalty of far views.
        rows: what they are compared by.
        given: (g,) int64 rows that are picked first.
    """

    pool: np.ndarray
    static: np.ndarray
    rows: Rows
    given: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))


def standardise(columns: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
    """Standardise (n, c) columns by mean and deviation over some rows; flat ones become zero."""
    used = columns if rows is None else columns[rows]
    mean, deviation = used.mean(axis=0), used.std(axis=0)
    informative = deviation > FLAT * np.abs(used).max(axis=0)
    scaled = (columns - mean) / np.where(informative, deviation, 1.0)
    return np.where(informative, scaled, 0.0)


def greedy(prepared: Prepared, scorer: Scorer, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Pick k rows, the best-scored remaining one at each step, the lowest of equals (paper, Eq. 1
    and 2); return (k,) int64 rows in pick order and (k,) float64 scores; ValueError unless 1 <= k
    <= n."""
    check_budget(prepared, k)
    picks, scores = np.empty(k, np.int64), np.empty(k)
    if isinstance(scorer, Linear):
        fixed = scorer.scores(prepared.static)
        loop().run_linear(k, fixed, scorer.vector[FOLLOWING_INPUTS], prepared.rows, picks, scores)
    else:
        assert isinstance(scorer, Network)
        static, weights = prepared.static, scorer.weights
        base = static.astype(np.float32) @ weights["layer1.weight"].T + weights["layer1.bias"]
        loop().run_network(k, static, base, prepared.rows, layers_of(scorer), picks, scores)
    return picks, scores


def check_budget(prepared: Prepared, k: int) -> None:
    """Refuse to pick no row, or more than there are."""
    if not 1 <= k <= len(prepared.pool):
        raise ValueError(f"k must be between 1 and the pool's {len(prepared.pool)} rows, got {k}")

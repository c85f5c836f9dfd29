"""FisherRF: the view that tells most about the splats' colours (Jiang, Lei and Daniilidis 2024)."""

from __future__ import annotations

import numpy as np

from fsel.core.compiled import exact
from fsel.core.problem import Method, Problem
from fsel.selectors.baselines.splat_views import Blends, fitted, greedily

DAMPING = 1e-6  # the released default of lambda


class Information:
    """Criterion trace(H(view) (H(picks) + lambda I)^-1) with diagonal H, exact for colours.

    A pixel is linear in the colour of a splat, with its blending weight as the slope: the diagonal
    is the sum of squared weights over pixels.
    """

    def __init__(self, blends: Blends, damping: float = DAMPING) -> None:
        self.blends = blends
        self.known = np.full(blends.splats.shape[1], damping)

    def scores(self) -> np.ndarray:
        blends = self.blends
        return _information(blends.start, blends.index, blends.square, 1 / self.known)

    def add(self, row: int) -> None:
        part = slice(*self.blends.start[row : row + 2])
        self.known[self.blends.index[part]] += self.blends.square[part]


@exact
def _information(start, index, square, per_known):
    """(V,) sums of a view's squares, each divided by what is known of its splat."""
    total = np.zeros(len(start) - 1)
    for view in range(len(total)):
        for e in range(start[view], start[view + 1]):
            total[view] += square[e] * per_known[index[e]]
    return total


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """Pick (k,) int64 frames of the pool, each the one of largest information gain."""
    return greedily(problem, k, lambda *seen: Information(fitted(*seen, sparse=True)))


METHOD = Method(
    "fisher_rf", "FisherRF", "observed", nested=True, select=select, tracks=True, begins=True
)

"""The untrained control: the scorer's features, sign-corrected and summed (paper, Appendix D.3)."""

from __future__ import annotations

import numpy as np

from fsel.features.static import SIGNS
from fsel.problem import Method, Problem
from fsel.selector.greedy import untrained_select


def select(problem: Problem, k: int, rng: np.random.Generator) -> np.ndarray:
    """The greedy loop with the sum of z-scores in place of the network."""
    return untrained_select(problem, k, SIGNS)


METHOD = Method(
    "untrained",
    "Untrained sum",
    "candidates",
    nested=True,
    seeds=1,
    select=select,
    reads=("appearance", "sharpness"),
)

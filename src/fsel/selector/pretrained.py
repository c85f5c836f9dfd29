"""The policy `fsel` with the linear rule that comes with the package."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from fsel.problem import Problem
from fsel.selector import greedy, plain
from fsel.selector.policies import POLICIES
from fsel.selector.scorer import Linear

POLICY = POLICIES["fsel"]
FILE = "fsel.json"
FOLDER = Path(__file__).parent / "weights"


@cache
def scorer() -> Linear:
    """The shipped coefficients with their provenance; `make weights` remakes them."""
    return Linear.load(FOLDER / FILE)


def ranked(problem: Problem, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Pick k of all frames that may be used, with the shipped scorer.

    Args:
        problem: the selection problem.
        k: at most the size of the pool.

    Returns:
        (k,) int64 frames in pick order, and (k,) float64 their scores when picked.
    """
    prepared = POLICY.prepare(problem)
    small = k * len(prepared.pool) <= plain.LARGEST
    pick = plain.greedy if small else greedy.greedy
    rows, scores = pick(prepared, scorer(), k)
    return prepared.pool[rows], scores
